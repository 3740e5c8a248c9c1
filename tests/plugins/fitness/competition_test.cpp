#include "plugins/fitness/competition/competition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace somas::fitness {
namespace {

Outcome outcome_of(std::uint64_t survival, double share) {
  Outcome outcome;
  outcome.survival = survival;
  outcome.biomass_share = share;
  return outcome;
}

TEST(Competition, AddsStepsSurvivedAndShareOfBiomassByWeight) {
  const Competition fitness({.survival_weight = 2, .share_weight = 300});
  EXPECT_EQ(fitness.score(outcome_of(100, 0.25)), 275);
  EXPECT_EQ(fitness.score(outcome_of(0, 0)), 0);
}

TEST(Competition, PrefersTheLargerShareAmongEqualLives) {
  const Competition fitness(Competition::Parameters{});
  EXPECT_GT(fitness.score(outcome_of(500, 0.6)), fitness.score(outcome_of(500, 0.4)));
  EXPECT_GT(fitness.score(outcome_of(600, 0.5)), fitness.score(outcome_of(500, 0.5)));
}

TEST(Competition, CanAskForEitherAlone) {
  EXPECT_EQ(Competition({.survival_weight = 1, .share_weight = 0}).score(outcome_of(7, 0.5)), 7);
  EXPECT_EQ(Competition({.survival_weight = 0, .share_weight = 1}).score(outcome_of(7, 0.5)), 0.5);
}

TEST(Competition, RefusesWeightsThatLeaveNothingToScore) {
  try {
    const Competition fitness({.survival_weight = 0, .share_weight = 0});
    FAIL() << "took them";
  } catch (const ParameterError& error) {
    EXPECT_EQ(error.path(), "share_weight");
    EXPECT_THAT(error.what(), testing::HasSubstr("both weights are 0"));
  }
}

}  // namespace
}  // namespace somas::fitness
