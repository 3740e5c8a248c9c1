// What the host offers to plugins: the extensions of somas::Host.
#pragma once

#include <atomic>
#include <string>

#include "somas/sdk/log.hpp"

namespace somas::plugins {

/// The host as one library sees it; lives until the process ends. Messages go to spdlog's default
/// logger with the library's id before them.
class HostServices final : public Host, public Log {
 public:
  static constexpr unsigned most_messages = 100;

  explicit HostServices(std::string library) : library_(std::move(library)) {}

  [[nodiscard]] std::string_view version() const override;
  [[nodiscard]] void* extension(std::string_view id) const override;
  void write(LogLevel level, std::string_view text) noexcept override;

 private:
  std::string library_;
  std::atomic<unsigned> messages_ = 0;
};

}  // namespace somas::plugins
