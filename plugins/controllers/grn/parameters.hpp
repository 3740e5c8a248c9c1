// What an experiment may set of the gene regulatory network and of its variation.
#pragma once

#include <cstdint>
#include <string>

#include "somas/sdk/parameters.hpp"

namespace somas::grn {

/// A step keeps the sources of a block of cells on the stack, hence these bounds.
inline constexpr std::uint32_t most_regulators = 128;
inline constexpr std::uint32_t most_input_channels = 128;

/// Defaults: docs/model.md sections 6 and 7.
struct Parameters {
  std::string affinity = "proximity";
  std::int64_t initial_regulators = 3;
  std::int64_t max_regulators = 40;
  double beta_min = 0.5;
  double beta_max = 20;
  double delta_min = 0.05;
  double delta_max = 2;
  std::int64_t max_edits = 4;
  double rate_redraw = 0.2;
  double crossover_threshold = 0.15;

  void describe(Describe& d) {
    d.choice(
        "affinity", affinity, {"proximity", "distance"},
        "How strongly a regulator acts on a target: 1 - |tag - id|, or the paper's |tag - id|");
    d("initial_regulators", initial_regulators, "Regulatory proteins of a fresh genome",
      {.minimum = 0, .maximum = most_regulators});
    d("max_regulators", max_regulators, "Most regulatory proteins of any genome",
      {.minimum = 0, .maximum = most_regulators});
    d("beta_min", beta_min, "Least selectivity of a genome's affinities",
      {.minimum = 0, .maximum = 1000});
    d("beta_max", beta_max, "Greatest selectivity of a genome's affinities",
      {.minimum = 0, .maximum = 1000});
    d("delta_min", delta_min, "Least speed of a genome's concentrations",
      {.unit = "1/step", .minimum = 0, .maximum = 1000});
    d("delta_max", delta_max, "Greatest speed of a genome's concentrations",
      {.unit = "1/step", .minimum = 0, .maximum = 1000});
    d("max_edits", max_edits,
      "A mutation makes 1 to this many edits: a tag modified, a regulator added or deleted",
      {.minimum = 1, .maximum = 1000});
    d("rate_redraw", rate_redraw,
      "Probability, for each of beta and delta, of being drawn anew by a mutation",
      {.minimum = 0, .maximum = 1});
    d("crossover_threshold", crossover_threshold,
      "Regulators of two parents pair up below this distance, 0.75 id + 0.125 enhancer + "
      "0.125 inhibitor",
      {.minimum = 0, .maximum = 1});
    d.at_most("initial_regulators", "max_regulators");
    d.at_most("beta_min", "beta_max");
    d.at_most("delta_min", "delta_max");
  }
};

}  // namespace somas::grn
