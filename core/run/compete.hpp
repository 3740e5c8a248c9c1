// Saved genomes in one world, on seeds that no evolution has seen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/experiment/experiment.hpp"

namespace somas::run {

struct CompeteOptions {
  std::vector<std::filesystem::path> genomes;  ///< champions' files, or genomes alone
  bool against_random = false;                 ///< and one of fresh random genes in each world
  std::uint32_t seeds = 30;                    ///< worlds, 1 to 1000
  unsigned threads = 0;                        ///< 0: one per processor
};

/// What became of all competitors in one world.
struct Bout {
  std::uint64_t seed = 0;
  std::vector<evaluation::Row> rows;  ///< in the order of the competitors
};

struct CompeteReport {
  std::string experiment, objective;
  std::vector<std::string> competitors;  ///< the files as given, then "random"
  std::vector<Bout> bouts;
  std::vector<std::string> warnings;
};

/// Lets the genomes compete in `seeds` worlds, a pure function of the experiment with its seed and
/// of the set of genomes: keys and places go by the genomes' bytes, not by their order, and move on
/// by one from world to world. Throws UsageError (fewer than two competitors, genomes that do not
/// fit), PluginError.
[[nodiscard]] CompeteReport compete(const experiment::Experiment& experiment,
                                    const CompeteOptions& options);

/// Worlds in which each competitor scored more than all others, and those without such a one.
struct Wins {
  std::vector<std::uint64_t> of;
  std::uint64_t ties = 0;
};
[[nodiscard]] Wins wins_of(const CompeteReport& report);

/// Two-sided sign test: the probability that fair coins fall at least as unevenly as `first` to
/// `second`; 1 if both are 0. At most 1000 in all.
[[nodiscard]] double sign_test(std::uint64_t first, std::uint64_t second);

/// A line a world, then means, wins and sign tests against the first competitor.
[[nodiscard]] std::string to_text(const CompeteReport& report);
/// "seed,competitor,genome,survival,censored,biomass_share,score,peak_cells", a line per organism.
[[nodiscard]] std::string to_csv(const CompeteReport& report);

}  // namespace somas::run
