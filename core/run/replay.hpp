// A champion lives again: to prove a record, or to ask what would have been otherwise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/recording/sink.hpp"
#include "core/run/champion.hpp"
#include "core/run/state_file.hpp"

namespace somas::run {

/// Who receives a replayed life, and what of it; what is not said is as the `record` of the run
/// says.
struct Recipient {
  recording::Sink* sink = nullptr;
  std::optional<std::uint64_t> every = {}, fields_every = {};  ///< see recording::RecorderOptions
  std::optional<bool> controller = {};
};

struct ReplayOptions {
  std::filesystem::path run;
  std::optional<std::uint64_t> generation;  ///< default: the last
  std::uint32_t population = 1;             ///< whose champion: 2 in mode coevolution only
  std::vector<std::string> overrides;       ///< --set; any makes the replay a what-if, unchecked
  std::vector<std::filesystem::path> plugin_directories;  ///< default: those of the run
  Observer observer;                                      ///< sees every step
  std::vector<Recipient> recipients = {};
  /// Hears whose life it will be, before the first step.
  std::function<void(const Champion&)> prelude = {};
  /// Where to begin: before a step, or with a state file; default: at birth. Overrides hold from
  /// there on, and must leave the vocabulary of the world and the genome's fit as they are.
  std::optional<std::uint64_t> from_step;
  std::optional<std::filesystem::path> from_state;
  std::vector<model::Wound> wounds;      ///< at the beginning; any makes the replay a what-if
  std::optional<std::uint64_t> save_at;  ///< the state to keep: that before this step
  unsigned world_threads = 1;            ///< that share a large world; never changes anything
};

/// The beginning of a replay in mid-life.
struct Beginning {
  std::uint64_t step = 0;
  std::optional<std::filesystem::path> file;  ///< the state file that it came from
  std::vector<std::uint32_t> removed;         ///< cells, by wound
};

struct ReplayReport {
  Champion recorded;
  LifeRecord replayed;
  bool what_if = false;
  std::optional<Beginning> beginning;    ///< of a replay in mid-life
  std::optional<SavedState> saved;       ///< where the life up to it is the recorded one
  std::vector<std::string> warnings;     ///< plugins that changed, an edited genome
  std::vector<std::string> differences;  ///< from the record, the first step first; empty: proved

  [[nodiscard]] bool matches() const { return differences.empty(); }
};

/// Throws UsageError, experiment::InputError, model::PluginFailure.
[[nodiscard]] ReplayReport replay(const ReplayOptions& options);

/// What a replay found, for people: several lines.
[[nodiscard]] std::string to_text(const ReplayReport& report);

}  // namespace somas::run
