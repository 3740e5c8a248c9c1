// What is allowed in an experiment, but seldom meant.
#pragma once

#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"

namespace somas::experiment {

/// One sentence each, naming the environment; empty: nothing to say. Grids that do not cover the
/// world: cells beyond one sense and find nothing there.
[[nodiscard]] std::vector<std::string> warnings_of(const Experiment& experiment);

}  // namespace somas::experiment
