// What could stand in an experiment where a parameter is required, so that no default says it.
#pragma once

#include <span>

#include "core/plugins/values.hpp"

namespace somas::plugins {

/// A value of the parameter's kind and in its range.
[[nodiscard]] ParameterValue example_of(const ParameterInfo& info);

/// A group of examples for those of `fields` that are required, within groups, too. What is not in
/// it has the plugin's own default.
[[nodiscard]] ParameterValue example_of(std::span<const ParameterInfo> fields);

}  // namespace somas::plugins
