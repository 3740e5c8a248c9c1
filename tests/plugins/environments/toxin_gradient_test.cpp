#include "plugins/environments/toxin_gradient/toxin_gradient.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using Parameters = ToxinGradient::Parameters;

/// Runs the fields phase alone.
void spread(Stage<ToxinGradient>& stage, int steps) {
  for (int step = 0; step < steps; ++step) stage.environment.act(Phase::fields, stage.world);
}

double total(Stage<ToxinGradient>& stage) {
  const Grid grid = stage.world.grid(0);
  return std::accumulate(grid.values.begin(), grid.values.end(), 0.0) * grid.spec.side *
         grid.spec.side;
}

double at(Stage<ToxinGradient>& stage, std::size_t column, std::size_t row) {
  const Grid grid = stage.world.grid(0);
  return grid.values[row * grid.spec.columns + column];
}

TEST(ToxinGradient, HasTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<Parameters>(),
              ElementsAre("resolution", "side", "sources", "edge", "emission_scale", "diffusion",
                          "decay", "boundary", "saturation", "toxicity", "resistance_skill"));
  EXPECT_THAT(parameter_names<ToxinGradient::Source>(), ElementsAre("x", "y", "rate"));
}

TEST(ToxinGradient, DeclaresASensorAndAHazardNamedLikeTheInstance) {
  Stage<ToxinGradient> stage({.resistance_skill = "tolerance"});
  const FakeDeclare& d = stage.declared;
  EXPECT_THAT(d.sensors, ElementsAre("it"));
  EXPECT_THAT(d.skills, ElementsAre("tolerance"));
  ASSERT_EQ(d.hazards.size(), 1u);
  EXPECT_EQ(d.hazards[0].name, "it");
  EXPECT_EQ(d.hazards[0].skill, 0u);
  EXPECT_THAT(d.parameter_names, ElementsAre("emission_scale", "toxicity"));
  EXPECT_THAT(d.phases, ElementsAre(Phase::fields, Phase::sense, Phase::stress));
  EXPECT_EQ(d.grids[0].columns, 64u);
  EXPECT_EQ(d.grids[0].left, -64.0);
}

// ---- diffusion ---------------------------------------------------------------------------------

TEST(ToxinGradient, PassesAShareOfTheDifferenceToEachNeighbour) {
  // diffusion / side^2 = 1/8, decay 1/4.
  Stage<ToxinGradient> stage({.resolution = 5, .side = 2, .diffusion = 0.5, .decay = 0.25});
  stage.world.grid(0).values[2 * 5 + 2] = 8;
  spread(stage, 1);
  EXPECT_EQ(at(stage, 2, 2), 8 - 4 * 1 - 2);
  EXPECT_EQ(at(stage, 1, 2), 1);
  EXPECT_EQ(at(stage, 2, 3), 1);
  EXPECT_EQ(at(stage, 1, 1), 0);
  EXPECT_EQ(at(stage, 4, 2), 0);
}

TEST(ToxinGradient, SourcesGiveOffTheirRateIntoTheirSquare) {
  Parameters p{.resolution = 4, .side = 2, .emission_scale = 0.5, .diffusion = 0, .decay = 0};
  p.sources = {
      {.x = 1, .y = 1, .rate = 8}, {.x = 1.5, .y = 0.5, .rate = 4}, {.x = -4, .y = -4, .rate = 2}};
  Stage<ToxinGradient> stage(p);
  spread(stage, 2);
  EXPECT_EQ(at(stage, 2, 2), 2 * 0.5 * (8 + 4) / 4);
  EXPECT_EQ(at(stage, 0, 0), 2 * 0.5 * 2 / 4);
  EXPECT_EQ(total(stage), 2 * 0.5 * 14);
}

TEST(ToxinGradient, SteadyProfileFromAHeldEdgeIsTheExactSolutionOfTheScheme) {
  const double diffusion = 0.8, side = 2, decay = 0.02;
  Stage<ToxinGradient> stage(
      {.resolution = 40, .side = side, .edge = "left", .diffusion = diffusion, .decay = decay});
  spread(stage, 3000);
  // C_j = z^j solves z + 1/z = 2 + k side^2 / D; the far edge, which lets nothing pass, is a mirror
  // between the squares N - 1 and N.
  const double half = 1 + 0.5 * decay * side * side / diffusion;
  const double z = half - std::sqrt(half * half - 1);
  const double n = 40;
  for (std::size_t j = 0; j < 40; ++j) {
    const double mirrored = std::pow(z, 2 * n - 1 - static_cast<double>(j));
    const double exact =
        (std::pow(z, static_cast<double>(j)) + mirrored) / (1 + std::pow(z, 2 * n - 1));
    for (const std::size_t row : {0u, 17u, 39u}) EXPECT_NEAR(at(stage, j, row), exact, 1e-13) << j;
  }
}

