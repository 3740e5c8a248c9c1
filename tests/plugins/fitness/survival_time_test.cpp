#include "plugins/fitness/survival_time/survival_time.hpp"

#include <gtest/gtest.h>

namespace somas::fitness {
namespace {

TEST(SurvivalTime, ScoresTheStepsLived) {
  const SurvivalTime fitness(SurvivalTime::Parameters{});
  Outcome outcome;
  EXPECT_EQ(fitness.score(outcome), 0);
  outcome.survival = 1222;
  outcome.divisions = 5;
  EXPECT_EQ(fitness.score(outcome), 1222);
}

TEST(SurvivalTime, ACensoredOrganismScoresTheStepsItWasWatched) {
  const SurvivalTime fitness(SurvivalTime::Parameters{});
  Outcome outcome;
  outcome.survival = 3000;
  outcome.censored = true;
  EXPECT_EQ(fitness.score(outcome), 3000);
}

TEST(SurvivalTime, NamesItsObjective) {
  EXPECT_EQ(SurvivalTime(SurvivalTime::Parameters{}).objective(), "survival");
}

}  // namespace
}  // namespace somas::fitness
