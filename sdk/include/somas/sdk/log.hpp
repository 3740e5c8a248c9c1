/// @file
/// Messages of plugins to the person who runs them, by way of the host.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string_view>

#include "somas/sdk/extension.hpp"

namespace somas {

/// How much a message matters.
enum class LogLevel : std::uint32_t {
  debug = 0,    ///< for the author of a plugin; somas-host does not show them
  info = 1,     ///< good to know
  warning = 2,  ///< the run goes on, but perhaps not as it was meant
  error = 3     ///< something failed; the exception that ends the run says what
};

/// The host's log.
class Log {
 public:
  /// What a host answers to.
  static constexpr std::string_view extension_id = "somas.log/1";
  /// A line of UTF-8, without its end. The host prints it with the library's id before it, and
  /// drops what exceeds a hundred lines of a library. Any thread. Does not throw.
  virtual void write(LogLevel level, std::string_view text) noexcept = 0;

 protected:
  ~Log() = default;
};

/// What the host is to a plugin's library, from its loading until the process ends.
class Host : public Extensible {
 public:
  /// Of SOMAS: "0.1.0".
  [[nodiscard]] virtual std::string_view version() const = 0;
};

namespace detail {

/// Each library has its own; null before the host has loaded it, and in a plugin's own tests.
inline const Host* host = nullptr;

inline void attach(const Host* to) { host = to; }

}  // namespace detail

/// Tells the person at the keyboard something: `somas::log(somas::LogLevel::warning, "text")`.
/// Messages are no results: they are not recorded, and a run does not depend on them. Without a
/// host (in a plugin's own tests) they go to the standard error. Any thread; allocates in the host.
inline void log(LogLevel level, std::string_view text) noexcept {
  if (detail::host != nullptr) {
    if (Log* log = extension_of<Log>(*detail::host)) log->write(level, text);
    return;
  }
  std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

}  // namespace somas
