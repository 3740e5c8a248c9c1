// index.csv and summary.csv of a campaign: what became of its runs. docs/campaigns.md describes the
// columns. Nothing in them depends on the clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/run/campaign.hpp"

namespace somas::run {

enum class RunStatus { waiting, running, complete, stopped, failed };

/// What a run directory says of its run.
struct RunStanding {
  RunStatus status = RunStatus::waiting;
  std::uint64_t generations = 0;  ///< finished; the next five are of them
  double best = 0;
  std::uint64_t best_generation = 0;
  double final_best = 0, final_median = 0;
  std::uint64_t set_aside = 0;
  std::string reason;  ///< why it failed
};

/// As a run directory is on the disk: `complete` if it says so itself; one without a run waits, and
/// one that was killed. Throws UsageError for a damaged one, WriteError.
[[nodiscard]] RunStanding standing_of(const std::filesystem::path& run);

/// `standings`: by run, as Campaign::runs() has them.
[[nodiscard]] std::string index_csv(const Campaign& campaign,
                                    const std::vector<RunStanding>& standings);
/// Statistics of the complete runs of each condition.
[[nodiscard]] std::string summary_csv(const Campaign& campaign,
                                      const std::vector<RunStanding>& standings);

}  // namespace somas::run