TEST(ToxinGradient, SteadyProfileFallsByEOverTheLengthRootOfDiffusionOverDecay) {
  // Fine squares: the length is ten of them, and the grid ten lengths.
  const double diffusion = 1, decay = 0.01;
  Stage<ToxinGradient> stage(
      {.resolution = 100, .side = 2.1, .edge = "left", .diffusion = diffusion, .decay = decay});
  spread(stage, 3000);
  const double length = std::sqrt(diffusion / decay);
  for (const std::size_t j : {1u, 5u, 10u, 20u})
    EXPECT_NEAR(at(stage, j, 50) / std::exp(-2.1 * static_cast<double>(j) / length), 1,
                0.002 * static_cast<double>(j));
}

TEST(ToxinGradient, EveryEdgeCanBeHeld) {
  const auto held = [](const char* edge) {
    Stage<ToxinGradient> stage(
        {.resolution = 5, .edge = edge, .emission_scale = 3, .diffusion = 0});
    spread(stage, 1);
    const std::vector<double> sides = {at(stage, 0, 2), at(stage, 4, 2), at(stage, 2, 4),
                                       at(stage, 2, 0)};
    EXPECT_EQ(total(stage), edge == std::string("none") ? 0 : 3 * 5 * 4.0);
    return sides;
  };
  EXPECT_THAT(held("left"), ElementsAre(3, 0, 0, 0));
  EXPECT_THAT(held("right"), ElementsAre(0, 3, 0, 0));
  EXPECT_THAT(held("top"), ElementsAre(0, 0, 3, 0));
  EXPECT_THAT(held("bottom"), ElementsAre(0, 0, 0, 3));
  EXPECT_THAT(held("none"), Each(0));
}

TEST(ToxinGradient, ConservesToxinWithoutDecayWhereNothingPassesTheEdge) {
  Parameters p{.resolution = 9, .diffusion = 0.9, .decay = 0};
  p.sources = {{.x = -8, .y = 8, .rate = 0.7}, {.x = 1, .y = 0, .rate = 0.4}};
  Stage<ToxinGradient> stage(p);
  spread(stage, 500);
  EXPECT_NEAR(total(stage), 500 * 1.1, 1e-9);
}

TEST(ToxinGradient, DecayTakesItsShareOfTheWhole) {
  Stage<ToxinGradient> stage({.resolution = 9, .diffusion = 0.5, .decay = 0.125});
  stage.world.grid(0).values[3] = 2;
  const double before = total(stage);
  spread(stage, 20);
  EXPECT_NEAR(total(stage), before * std::pow(1 - 0.125, 20), 1e-12);
}

TEST(ToxinGradient, AbsorbingEdgesLoseWhatReachesThem) {
  // A single square with four edges: 1/8 passes through each.
  Parameters p{.resolution = 1, .diffusion = 0.5, .decay = 0, .boundary = "absorbing"};
  Stage<ToxinGradient> stage(p);
  stage.world.grid(0).values[0] = 8;
  spread(stage, 1);
  EXPECT_EQ(at(stage, 0, 0), 4);
  p.boundary = "zero_flux";
  Stage<ToxinGradient> closed(p);
  closed.world.grid(0).values[0] = 8;
  spread(closed, 1);
  EXPECT_EQ(at(closed, 0, 0), 8);
}

TEST(ToxinGradient, APointSourceSpreadsAlikeUnderTheEightSymmetriesBitForBit) {
  for (const char* boundary : {"zero_flux", "absorbing"}) {
    Parameters p{
        .resolution = 15, .side = 1.7, .diffusion = 0.61, .decay = 0.013, .boundary = boundary};
    p.sources = {{.x = 0, .y = 0, .rate = 0.37}};
    Stage<ToxinGradient> stage(p);
    spread(stage, 100);
    EXPECT_GT(at(stage, 0, 0), 0);
    for (std::size_t x = 0; x < 15; ++x)
      for (std::size_t y = 0; y < 15; ++y) {
        EXPECT_EQ(at(stage, x, y), at(stage, 14 - x, y));
        EXPECT_EQ(at(stage, x, y), at(stage, x, 14 - y));
        EXPECT_EQ(at(stage, x, y), at(stage, y, x));
      }
  }
}

TEST(ToxinGradient, NoSquareBecomesNegativeAtTheLimitOfStability) {
  Stage<ToxinGradient> stage({.resolution = 9, .side = 2, .diffusion = 1, .decay = 0});
  stage.world.grid(0).values[4 * 9 + 4] = 0.1;
  for (int n = 0; n < 50; ++n) {
    spread(stage, 1);
    EXPECT_THAT(stage.world.grid(0).values, Each(testing::AllOf(testing::Ge(0), testing::Le(0.1))));
  }
}

