// Runs an experiment into a directory, and goes on with a run that was stopped.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/stop.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/coordinator.hpp"
#include "core/run/terminal.hpp"
#include "core/run/watcher.hpp"

namespace somas::run {

struct RunOptions {
  std::filesystem::path file{};                  ///< the experiment, for the manifest
  std::optional<std::filesystem::path> out{};    ///< run directory; default under runs/
  evaluation::Backend* backend = nullptr;        ///< null: `threads` of this process
  unsigned threads = 0;                          ///< 0: one per processor
  bool quiet = false;                            ///< no progress
  Watcher* watcher = nullptr;                    ///< instead of progress on the terminal
  std::vector<std::filesystem::path> genomes{};  ///< saved genomes that seed the first generation
  std::vector<std::filesystem::path> plugin_path{};  ///< for the manifest
  std::vector<std::string> command_line{};           ///< for the manifest
};

/// Runs an experiment into a directory of its own. Throws UsageError, PluginError (the offending
/// genome is saved), WriteError; generations that were finished stay on disk in every case.
[[nodiscard]] RunReport run(const experiment::Experiment& experiment, const RunOptions& options,
                            Terminal& terminal, evaluation::StopToken stop);

/// Whether saved genomes can seed a run of the experiment. Throws UsageError.
void check_genomes(const std::vector<std::filesystem::path>& files,
                   const experiment::Experiment& experiment);

struct ResumeOptions {
  std::filesystem::path run{};                       ///< the run directory
  std::optional<std::uint64_t> generations{};        ///< in all; extends the run
  bool accept_changes = false;                       ///< of plugins, experiment, host
  std::vector<std::filesystem::path> plugin_path{};  ///< instead of the run's own
  evaluation::Backend* backend = nullptr;            ///< null: `threads` of this process
  unsigned threads = 0;                              ///< 0: one per processor
  bool quiet = false;                                ///< no progress
  Watcher* watcher = nullptr;                        ///< instead of progress on the terminal
};

/// Goes on with a run, wherever it ended; a run that is complete is left as it is. Throws as run()
/// does, and UsageError for a directory without a run, one that is in use, a damaged store, and for
/// plugins, an experiment or a host that have changed, unless that is accepted.
[[nodiscard]] RunReport resume(const ResumeOptions& options, Terminal& terminal,
                               evaluation::StopToken stop);

}  // namespace somas::run
