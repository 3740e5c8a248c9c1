// The engine lives as the plain reference does (tests/core/model/reference/), to the last bit.
#include <gtest/gtest.h>

#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "tests/core/model/reference/compare.hpp"

namespace somas::reference {
namespace {

experiment::Experiment shipped(const std::string& name) {
  return experiment::load(std::string(SOMAS_SOURCE_DIR "/experiments/") + name,
                          {.overrides = {}, .plugin_directories = {SOMAS_BINARY_DIR "/plugins"}});
}

TEST(Reference, LivesAsTheEngineDoesWithTheChampionOfExperiment1) {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const evolution::Heredity heredity(*exp1.ecosystem);
  const run::Champion champion = run::parse_champion(
      run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"), "champion", heredity);
  const model::Phenotype phenotype = exp1.ecosystem->express(champion.individual.genome);
  const model::RosterEntry founder{&phenotype, 1, 0, 0};
  Events events;
  const auto difference =
      compare_lives(*exp1.ecosystem, {&founder, 1}, champion.seed, 5000, &events);
  ASSERT_FALSE(difference) << difference->text();
  EXPECT_GT(events.births, 900u);
}

TEST(Reference, IsFoundToDifferWithoutTheDamperOfPairs) {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const evolution::Heredity heredity(*exp1.ecosystem);
  const run::Champion champion = run::parse_champion(
      run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"), "champion", heredity);
  const model::Phenotype phenotype = exp1.ecosystem->express(champion.individual.genome);
  const model::RosterEntry founder{&phenotype, 1, 0, 0};
  Twins twins(*exp1.ecosystem, {&founder, 1}, champion.seed);
  twins.reference().mistake = Mistake::no_damper;
  const auto difference = twins.run(100);
  ASSERT_TRUE(difference);
  EXPECT_NE(difference->what.find(": vx"), std::string::npos) << difference->text();
}

}  // namespace
}  // namespace somas::reference
