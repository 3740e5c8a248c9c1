#include "plugins/environments/two_nutrients/two_nutrients.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Pair;

// Grids in the order of their declaration.
enum : Id { a = 0, a_before = 1, b = 2, b_before = 3 };

double total(FakeWorld& world) {
  double sum = 0;
  for (const Id grid : {a, b})
    for (const double content : world.grid(grid).values) sum += content;
  return sum;
}

TEST(TwoNutrients, HasTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<TwoNutrients::Parameters>(),
              ElementsAre("capacity", "initial", "yield", "regeneration", "resolution", "side",
                          "skill_a", "skill_b"));
}

TEST(TwoNutrients, AreTwoResourcesWithSkillsAndSensorsOfTheirOwn) {
  Stage<TwoNutrients> stage({});
  const FakeDeclare& d = stage.declared;
  EXPECT_THAT(d.sensors, ElementsAre("it_a", "it_b"));
  EXPECT_THAT(d.skills, ElementsAre("production_a", "production_b"));
  ASSERT_EQ(d.resources.size(), 2u);
  EXPECT_EQ(d.resources[0].grid, a);
  EXPECT_EQ(d.resources[1].grid, b);
  EXPECT_EQ(d.resources[0].skill, 0u);
  EXPECT_EQ(d.resources[1].skill, 1u);
  EXPECT_THAT(d.parameter_names, ElementsAre("regeneration"));
}

TEST(TwoNutrients, AMealOfOneComesBackAsTheOther) {
  Stage<TwoNutrients> stage({.initial = 1, .yield = 0.75, .regeneration = 0});
  stage.world.grid(a).values[7] -= 0.5;
  stage.world.grid(b).values[9] -= 0.25;
  stage.step(0);
  EXPECT_EQ(stage.world.grid(a).values[7], 0.5);
  EXPECT_EQ(stage.world.grid(b).values[7], 1 + 0.75 * 0.5);
  EXPECT_EQ(stage.world.grid(a).values[9], 1 + 0.75 * 0.25);
  EXPECT_EQ(stage.world.grid(b).values[9], 0.75);
  EXPECT_EQ(stage.world.grid(a).values[8], 1);
  stage.step(1);
  EXPECT_EQ(stage.world.grid(b).values[7], 1 + 0.75 * 0.5) << "once only";
}

TEST(TwoNutrients, NothingIsLostWithAWholeYield) {
  Stage<TwoNutrients> stage({.initial = 1, .yield = 1, .regeneration = 0, .resolution = 8});
  const double whole = total(stage.world);
  Rng rng(1, 0, 0, 0, 0);
  for (std::uint64_t step = 0; step < 200; ++step) {
    double eaten = 0;
    for (const Id grid : {a, b})
      for (double& content : stage.world.grid(grid).values) {
        // Never so much that what returns would be above the capacity.
        const double meal = 0.3 * content * rng.uniform();
        content -= meal;
        eaten += meal;
      }
    EXPECT_NEAR(total(stage.world) + eaten, whole, 1e-12 * whole);
    stage.step(step);
    const auto full = [](double content) { return content == 2; };
    for (const Id grid : {a, b})
      ASSERT_TRUE(std::none_of(stage.world.grid(grid).values.begin(),
                               stage.world.grid(grid).values.end(), full));
    EXPECT_NEAR(total(stage.world), whole, 1e-12 * whole);
  }
}

