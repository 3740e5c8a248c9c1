// The environments in a whole simulation: a founder that rests, eats and never divides.
#include <gtest/gtest.h>

#include "plugins/environments/cyclic_nutrients/cyclic_nutrients.hpp"
#include "plugins/environments/nutrients/nutrients.hpp"
#include "plugins/environments/particle_aggression/particle_aggression.hpp"
#include "plugins/environments/seasons/seasons.hpp"
#include "plugins/environments/two_nutrients/two_nutrients.hpp"
#include "plugins/environments/walls/walls.hpp"
#include "tests/plugins/environments/resting_life.hpp"

namespace somas::environments {
namespace {

/// A constant force along x.
class Wind final : public Environment {
 public:
  void declare(Declare& declare) override { declare.acts_in(Phase::forces); }
  void act(Phase, World& world) const override {
    for (double& force : world.force_x()) force += 0.5;
  }
};

model::Config short_run() {
  model::Config config;
  config.max_steps = 300;
  return config;
}

TEST(Simulation, RestingNSurvivesOnNutrientsToTheEnd) {
  const Ending ending =
      live({named<Nutrients>("nutrients")}, {{"production", 3}, {"capacity", 10}}, short_run());
  EXPECT_TRUE(ending.outcome.censored);
  EXPECT_EQ(ending.outcome.survival, 300u);
}

TEST(Simulation, RestingNOfExperiment2DiesInTheFirstLongGap) {
  // Model, section 8: its reserves last 28 steps; the gap of steps 643-672 is the first longer one.
  model::Config config;
  config.metabolism.quiescence_cost = 0.05;
  const Ending ending =
      live({named<CyclicNutrients>("nutrients")}, {{"production", 3}, {"capacity", 0.5}}, config);
  EXPECT_FALSE(ending.outcome.censored);
  EXPECT_GE(ending.outcome.survival, 643u);
  EXPECT_LE(ending.outcome.survival, 672u);
}

TEST(Simulation, ResistanceDelaysDeathByParticles) {
  const auto survival = [](double resistance) {
    const Ending ending =
        live({named<Nutrients>("nutrients"), named<ParticleAggression>("particles")},
             {{"production", 3}, {"capacity", 10}, {"resistance", resistance}});
    return ending.outcome.survival;
  };
  EXPECT_LT(survival(0), survival(10));
  EXPECT_LT(survival(10), 3000u);
  EXPECT_EQ(survival(1e9), 3000u);
}

Seasons::Cycle scarcity(double amplitude) {
  return {.shape = "square", .period = 100000, .amplitude = amplitude, .phase = 0.5};
}

TEST(Simulation, SeasonsChangeTheFoodOfOthers) {
  // N eats what grows in its patch, 0.04 a step, and burns 0.03; a tenth of that is too little.
  const auto survival = [](std::vector<Seasons::Cycle> cycles, bool seasons_first) {
    Nutrients::Parameters food;
    food.patches.regeneration = 0.04;
    food.initial = 0;
    std::vector<model::NamedEnvironment> environments{named<Nutrients>("nutrients", food)};
    if (!cycles.empty())
      environments.insert(seasons_first ? environments.begin() : environments.end(),
                          named<Seasons>("seasons", {cycles}));
    return live(std::move(environments), {{"production", 3}, {"capacity", 5}}, short_run())
        .outcome.survival;
  };
  for (const bool first : {true, false}) {
    EXPECT_EQ(survival({}, first), 300u);
    EXPECT_EQ(survival({scarcity(0)}, first), 300u) << "nothing changes";
    EXPECT_LT(survival({scarcity(0.9)}, first), 300u);
    EXPECT_EQ(survival({scarcity(0.9)}, first), survival({scarcity(0.9)}, !first));
  }
}

TEST(Simulation, BothSkillsKeepABodyAliveOnTwoNutrientsAndOneDoesNot) {
  const auto survival = [](std::map<std::string, double> skills) {
    skills["capacity"] = 1;
    TwoNutrients::Parameters food;
    food.initial = 1;
    food.regeneration = 0.002;
    return live({named<TwoNutrients>("food", food)}, std::move(skills)).outcome.survival;
  };
  const std::uint64_t a = survival({{"production_a", 1}}), b = survival({{"production_b", 1}});
  EXPECT_EQ(a, b);
  EXPECT_LT(a, 200u);
  EXPECT_EQ(survival({{"production_a", 1}, {"production_b", 1}}), 3000u);
}

TEST(Simulation, SameSeedGivesTheSameBytes) {
  const auto hash = [](std::uint64_t seed) {
    return live({named<Nutrients>("nutrients"), named<ParticleAggression>("particles")},
                {{"production", 3}, {"capacity", 10}, {"resistance", 1e9}}, short_run(), seed)
        .hash;
  };
  EXPECT_EQ(hash(1), hash(1));
  EXPECT_NE(hash(1), hash(2));
}

TEST(Simulation, ThreadsShareManyParticlesAndPatchesAndGiveTheSameBytes) {
  // Some 200,000 in flight: several rounds of blocks for each thread.
  ParticleAggression::Parameters crowd;
  crowd.start = 0;
  crowd.spawn_radius = 30;
  crowd.speed = 1;
  crowd.rate_constant = 4000;
  Nutrients::Parameters food;
  food.patches.resolution = 512;
  const auto hash = [&](unsigned threads, double resistance) {
    model::Config config;
    config.max_steps = 60;
    const Ending ending =
        live({named<Nutrients>("nutrients", food), named<ParticleAggression>("particles", crowd)},
             {{"production", 3}, {"capacity", 10}, {"resistance", resistance}}, config, 1, threads);
    EXPECT_EQ(ending.outcome.censored, resistance > 1e6) << "it is hit";
    return ending.hash;
  };
  for (const double resistance : {1e9, 1000.0}) {
    const std::uint64_t alone = hash(1, resistance);
    for (const unsigned threads : {2u, 3u, 7u}) EXPECT_EQ(hash(threads, resistance), alone);
  }
}

TEST(Simulation, AGapLetsACellThroughThatIsNarrowerAndNoOther) {
  // A cell of radius 1 is blown against a wall with the gap ahead. Wind over drag is a speed of
  // 0.5, so 30 lengths in these 600 steps of 0.1.
  const auto end = [](double gap_width) {
    Walls::Parameters walls;
    walls.obstacles.push_back({.kind = "gap_wall",
                               .x = 8,
                               .half_height = 20,
                               .thickness = 2,
                               .gap_y = 0,
                               .gap_width = gap_width});
    model::Config config;
    config.max_steps = 600;
    config.metabolism.quiescence_cost = 0;
    const Ending ending = live({{"wind", std::make_shared<Wind>()}, named<Walls>("walls", walls)},
                               {{"capacity", 10}}, config);
    EXPECT_EQ(ending.outcome.survival, 600u);
    return ending.x;
  };
  EXPECT_GT(end(2.2), 20);
  EXPECT_LT(end(1.8), 8);
  EXPECT_LT(end(0.5), 8);
}

}  // namespace
}  // namespace somas::environments
