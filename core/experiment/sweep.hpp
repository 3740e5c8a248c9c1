// The keys `replicates` and `sweep` of an experiment file: which runs make a campaign.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"

namespace somas::experiment {

/// What a factor may be.
struct Level {
  std::string value;           ///< as YAML in one line, or the level's name
  std::vector<Override> sets;  ///< what it replaces in the experiment
};

/// What differs between conditions: a key with its values, or a name with named levels.
struct Factor {
  std::string name;  ///< the key, or the name
  std::vector<Level> levels;
};

/// All conditions are the product of the levels, the last factor's changing fastest; without
/// factors there is one.
struct Design {
  std::string name;  ///< of the experiment
  std::uint64_t seed = 1;
  std::uint64_t replicates = 1;
  std::vector<Factor> factors;
  std::string original_yaml;  ///< the file, byte for byte

  [[nodiscard]] std::uint64_t conditions() const;
  /// No sweep and no second replicate.
  [[nodiscard]] bool is_one_run() const { return factors.empty() && replicates == 1; }
};

struct DesignOptions {
  std::vector<std::string> overrides{};  ///< --set, in order
  /// --sweep KEY=VALUE,VALUE,...; takes the place of the file's factor of that name.
  std::vector<std::string> sweeps{};
  bool always = false;  ///< also where nobody says a word of a campaign
};

struct Node;
class Problems;

/// Adds what is wrong with the `sweep` of a whole file, as far as it shows without loading.
void check_sweep(const Node& root, Problems& problems);

/// Runs that a campaign may have.
inline constexpr std::uint64_t most_runs = 10'000;

/// Reads what a file says of its campaign, and nothing else of it: the conditions themselves are
/// checked when they are loaded. Throws InputError: factors that are no keys or cannot be swept,
/// no levels, equal levels, factors that set the same key, too many runs. Nothing, unless `always`:
/// neither file nor options say a word of a campaign.
[[nodiscard]] std::optional<Design> read_design(const std::filesystem::path& file,
                                                const DesignOptions& options);

}  // namespace somas::experiment
