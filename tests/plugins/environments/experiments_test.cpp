// The experiments of single environments, with the built plugins, in whole simulations.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include <gtest/gtest.h>

#include "core/experiment/experiment.hpp"
#include "core/model/simulation.hpp"

namespace somas::environments {
namespace {

experiment::Experiment shipped(const std::string& name, std::vector<std::string> overrides = {}) {
  const std::filesystem::path file = std::filesystem::path(SOMAS_SOURCE_DIR) / "experiments" / name;
  return experiment::load(file, {std::move(overrides), {SOMAS_BINARY_DIR "/plugins"}});
}

/// Lives the life of a random genome; calls visit(state) before every step.
void live(const experiment::Experiment& experiment, std::uint64_t seed,
          const std::function<void(const model::WorldState&)>& visit) {
  const model::Ecosystem& ecosystem = *experiment.ecosystem;
  Rng rng(seed, 0, 0, 0, 0);
  model::Genome genome;
  ecosystem.controller().heritable().random(ecosystem.fixed_ports()->layout(), rng,
                                            genome.controller);
  const model::Phenotype phenotype = ecosystem.express(genome);
  const model::RosterEntry founder{&phenotype, 0, 0, 0};
  model::Simulation simulation(ecosystem, {&founder, 1}, seed);
  do visit(simulation.state());
  while (simulation.step());
}

/// Overrides that leave a world without particles, in which organisms grow.
const std::vector<std::string> peace = {"environments.particle_aggression.rate_scale=0",
                                        "world.max_steps=400"};

TEST(WallsExperiment, NoCellOfAGrowingOrganismLeavesTheEnclosure) {
  const experiment::Experiment experiment = shipped("walls.yaml", peace);
  std::uint32_t largest = 0;
  double farthest = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const auto visit = [&](const model::WorldState& state) {
      largest = std::max(largest, state.cells.size());
      for (std::uint32_t i = 0; i < state.cells.size(); ++i) {
        // The enclosure of the file: 50 by 24 round (13, 0).
        const double x = std::abs(state.cells.x[i] - 13), y = std::abs(state.cells.y[i]);
        farthest = std::max({farthest, x / 25, y / 12});
      }
    };
    live(experiment, seed, visit);
  }
  EXPECT_LT(farthest, 1);
  // Not for want of cells that pressed against it.
  EXPECT_GT(largest, 60u);
  EXPECT_GT(farthest, 0.9);
}

TEST(WallsExperiment, WithoutTheEnclosureCellsDoGoThere) {
  std::vector<std::string> overrides = peace;
  overrides.emplace_back("environments.walls.obstacles=[]");
  const experiment::Experiment experiment = shipped("walls.yaml", overrides);
  double farthest = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed)
    live(experiment, seed, [&](const model::WorldState& state) {
      for (const double x : state.cells.x) farthest = std::max(farthest, std::abs(x - 13) / 25);
    });
  EXPECT_GT(farthest, 1);
}

}  // namespace
}  // namespace somas::environments
