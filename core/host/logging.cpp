#include "core/host/logging.hpp"

#include <memory>
#include <mutex>
#include <string_view>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

namespace somas::host {
namespace {

/// A message is a line that stays, above the status line.
class TerminalSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit TerminalSink(run::Terminal& terminal) : terminal_(terminal) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    std::string_view line(text.data(), text.size());
    while (line.ends_with('\n')) line.remove_suffix(1);
    terminal_.line(line);
  }
  void flush_() override {}

  run::Terminal& terminal_;
};

}  // namespace

void log_to(run::Terminal& terminal) {
  auto logger = std::make_shared<spdlog::logger>("somas", std::make_shared<TerminalSink>(terminal));
  logger->set_pattern("%l: %v");
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace somas::host
