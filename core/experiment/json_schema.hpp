// A JSON Schema of the experiment file, for editors.
#pragma once

#include <string>

#include "core/plugins/registry.hpp"

namespace somas::experiment {

/// The schema (draft-07, which editors' YAML servers know best) of an experiment that may use any
/// plugin of `registry`, as JSON text. It refuses nothing that load() takes, but for an inherited
/// environment that has the name of one plugin and is of another. What it cannot express is left to
/// load(): comparisons of two values, what plugins and the wiring ask for, files and directories.
[[nodiscard]] std::string json_schema(const plugins::Registry& registry);

}  // namespace somas::experiment
