#include "core/experiment/warnings.hpp"

#include "core/plugins/values.hpp"

namespace somas::experiment {

std::vector<std::string> warnings_of(const Experiment& experiment) {
  const double radius = experiment.ecosystem->config().radius;
  std::vector<std::string> warnings;
  for (const model::GridDeclaration& grid : experiment.ecosystem->schema().grids)
    if (!model::covers(grid.spec, radius))
      warnings.push_back("environments." + grid.owner + ": its grid '" + grid.name +
                         "' does not cover the world (world.radius is " +
                         plugins::format_number(radius) +
                         "): cells beyond it sense and find nothing there");
  return warnings;
}

}  // namespace somas::experiment
