#include "core/plugins/services.hpp"

#include <spdlog/spdlog.h>

namespace somas::plugins {
namespace {

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return spdlog::level::debug;
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      return spdlog::level::warn;
    case LogLevel::error:
      return spdlog::level::err;
  }
  return spdlog::level::info;  // a level of a later SDK
}

}  // namespace

std::string_view HostServices::version() const { return SOMAS_VERSION; }

void* HostServices::extension(std::string_view id) const {
  if (id == Log::extension_id) return static_cast<Log*>(const_cast<HostServices*>(this));
  return nullptr;
}

void HostServices::write(LogLevel level, std::string_view text) noexcept {
  const unsigned before = messages_.fetch_add(1);
  if (before > most_messages) {
    messages_ = most_messages + 1;  // so that it never wraps
    return;
  }
  try {
    if (before == most_messages)
      spdlog::warn("{}: more than {} messages; further ones are dropped", library_, most_messages);
    else
      spdlog::log(spdlog_level(level), "{}: {}", library_, text);
  } catch (...) {
    // A message that cannot be written must not end a run.
  }
}

}  // namespace somas::plugins
