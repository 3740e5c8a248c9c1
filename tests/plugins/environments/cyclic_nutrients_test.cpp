#include "plugins/environments/cyclic_nutrients/cyclic_nutrients.hpp"

#include <numeric>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::Each;
using testing::ElementsAre;

double total(FakeWorld& world) {
  const Grid grid = world.grid(0);
  return std::accumulate(grid.values.begin(), grid.values.end(), 0.0);
}

constexpr double full = 12 * 12 * 2.0;

TEST(GapSchedule, SwitchesAtTheStepsComputedByHand) {
  // Gaps 5, 6.25, 7.8125, 9.77, 12.2, 15.3, 19.1, 23.8, 29.8, each rounded up.
  const GapSchedule schedule(60, 5, 1.25, 1000);
  const std::vector<std::uint64_t> expected = {60,  65,  125, 132, 192, 200, 260, 270,
                                               330, 343, 403, 419, 479, 499, 559, 583,
                                               643, 673, 733, 771, 831, 878, 938, 997};
  EXPECT_EQ(schedule.switches(), expected);
}

TEST(GapSchedule, NutrientsArePresentFromStepZeroAndAbsentInTheGaps) {
  const GapSchedule schedule(60, 5, 1.25, 3000);
  const auto present_all = [&](std::uint64_t first, std::uint64_t last, bool wanted) {
    for (std::uint64_t step = first; step <= last; ++step)
      EXPECT_EQ(schedule.present(step), wanted) << step;
  };
  present_all(0, 59, true);
  present_all(60, 64, false);
  present_all(65, 124, true);
  present_all(125, 131, false);
  present_all(132, 191, true);
}

TEST(GapSchedule, FirstGapLongerThanTheReservesOfNFallsInSteps643To672) {
  // In experiment 2 an N without food lives 28 steps (model, section 8).
  const auto switches = GapSchedule(60, 5, 1.25, 3000).switches();
  std::size_t lethal = 0;
  while (switches[lethal + 1] - switches[lethal] <= 28) lethal += 2;
  EXPECT_EQ(switches[lethal], 643u);
  EXPECT_EQ(switches[lethal + 1] - 1, 672u);
}

TEST(GapSchedule, ReturnsOnTheFirstStepAfterAGapOnly) {
  const GapSchedule schedule(3, 2, 1, 20);
  std::vector<std::uint64_t> returns;
  for (std::uint64_t step = 0; step < 20; ++step)
    if (schedule.returns(step)) returns.push_back(step);
  EXPECT_THAT(returns, ElementsAre(5, 10, 15));
}

TEST(GapSchedule, EndsWithTheRunHoweverLongTheGapsGrow) {
  EXPECT_THAT(GapSchedule(60, 5, 1e200, 1000).switches(), ElementsAre(60, 65, 125));
  EXPECT_THAT(GapSchedule(1u << 31, 5, 1.25, 1000).switches(), testing::IsEmpty());
  EXPECT_THAT(GapSchedule(60, 5, 1.25, 0).switches(), testing::IsEmpty());
  EXPECT_FALSE(GapSchedule(60, 5, 1e200, 1000).present(999));
}

TEST(CyclicNutrients, HasTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<CyclicNutrients::Parameters>(),
              ElementsAre("capacity", "regeneration", "resolution", "side", "production_skill",
                          "half_side", "present", "first_gap", "gap_growth"));
}

TEST(CyclicNutrients, FillsTheCentredSquareAtTheStart) {
  Stage<CyclicNutrients> stage({});
  stage.step(0);
  EXPECT_EQ(total(stage.world), full);
  const Grid grid = stage.world.grid(0);
  EXPECT_EQ(grid.values[grid.index_of(-11, 11)], 2.0);
  EXPECT_EQ(grid.values[grid.index_of(-13, 11)], 0.0);
}

TEST(CyclicNutrients, IsEmptyInAGapAndFullOnReturn) {
  Stage<CyclicNutrients> stage({}, 1, {{.x = 0.5, .y = 0.5}});
  for (std::uint64_t step = 0; step < 200; ++step) {
    stage.step(step);
    const bool gap = (step >= 60 && step < 65) || (step >= 125 && step < 132) || step >= 192;
    EXPECT_EQ(total(stage.world), gap ? 0.0 : full) << step;
    EXPECT_EQ(stage.world.sensor(0)[0], gap ? 0.0f : 1.0f) << step;
  }
}

TEST(CyclicNutrients, RegeneratesWhilePresent) {
  Stage<CyclicNutrients> stage({}, 1, {{.x = 0.5, .y = 0.5}});
  stage.step(0);
  const Grid grid = stage.world.grid(0);
  grid.values[grid.index_of(0.5, 0.5)] = 0.5;
  stage.step(1);
  EXPECT_DOUBLE_EQ(grid.values[grid.index_of(0.5, 0.5)], 0.65);
  EXPECT_FLOAT_EQ(stage.world.sensor(0)[0], 0.325f);
}

TEST(CyclicNutrients, AnEatenPatchIsFullAgainAfterTheGap) {
  Stage<CyclicNutrients> stage({.patches = {.regeneration = 0}});
  for (std::uint64_t step = 0; step < 60; ++step) stage.step(step);
  for (double& content : stage.world.grid(0).values) content = 0;
  for (std::uint64_t step = 60; step < 65; ++step) stage.step(step);
  EXPECT_EQ(total(stage.world), 0.0);
  stage.step(65);
  EXPECT_EQ(total(stage.world), full);
}

TEST(CyclicNutrients, PresenceIsAFunctionOfTheStepAlone) {
  Stage<CyclicNutrients> stage({});
  stage.step(643);
  EXPECT_THAT(stage.world.grid(0).values, Each(0.0));
  stage.step(673);
  EXPECT_EQ(total(stage.world), full);
}

TEST(CyclicNutrients, RefusesASquareWithoutPatches) {
  const auto [path, message] = refusal([] { Stage<CyclicNutrients> stage({.half_side = 0.5}); });
  EXPECT_EQ(path, "half_side");
  EXPECT_EQ(message, "the region is too small: no patch has its centre inside");
}

}  // namespace
}  // namespace somas::environments