TEST(ToxinGradient, EmissionFollowsItsVariableParameter) {
  Parameters p{.resolution = 3, .side = 1, .diffusion = 0, .decay = 0};
  p.sources = {{.x = 0, .y = 0, .rate = 1}};
  Stage<ToxinGradient> stage(p);
  spread(stage, 1);
  stage.world.parameters[0] = 5;
  spread(stage, 1);
  EXPECT_EQ(at(stage, 1, 1), 6);
}

// ---- cells -------------------------------------------------------------------------------------

/// A row of squares of which three hold toxin.
Parameters still() {
  return {.resolution = 4, .side = 2, .diffusion = 0, .decay = 0, .saturation = 4, .toxicity = 0.5};
}

TEST(ToxinGradient, CellsSenseTheConcentrationOfTheirSquareUpToSaturation) {
  Stage<ToxinGradient> stage(still(), 1,
                             {{.x = 1, .y = 1},
                              {.x = -1, .y = 1},
                              {.x = 0, .y = 0},
                              {.x = 3, .y = 3},
                              {.x = 4, .y = 0},
                              {.x = -3, .y = -3}});
  const Grid grid = stage.world.grid(0);
  grid.values[grid.index_of(1, 1)] = 1;
  grid.values[grid.index_of(-1, 1)] = 4;
  grid.values[grid.index_of(3, 3)] = 9;
  stage.environment.act(Phase::sense, stage.world);
  // A quarter; saturated; the corner belongs to the upper right; beyond saturation; off the grid;
  // none.
  EXPECT_THAT(stage.world.sensor(0), ElementsAre(0.25f, 1.0f, 0.25f, 1.0f, 0.0f, 0.0f));
}

TEST(ToxinGradient, LiveCellsAbsorbToxicityTimesConcentrationEachStep) {
  Stage<ToxinGradient> stage(still(), 1,
                             {{.x = 1, .y = 1, .id = 1},
                              {.x = -1, .y = 1, .id = 2},
                              {.x = 1, .y = 1, .id = 3, .dead = true},
                              {.x = -3, .y = -3, .id = 4},
                              {.x = 9, .y = 0, .id = 5}});
  const Grid grid = stage.world.grid(0);
  grid.values[grid.index_of(1, 1)] = 3;
  grid.values[grid.index_of(-1, 1)] = 1;
  stage.environment.act(Phase::stress, stage.world);
  EXPECT_THAT(stage.world.strikes, ElementsAre(Strike{1, 1.5}, Strike{2, 0.5}));
  stage.world.strikes.clear();
  stage.world.parameters[1] = 2;
  stage.environment.act(Phase::stress, stage.world);
  EXPECT_THAT(stage.world.strikes, ElementsAre(Strike{1, 6}, Strike{2, 2}));
}

TEST(ToxinGradient, WithoutToxicityNobodyIsStruck) {
  Parameters p = still();
  p.toxicity = 0;
  Stage<ToxinGradient> stage(p, 1, {{.x = 1, .y = 1}});
  stage.world.grid(0).values[stage.world.grid(0).index_of(1, 1)] = 3;
  stage.environment.act(Phase::stress, stage.world);
  EXPECT_TRUE(stage.world.strikes.empty());
}

// ---- parameters --------------------------------------------------------------------------------

TEST(ToxinGradient, RefusesWhatTheSchemeCannotBear) {
  const auto refused = [](const Parameters& p) {
    return refusal([&] { Stage<ToxinGradient> stage(p); });
  };
  EXPECT_EQ(refused({.side = 2, .diffusion = 1, .decay = 0}).second, "no refusal");
  EXPECT_THAT(refused({.side = 2, .diffusion = 1.25, .decay = 0}),
              Pair("diffusion",
                   "diffusion / side^2 is 0.3125; the explicit scheme is stable up to "
                   "1/4, that is 'diffusion' up to 1"));
  EXPECT_EQ(refused({.side = 2, .diffusion = 0.5, .decay = 0.5}).second, "no refusal");
  EXPECT_THAT(refused({.side = 2, .diffusion = 0.5, .decay = 0.625}),
              Pair("decay", HasSubstr("at most 1 - 4 diffusion / side^2 = 0.5")));
}

TEST(ToxinGradient, RefusesASourceOffTheGrid) {
  Parameters p{.resolution = 4, .side = 2};
  p.sources = {{.x = -4, .y = 3.9, .rate = 1}, {.x = 4, .y = 0, .rate = 1}};
  EXPECT_THAT(refusal([&] { Stage<ToxinGradient> stage(p); }),
              Pair("sources[1]",
                   "the source at (4, 0) is off the grid, which spans -4 to 4 on both "
                   "axes"));
}

}  // namespace
}  // namespace somas::environments