TEST(TwoNutrients, ExchangingThemExchangesAllThatHappens) {
  const TwoNutrients::Parameters parameters{.initial = 1.5, .yield = 0.7, .regeneration = 0.02};
  Stage<TwoNutrients> one(parameters), other(parameters);
  Rng rng(2, 0, 0, 0, 0);
  for (std::uint64_t step = 0; step < 20; ++step) {
    for (std::size_t i = 0; i < 100; ++i) {
      const double left_a = rng.uniform(), left_b = rng.uniform();
      one.world.grid(a).values[i] *= left_a;
      other.world.grid(b).values[i] *= left_a;
      one.world.grid(b).values[i] *= left_b;
      other.world.grid(a).values[i] *= left_b;
    }
    one.step(step);
    other.step(step);
    ASSERT_TRUE(std::ranges::equal(one.world.grid(a).values, other.world.grid(b).values));
    ASSERT_TRUE(std::ranges::equal(one.world.grid(b).values, other.world.grid(a).values));
  }
}

/// Eats up to `want` of each nutrient in one patch, step after step; what a and b gave in each.
std::vector<std::pair<double, double>> meals(double want_a, double want_b, int steps) {
  Stage<TwoNutrients> stage({.initial = 2, .yield = 0.8, .regeneration = 0.01});
  std::vector<std::pair<double, double>> all;
  for (int step = 0; step < steps; ++step) {
    double& here_a = stage.world.grid(a).values[50];
    double& here_b = stage.world.grid(b).values[50];
    const double eaten_a = std::min(want_a, here_a), eaten_b = std::min(want_b, here_b);
    here_a -= eaten_a;
    here_b -= eaten_b;
    all.emplace_back(eaten_a, eaten_b);
    stage.step(static_cast<std::uint64_t>(step));
  }
  return all;
}

TEST(TwoNutrients, WhoEatsOneOnlyIsLeftWithTheRegeneration) {
  // The rest of the patch is gone when half a unit a step has been eaten; then only growth remains.
  const auto all = meals(0.5, 0, 60);
  EXPECT_EQ(all[0].first, 0.5);
  for (std::size_t step = 10; step < all.size(); ++step)
    EXPECT_NEAR(all[step].first, 0.01, 1e-15) << step;
}

TEST(TwoNutrients, WhoEatsBothLivesOnTheYieldAsWell) {
  // At rest a meal m of either is what has grown since: m = 0.8 m + 0.01, so m = 0.05.
  const auto all = meals(0.5, 0.5, 400);
  EXPECT_NEAR(all.back().first, 0.05, 1e-12);
  EXPECT_NEAR(all.back().second, 0.05, 1e-12);
  EXPECT_GT(all.back().first + all.back().second, 9 * 0.01) << "ten times what either gives alone";
}

TEST(TwoNutrients, StopsAtTheCapacity) {
  Stage<TwoNutrients> stage({.yield = 1, .regeneration = 0.5});
  stage.world.grid(a).values[3] = 0;
  stage.step(0);
  EXPECT_EQ(stage.world.grid(a).values[3], 0.5);
  EXPECT_THAT(stage.world.grid(b).values, Each(2.0));
}

TEST(TwoNutrients, CellsSenseHowFullTheirPatchIsOfEither) {
  Stage<TwoNutrients> stage({}, 1, {{.x = 0.5, .y = 0.5}, {.x = 500, .y = 0, .id = 1}});
  const Grid grid = stage.world.grid(a);
  grid.values[grid.index_of(0.5, 0.5)] = 0.5;
  stage.environment.act(Phase::sense, stage.world);
  EXPECT_EQ(stage.world.sensor(0)[0], 0.25f);
  EXPECT_EQ(stage.world.sensor(1)[0], 1.0f);
  EXPECT_EQ(stage.world.sensor(0)[1], 0.0f) << "off the grid";
}

TEST(TwoNutrients, RefusesOneSkillForBothAndTooMuchAtTheStart) {
  EXPECT_THAT(refusal([] { TwoNutrients({.skill_a = "p", .skill_b = "p"}); }),
              Pair("skill_b", "'skill_a' and 'skill_b' must be two skills"));
  EXPECT_THAT(refusal([] { TwoNutrients({.capacity = 1, .initial = 1.5}); }),
              Pair("initial", "'initial' is more than 'capacity'"));
}

}  // namespace
}  // namespace somas::environments
