// Lives of the shipped experiments, saved and restored at several steps: every plugin's state is in
// the saved bytes.
#include "core/model/snapshot.hpp"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"

namespace somas::model {
namespace {

using Bytes = std::vector<std::byte>;

experiment::Experiment shipped(const std::string& name) {
  return experiment::load(
      std::string(SOMAS_SOURCE_DIR "/experiments/") + name,
      {.overrides = {"world.max_steps=700"}, .plugin_directories = {SOMAS_BINARY_DIR "/plugins"}});
}

/// Of some random genomes the one that lives longest.
Genome survivor(const Ecosystem& ecosystem) {
  const evolution::Heredity heredity(ecosystem);
  Genome best;
  std::uint64_t most = 0;
  for (std::uint64_t number = 0; number < 120; ++number) {
    Rng rng(7, 0, 0, stable_key("test"), number);
    const Genome genome = heredity.random(rng);
    const Phenotype phenotype = ecosystem.express(genome);
    const RosterEntry founder{&phenotype, 1, 0, 0};
    Simulation life(ecosystem, {&founder, 1}, 5);
    while (life.steps_done() < 150 && life.step()) continue;
    const std::uint64_t reached = life.steps_done() + life.outcomes()[0].divisions;
    if (reached <= most) continue;
    most = reached;
    best = genome;
  }
  return best;
}

/// Restores at every `stride`-th step, lives on to the end, compares at every step.
void expect_equal_lives(const Ecosystem& ecosystem, const Genome& genome, std::uint64_t stride,
                        std::uint64_t least_steps) {
  const Phenotype phenotype = ecosystem.express(genome);
  const RosterEntry founder{&phenotype, 1, 0, 0};
  Simulation life(ecosystem, {&founder, 1}, 5);
  std::vector<std::unique_ptr<Simulation>> twins;
  const Phenotype* const roster[] = {&phenotype};
  while (!life.finished()) {
    const Bytes bytes = save(life);
    for (const auto& twin : twins) {
      ASSERT_EQ(twin->hash(), life.hash()) << "step " << life.steps_done();
      if (life.steps_done() % 10 == 1) {
        ASSERT_EQ(save(*twin), bytes) << "step " << life.steps_done();
      }
    }
    if (life.steps_done() % stride == 0)
      twins.push_back(std::make_unique<Simulation>(ecosystem, roster, bytes));
    life.step();
    for (const auto& twin : twins) twin->step();
  }
  EXPECT_GE(life.steps_done(), least_steps);
  EXPECT_GT(life.outcomes()[0].divisions, 0u);
  for (const auto& twin : twins) {
    EXPECT_TRUE(twin->finished());
    EXPECT_EQ(save(*twin), save(life));
    EXPECT_EQ(twin->outcomes()[0].survival, life.outcomes()[0].survival);
  }
}

TEST(Snapshot, OfExperiment1LivesOnAsItsChampionDoes) {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const evolution::Heredity heredity(*exp1.ecosystem);
  const run::Champion champion = run::parse_champion(
      run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"), "champion", heredity);
  expect_equal_lives(*exp1.ecosystem, champion.individual.genome, 130, 400);
}

TEST(Snapshot, OfExperiment2LivesOnThroughItsCycles) {
  const experiment::Experiment exp2 = shipped("exp2.yaml");
  expect_equal_lives(*exp2.ecosystem, survivor(*exp2.ecosystem), 60, 60);
}

TEST(Snapshot, OfANeuralNetworkKeepsItsMemory) {
  const experiment::Experiment ctrnn = shipped("exp1_ctrnn.yaml");
  expect_equal_lives(*ctrnn.ecosystem, survivor(*ctrnn.ecosystem), 60, 60);
}

TEST(Snapshot, OfEveryOtherWorldLivesOnAlike) {
  for (const char* name :
       {"walls.yaml", "toxin_gradient.yaml", "two_nutrients.yaml", "seasons.yaml", "sorting.yaml",
        "competition.yaml", "exp1_evolved_tree.yaml"}) {
    SCOPED_TRACE(name);
    const experiment::Experiment world = shipped(name);
    expect_equal_lives(*world.ecosystem, survivor(*world.ecosystem), 90, 60);
  }
}

}  // namespace
}  // namespace somas::model
