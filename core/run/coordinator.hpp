// The loop of a run: genomes -> evaluation -> champion -> run directory -> next genomes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/contest.hpp"
#include "core/run/journal.hpp"
#include "core/run/recordings.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/watcher.hpp"

namespace somas::run {

struct RunReport {
  std::filesystem::path directory;
  std::uint64_t generations = 0;  ///< finished, all on disk
  std::uint64_t planned = 0;
  double best = 0;  ///< fitness over all of them
  std::uint64_t best_generation = 0;
  bool stopped = false;  ///< by the token, before the last generation
};

/// One run, from where its directory stands to the last generation.
class Coordinator {
 public:
  struct Parts {
    const experiment::Experiment& experiment;
    evaluation::Evaluator& evaluator;
    unsigned workers = 1;  ///< for the record
    RunDirectory& directory;
    Watcher* watcher = nullptr;  ///< may be none
    evaluation::StopToken stop{};
    unsigned world_threads = 1;  ///< that share a large world where lives are recorded
  };
  /// All that `parts` refers to must outlive this. `given`: genomes that seed the first generation.
  Coordinator(const Parts& parts, std::vector<model::Genome> given);

  /// Throws PluginError (the offending genome is saved), WriteError; generations that were finished
  /// stay on disk in every case, and so do single evaluations.
  RunReport all_generations();

 private:
  bool generation(std::uint64_t number);
  void reproduce(std::uint64_t number);
  [[nodiscard]] std::optional<Journal::Evaluated> evaluate(std::uint64_t number);
  void note_reference();
  void refuse_if_all_failed(std::uint64_t number, const std::vector<evaluation::Result>& results);
  [[noreturn]] void fail(std::uint64_t number, std::size_t task,
                         const evaluation::Failure& failure);
  void absorb(const Journal::Evaluated& evaluated, std::size_t population, Generation& record);
  bool record_champion(const Journal::Evaluated& evaluated, std::size_t population,
                       Generation& record);
  [[nodiscard]] Champion first_trial_of(std::uint64_t number, std::size_t population,
                                        std::size_t index) const;
  bool record_all(std::uint64_t number, std::size_t population);
  void note(const std::vector<Generation>& records);
  void summarize(const char* status);

  const experiment::Experiment& experiment_;
  const evolution::Settings& settings_;
  evolution::Heredity heredity_;
  evaluation::Evaluator& evaluator_;
  unsigned workers_;
  RunDirectory& directory_;
  Watcher* watcher_;
  evaluation::StopToken stop_;
  std::vector<model::Genome> given_;
  Journal journal_;
  Recordings recordings_;
  std::vector<evolution::Population> populations_;  ///< of the last generation, or the present one
  std::vector<FormerChampion> former_;              ///< by generation, for the hall of fame
  std::optional<Contest> contest_;                  ///< of the present generation
  bool reference_noted_ = false;
  RunReport report_;
};

}  // namespace somas::run
