// The keys of an experiment file that are the core's own, described as plugins describe theirs.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/evolution/settings.hpp"
#include "core/experiment/record_settings.hpp"
#include "core/model/config.hpp"
#include "core/plugins/values.hpp"

namespace somas::experiment {

inline constexpr std::int64_t format_version = 1;

/// What the core's keys say.
struct CoreValues {
  std::int64_t format = format_version;
  std::string name;
  std::int64_t seed = 1;
  std::int64_t replicates = 1;
  model::Config world;
  evolution::Settings evolution;
  RecordSettings record;
};

/// The keys `somas`, `name`, `seed`, `replicates`, `world`, `evolution`, `record` with everything
/// below them.
[[nodiscard]] std::span<const ParameterInfo> core_keys();

/// The values of a validated group of core_keys().
[[nodiscard]] CoreValues core_values(const plugins::ParameterValue& group);

/// Keys at the top level that core_keys() does not describe: files, and the plugins' blocks.
[[nodiscard]] const std::vector<std::string>& other_keys();

/// The same, described.
struct OtherKey {
  const char* name;
  const char* type;
  const char* fallback;
  const char* doc;
};
[[nodiscard]] std::span<const OtherKey> other_keys_described();

/// Every key of an experiment file but the plugins' own, as Markdown.
[[nodiscard]] std::string keys_reference();

}  // namespace somas::experiment
