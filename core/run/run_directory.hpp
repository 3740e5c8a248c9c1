// A run on disk. Layout:
//
//   experiment.yaml          the experiment file, byte for byte
//   resolved.yaml            every key with its value; loads again
//   manifest.json            where the run came from
//   generations.csv          a line a generation; the line is the last thing written of one
//   individuals.csv          a line an individual: lineage
//   champions/gen-0000.json  the best of each generation, with its recorded life
//   champions/gen-0000-2.json  the same of the second population, in mode coevolution
//   recordings/gen-0003.h5   recorded lives, if the experiment wants them
//   genomes/given-0.json     saved genomes that seeded the first generation, if any
//   states/                  worlds in mid-life that a replay saved, if any
//   timing.csv               all that depends on the clock
//   summary.json             how the run ended
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/evolution/ranking.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "core/run/manifest.hpp"

namespace somas::run {

/// An evaluated generation of one population.
struct Generation {
  std::uint64_t number = 0;
  const evolution::Population* population = nullptr;
  evolution::Statistics statistics;
  Champion champion;
  std::uint64_t evaluations = 0;         ///< simulations
  std::uint64_t censored = 0;            ///< of them, alive at the end
  std::uint64_t refused_divisions = 0;   ///< by the cap on cells, summed
  double cell_steps = 0;                 ///< summed
  std::vector<std::string> opponents{};  ///< of each individual; empty in mode solo
};

struct Timing {
  double seconds = 0;
  unsigned threads = 1;
};

/// champions/gen-NNNN.json; of the second population champions/gen-NNNN-2.json.
[[nodiscard]] std::filesystem::path champion_path(const std::filesystem::path& run,
                                                  std::uint64_t generation,
                                                  std::uint32_t population = 1);

/// The greatest generation with a champion in `run`. Throws UsageError if there is none.
[[nodiscard]] std::uint64_t last_generation(const std::filesystem::path& run);

/// The champion's id that generations.csv has for a generation; nothing if it has none.
[[nodiscard]] std::optional<std::uint64_t> champion_id(const std::filesystem::path& run,
                                                       std::uint64_t generation,
                                                       std::uint32_t population = 1);

/// Makes the directory of a new run: `out`, which must be absent or empty (UsageError), or
/// runs/NAME-seedSEED, with -2, -3, ... as often as it takes. Throws WriteError.
[[nodiscard]] std::filesystem::path make_run_directory(
    const std::optional<std::filesystem::path>& out, const std::string& name, std::uint64_t seed);

/// The files of a run in the making. All calls throw WriteError.
class RunDirectory {
 public:
  /// Writes what is known at the start into an empty directory.
  RunDirectory(std::filesystem::path path, const experiment::Experiment& experiment,
               const Json& manifest, std::span<const GivenGenome> genomes);

  /// A generation gets onto the disk whole, one record per population; if it cannot, nothing of it
  /// stays.
  void commit(std::span<const Generation> populations, const evolution::Heredity& heredity,
              const Timing& timing);
  /// Replaces the summary.
  void summarize(const Json& summary);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  GenomeOwners owners_;
  evolution::Mode mode_;
  std::optional<AppendFile> individuals_, timing_, generations_;
};

}  // namespace somas::run
