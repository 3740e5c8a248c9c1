// Before a campaign starts: all of its conditions loaded and checked, and what it will cost.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/stop.hpp"
#include "core/experiment/experiment.hpp"
#include "core/experiment/sweep.hpp"
#include "core/run/campaign.hpp"

namespace somas::run {

/// A condition that has been loaded.
struct CheckedCondition {
  std::string resolved_yaml;
  std::uint64_t generations = 0, evaluations = 0;  ///< of a run; of one of its generations
};

struct CampaignPlan {
  Campaign campaign;
  std::vector<CheckedCondition> conditions;
  std::vector<experiment::Experiment> samples;  ///< a few of them, wired

  /// Simulations of all runs together.
  [[nodiscard]] std::uint64_t evaluations() const;
};

/// What the user asks for.
struct CampaignRequest {
  std::filesystem::path file;
  std::vector<std::string> overrides{};              ///< --set
  std::vector<std::string> sweeps{};                 ///< --sweep, for the record
  std::vector<std::filesystem::path> plugin_path{};  ///< --plugin-path
  std::vector<std::filesystem::path> genomes{};      ///< that seed the first generation of all runs
  std::vector<std::string> command_line{};
};

/// Loads every condition. Throws InputError and UsageError with what is wrong in any of them, also
/// for conditions that are one and the same experiment.
[[nodiscard]] CampaignPlan plan_campaign(const experiment::Design& design,
                                         const CampaignRequest& request);

/// Loads the conditions of a campaign that has begun, from its directory. Throws the same.
[[nodiscard]] CampaignPlan reload_campaign(const std::filesystem::path& directory,
                                           Campaign campaign);

/// The campaign with the levels that its file and these --sweep give its factors. Throws UsageError
/// unless all conditions that are there stay as they are.
[[nodiscard]] CampaignPlan with_more_levels(const std::filesystem::path& directory,
                                            const Campaign& campaign,
                                            const std::vector<std::string>& sweeps);

/// How a condition of a campaign that has begun is loaded, but for its seed.
[[nodiscard]] experiment::LoadOptions load_options(const Campaign& campaign);

struct CampaignCost {
  std::uint64_t evaluations = 0;
  double per_second = 0;  ///< evaluations of random organisms; 0: none ended while we looked
  double bytes = 0;       ///< on the disk, without recordings
};

/// Lets organisms of a few first generations live, for some seconds at most.
[[nodiscard]] CampaignCost cost_of(const CampaignPlan& plan, evaluation::Backend& backend,
                                   evaluation::StopToken stop);

/// Conditions, runs, seeds and evaluations, for people; lists up to `most` conditions.
[[nodiscard]] std::string plan_text(const CampaignPlan& plan, std::size_t most = 50);
/// "4 conditions x 3 replicates = 12 runs, seeds 1 to 3".
[[nodiscard]] std::string size_text(const Campaign& campaign);
/// "cost: 28800 evaluations; ...".
[[nodiscard]] std::string cost_text(const CampaignCost& cost);

}  // namespace somas::run
