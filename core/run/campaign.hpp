// The plan of a campaign: its conditions, the seeds and directories of its runs. Pure functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/experiment/sweep.hpp"
#include "core/run/json.hpp"

namespace somas::run {

/// A combination of levels.
struct Condition {
  std::string name;                        ///< also of its directory: "mutation=0.2+controller=grn"
  std::vector<std::string> levels;         ///< one per factor
  std::vector<experiment::Override> sets;  ///< what it replaces in the experiment
};

/// One run. Its seed is that of the experiment + replicate - 1, whatever the condition: conditions
/// face the same random numbers, and nothing that is added to a campaign changes what is there.
struct PlannedRun {
  std::size_t condition = 0;
  std::uint64_t replicate = 1;
  std::uint64_t seed = 1;
  std::filesystem::path directory;  ///< relative to the campaign's
};

struct Campaign {
  std::string experiment;      ///< its name
  std::filesystem::path file;  ///< as it was given
  std::string original_yaml;
  std::filesystem::path directory;  ///< as it was given when the campaign began
  std::uint64_t seed = 1;
  std::uint64_t replicates = 1;
  std::vector<std::string> factors;  ///< names
  std::vector<Condition> conditions;
  std::vector<std::string> overrides;              ///< --set
  std::vector<std::string> sweeps;                 ///< --sweep
  std::vector<std::filesystem::path> plugin_path;  ///< absolute
  std::vector<std::string> command_line;
  std::optional<std::uint64_t> generations{};  ///< of all runs, once extended

  /// By condition, then replicate.
  [[nodiscard]] std::vector<PlannedRun> runs() const;
  /// The arguments that do the same run by itself.
  [[nodiscard]] std::vector<std::string> command_of(const PlannedRun& run,
                                                    std::size_t genomes) const;
};

/// Conditions of a design, the last factor changing fastest; their names differ.
[[nodiscard]] std::vector<Condition> conditions_of(const experiment::Design& design);

/// conditions/NAME.yaml: every key of a condition with its value.
[[nodiscard]] std::filesystem::path condition_file(const std::filesystem::path& campaign,
                                                   const Condition& condition);

[[nodiscard]] Json campaign_to_json(const Campaign& campaign);
/// Reads campaign.json and experiment.yaml. Throws UsageError.
[[nodiscard]] Campaign read_campaign(const std::filesystem::path& directory);

/// Whether a campaign has begun in the directory.
[[nodiscard]] bool holds_campaign(const std::filesystem::path& directory);

}  // namespace somas::run
