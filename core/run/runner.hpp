// The loop of an experiment: genomes -> evaluation -> champion -> run directory -> next genomes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/stop.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/terminal.hpp"

namespace somas::run {

struct RunOptions {
  std::filesystem::path file{};                  ///< the experiment, for the manifest
  std::optional<std::filesystem::path> out{};    ///< run directory; default under runs/
  evaluation::Backend* backend = nullptr;        ///< null: `threads` of this process
  unsigned threads = 0;                          ///< 0: one per processor
  bool quiet = false;                            ///< no progress
  std::vector<std::filesystem::path> genomes{};  ///< saved genomes that seed the first generation
  std::vector<std::filesystem::path> plugin_path{};  ///< for the manifest
  std::vector<std::string> command_line{};           ///< for the manifest
};

struct RunReport {
  std::filesystem::path directory;
  std::uint64_t generations = 0;  ///< finished, all on disk
  double best = 0;                ///< fitness over all of them
  std::uint64_t best_generation = 0;
  bool stopped = false;  ///< by the token, before the last generation
};

/// Runs an experiment into a directory of its own. Throws UsageError, PluginError (the offending
/// genome is saved), WriteError; generations that were finished stay on disk in every case.
[[nodiscard]] RunReport run(const experiment::Experiment& experiment, const RunOptions& options,
                            Terminal& terminal, evaluation::StopToken stop);

}  // namespace somas::run
