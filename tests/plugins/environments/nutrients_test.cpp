#include "plugins/environments/nutrients/nutrients.hpp"

#include <numeric>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Pair;

double content_at(FakeWorld& world, double x, double y) {
  const Grid grid = world.grid(0);
  return grid.values[grid.index_of(x, y)];
}

double total(FakeWorld& world) {
  const Grid grid = world.grid(0);
  return std::accumulate(grid.values.begin(), grid.values.end(), 0.0);
}

TEST(Nutrients, HasTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<Nutrients::Parameters>(),
              ElementsAre("capacity", "regeneration", "resolution", "side", "production_skill",
                          "initial", "region", "half_side", "radius"));
}

TEST(Nutrients, DeclaresAResourceAndASensorNamedLikeTheInstance) {
  Stage<Nutrients> stage({});
  const FakeDeclare& d = stage.declared;
  EXPECT_THAT(d.sensors, ElementsAre("it"));
  EXPECT_THAT(d.skills, ElementsAre("production"));
  ASSERT_EQ(d.resources.size(), 1u);
  EXPECT_EQ(d.resources[0].name, "it");
  EXPECT_EQ(d.resources[0].grid, 0u);
  EXPECT_EQ(d.resources[0].skill, 0u);
  EXPECT_THAT(d.phases, ElementsAre(Phase::fields, Phase::sense));
}

TEST(Nutrients, GridIsCentredWithEdgesThroughTheOrigin) {
  Stage<Nutrients> stage({});
  const GridSpec spec = stage.world.grid(0).spec;
  EXPECT_EQ(spec.columns, 64u);
  EXPECT_EQ(spec.rows, 64u);
  EXPECT_EQ(spec.side, 2.0);
  EXPECT_EQ(spec.left, -64.0);
  EXPECT_EQ(spec.bottom, -64.0);
}

TEST(Nutrients, IsFullAtTheStartUnlessToldOtherwise) {
  Stage<Nutrients> full({});
  EXPECT_THAT(full.world.grid(0).values, Each(2.0));
  Stage<Nutrients> half({.initial = 0.5});
  EXPECT_THAT(half.world.grid(0).values, Each(0.5));
}

TEST(Nutrients, RegeneratesUpToItsCapacityOnly) {
  Stage<Nutrients> stage({.initial = 1.75});
  stage.step(0);
  EXPECT_THAT(stage.world.grid(0).values, Each(1.75 + 0.15));
  stage.step(1);
  EXPECT_THAT(stage.world.grid(0).values, Each(2.0));
  stage.step(2);
  EXPECT_THAT(stage.world.grid(0).values, Each(2.0));
}

TEST(Nutrients, RegenerationRepaysExactlyWhatWasEaten) {
  Stage<Nutrients> stage({});
  const double before = total(stage.world);
  stage.world.grid(0).values[100] -= 0.75;
  for (std::uint64_t step = 0; step < 5; ++step) stage.step(step);
  EXPECT_DOUBLE_EQ(total(stage.world), before);
}

TEST(Nutrients, SquareHoldsThePatchesWithTheirCentreInside) {
  Nutrients::Parameters parameters;
  parameters.region = "square";
  parameters.half_side = 12;
  Stage<Nutrients> stage(parameters);
  EXPECT_EQ(total(stage.world), 12 * 12 * 2.0);
  EXPECT_EQ(content_at(stage.world, 11, -11), 2.0);
  EXPECT_EQ(content_at(stage.world, 13, 0), 0.0);
}

TEST(Nutrients, DiscHoldsThePatchesWithTheirCentreInside) {
  Nutrients::Parameters parameters;
  parameters.region = "disc";
  parameters.radius = 3.2;
  Stage<Nutrients> stage(parameters);
  // Centres at odd coordinates: (1, 1), (1, 3) and (3, 1) in each quadrant; (3, 3) is 4.2 away.
  EXPECT_EQ(total(stage.world), 4 * 3 * 2.0);
  EXPECT_EQ(content_at(stage.world, 3, 3), 0.0);
}

TEST(Nutrients, NothingGrowsOutsideTheRegion) {
  Nutrients::Parameters parameters;
  parameters.region = "square";
  parameters.half_side = 5;
  Stage<Nutrients> stage(parameters);
  for (std::uint64_t step = 0; step < 30; ++step) stage.step(step);
  EXPECT_EQ(content_at(stage.world, 7, 0), 0.0);
  EXPECT_EQ(content_at(stage.world, 5, 0), 2.0);
}

TEST(Nutrients, CellsSenseHowFullTheirPatchIs) {
  Nutrients::Parameters parameters;
  parameters.region = "square";
  parameters.half_side = 12;
  parameters.patches.regeneration = 0;
  Stage<Nutrients> stage(parameters, 1,
                         {{.x = 1, .y = 1},
                          {.x = -1, .y = 1},
                          {.x = 20, .y = 0},
                          {.x = 64, .y = 0},
                          {.x = 0, .y = 0}});
  const Grid grid = stage.world.grid(0);
  grid.values[grid.index_of(1, 1)] = 0.5;
  stage.step(0);
  // A quarter left; full; outside the region; off the grid; the corner belongs to the upper right.
  EXPECT_THAT(stage.world.sensor(0), ElementsAre(0.25f, 1.0f, 0.0f, 0.0f, 0.25f));
}

TEST(Nutrients, RefusesParametersThatContradictEachOther) {
  const auto with = [](auto change) {
    return refusal([&] {
      Nutrients::Parameters parameters;
      change(parameters);
      Stage<Nutrients> stage(parameters);
    });
  };
  EXPECT_THAT(with([](auto& p) { p.initial = 3; }),
              Pair("initial", "'initial' is more than 'capacity'"));
  EXPECT_THAT(with([](auto& p) { p.region = "square"; }),
              Pair("half_side", "region 'square' needs 'half_side'"));
  EXPECT_THAT(with([](auto& p) { p.region = "disc"; }),
              Pair("radius", "region 'disc' needs 'radius'"));
  EXPECT_THAT(with([](auto& p) { p.half_side = 12; }),
              Pair("half_side", "region 'everywhere' has no 'half_side'"));
  EXPECT_THAT(with([](auto& p) {
                p.region = "disc";
                p.radius = 1;
              }),
              Pair("radius", "the region is too small: no patch has its centre inside"));
}

}  // namespace
}  // namespace somas::environments
