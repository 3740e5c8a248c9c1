// An experiment of the toy ecosystem, as if loaded from a file.
#pragma once

#include "core/experiment/experiment.hpp"
#include "tests/core/evaluation/toy_ecosystem.hpp"

namespace somas::test {

inline experiment::Experiment toy_experiment(const ToyOptions& options = {}) {
  experiment::Experiment experiment;
  experiment.name = "toy";
  experiment.seed = 11;
  experiment.evolution.population = 20;
  experiment.evolution.generations = 4;
  experiment.evolution.trials = 2;
  experiment.ecosystem = toy_ecosystem(options);
  experiment.original_yaml = "somas: original\n";
  experiment.resolved_yaml = "somas: resolved\n";
  return experiment;
}

}  // namespace somas::test
