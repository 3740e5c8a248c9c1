// A champion lives again: to prove a record, or to ask what would have been otherwise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/run/champion.hpp"

namespace somas::run {

struct ReplayOptions {
  std::filesystem::path run;
  std::optional<std::uint64_t> generation;  ///< default: the last
  std::uint32_t population = 1;             ///< whose champion: 2 in mode coevolution only
  std::vector<std::string> overrides;       ///< --set; any makes the replay a what-if, unchecked
  std::vector<std::filesystem::path> plugin_directories;  ///< default: those of the run
  Observer observer;                                      ///< sees every step
};

struct ReplayReport {
  Champion recorded;
  Recording replayed;
  bool what_if = false;
  std::vector<std::string> warnings;     ///< plugins that changed, an edited genome
  std::vector<std::string> differences;  ///< from the record, the first step first; empty: proved

  [[nodiscard]] bool matches() const { return differences.empty(); }
};

/// Throws UsageError, experiment::InputError, model::PluginFailure.
[[nodiscard]] ReplayReport replay(const ReplayOptions& options);

/// What a replay found, for people: several lines.
[[nodiscard]] std::string to_text(const ReplayReport& report);

}  // namespace somas::run
