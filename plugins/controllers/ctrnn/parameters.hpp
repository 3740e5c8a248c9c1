// What an experiment may set of the recurrent network and of its variation.
#pragma once

#include <cstdint>

#include "somas/sdk/parameters.hpp"

namespace somas::ctrnn {

/// A step keeps the activations of a block of cells on the stack, hence this bound.
inline constexpr std::uint32_t most_hidden = 64;

struct Parameters {
  std::int64_t hidden = 6;
  double weight_limit = 16;
  double bias_limit = 16;
  double tau_min = 1;
  double tau_max = 20;
  double mutation_rate = 0.05;
  double mutation_sigma = 0.1;

  void describe(Describe& d) {
    d("hidden", hidden, "Hidden neurons, all connected with each other and to every output",
      {.minimum = 0, .maximum = most_hidden});
    d("weight_limit", weight_limit, "Weights lie in [-limit, limit]",
      {.minimum = 0, .maximum = 1000});
    d("bias_limit", bias_limit, "Biases lie in [-limit, limit]", {.minimum = 0, .maximum = 1000});
    d("tau_min", tau_min, "Least time constant of a neuron; below 1 the Euler step overshoots",
      {.unit = "step", .minimum = 1, .maximum = 1e6});
    d("tau_max", tau_max, "Greatest time constant of a neuron",
      {.unit = "step", .minimum = 1, .maximum = 1e6});
    d("mutation_rate", mutation_rate,
      "Probability that a mutation changes a gene; one gene at least is changed",
      {.minimum = 0, .maximum = 1});
    d("mutation_sigma", mutation_sigma,
      "Standard deviation of a change, as a share of the width of the gene's range",
      {.minimum = 0, .maximum = 1, .minimum_open = true});
    d.at_most("tau_min", "tau_max");
  }
};

}  // namespace somas::ctrnn
