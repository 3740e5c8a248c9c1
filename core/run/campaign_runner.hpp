// Carries out a campaign: several runs at a time, all of whose simulations share one backend.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/stop.hpp"
#include "core/run/campaign_plan.hpp"
#include "core/run/terminal.hpp"

namespace somas::run {

/// Why a run failed.
enum class RunFault { none, input, plugin, disk, evaluators, internal };

struct CampaignReport {
  std::filesystem::path directory;
  std::uint64_t runs = 0, conditions = 0, complete = 0, failed = 0;
  RunFault fault = RunFault::none;  ///< of the first run that failed, in the order of index.csv
  bool stopped = false;             ///< by the token, or by a fault that is everybody's
  std::optional<double> best;       ///< fitness over all runs
  std::string best_run;             ///< its directory, relative
};

struct CampaignOptions {
  evaluation::Backend* backend = nullptr;
  std::uint64_t at_once = 0;  ///< runs; 0: enough to keep the backend busy
  bool quiet = false;         ///< no progress
  /// Where a plugin crashes this process, it goes on without the run that did: the words that
  /// follow "resume DIRECTORY". Nothing: it ends.
  std::optional<std::vector<std::string>> restart{};
};

/// Makes the directory and runs all runs into it. A run that fails is noted and the others go on;
/// a full disk, or evaluators that are lost to all, stop the campaign. Throws UsageError,
/// WriteError.
[[nodiscard]] CampaignReport run_campaign(const CampaignPlan& plan,
                                          const std::optional<std::filesystem::path>& out,
                                          const std::vector<std::filesystem::path>& genomes,
                                          const CampaignOptions& options, Terminal& terminal,
                                          evaluation::StopToken stop);

struct CampaignResumeOptions {
  std::filesystem::path directory;
  std::optional<std::uint64_t> replicates;   ///< in all: adds some
  std::optional<std::uint64_t> generations;  ///< in all: extends all runs
  std::vector<std::string> sweeps;           ///< --sweep: factors that get more levels
  bool accept_changes = false;
  std::vector<std::filesystem::path> plugin_path;  ///< instead of the campaign's own
};

/// Goes on with a campaign, wherever it ended: runs that are complete are left as they are, all
/// others, also those that failed, go on. Throws as run_campaign() does, and UsageError for a
/// directory without a campaign, one in use, or an extension that would change what is there.
[[nodiscard]] CampaignReport resume_campaign(const CampaignResumeOptions& resume,
                                             const CampaignOptions& options, Terminal& terminal,
                                             evaluation::StopToken stop);

}  // namespace somas::run
