// Every bundled environment keeps the contract of the SDK.
#include <algorithm>
#include <functional>
#include <memory>
#include <ostream>
#include <string>

#include <gmock/gmock.h>

#include "somas/sdk/testing/environment.hpp"

#include "plugins/environments/cyclic_nutrients/cyclic_nutrients.hpp"
#include "plugins/environments/nutrients/nutrients.hpp"
#include "plugins/environments/particle_aggression/particle_aggression.hpp"
#include "plugins/environments/seasons/seasons.hpp"
#include "plugins/environments/toxin_gradient/toxin_gradient.hpp"
#include "plugins/environments/two_nutrients/two_nutrients.hpp"
#include "plugins/environments/walls/walls.hpp"

namespace somas::environments {
namespace {

struct Case {
  std::string name;
  std::function<somas::testing::Failures()> check;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// A class with parameters that make everything happen within the steps of the check.
template <class E>
Case conforms(std::string name, typename E::Parameters parameters = typename E::Parameters(),
              somas::testing::EnvironmentOptions options = {}) {
  return {std::move(name),
          [=] { return somas::testing::check_environment<E>(parameters, options); }};
}

Nutrients::Parameters disc() {
  Nutrients::Parameters parameters;
  parameters.initial = 0.5;
  parameters.region = "disc";
  parameters.radius = 20;
  return parameters;
}

CyclicNutrients::Parameters short_gaps() {
  CyclicNutrients::Parameters parameters;
  parameters.present = 8;
  parameters.first_gap = 3;
  return parameters;
}

Seasons::Parameters short_years() {
  Seasons::Parameters parameters;
  parameters.cycles.resize(1);
  parameters.cycles[0].period = 7;
  parameters.cycles[0].from = 3;
  return parameters;
}

/// Something to vary.
somas::testing::EnvironmentOptions with_nutrients() {
  somas::testing::EnvironmentOptions options;
  options.variables = {{"nutrients", "regeneration", {.value = 0.15, .minimum = 0}}};
  return options;
}

Walls::Parameters room_with_a_pillar() {
  Walls::Parameters parameters;
  parameters.obstacles.resize(2);
  parameters.obstacles[0].kind = "enclosure";
  parameters.obstacles[0].x = parameters.obstacles[0].y = 0;
  parameters.obstacles[0].half_width = parameters.obstacles[0].half_height = 8;
  parameters.obstacles[1].kind = "disc";
  parameters.obstacles[1].x = parameters.obstacles[1].y = 3;
  parameters.obstacles[1].radius = 2;
  return parameters;
}

ToxinGradient::Parameters strong_poison() {
  ToxinGradient::Parameters parameters;
  parameters.edge = "left";
  parameters.toxicity = 2;
  return parameters;
}

class EnvironmentConformance : public ::testing::TestWithParam<Case> {};

TEST_P(EnvironmentConformance, KeepsTheContract) {
  EXPECT_THAT(GetParam().check(), ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Bundled, EnvironmentConformance,
    ::testing::Values(
        conforms<Nutrients>("nutrients"), conforms<Nutrients>("nutrients_of_a_disc", disc()),
        conforms<CyclicNutrients>("cyclic_nutrients", short_gaps()),
        conforms<ParticleAggression>("particle_aggression",
                                     {.spawn_radius = 20, .speed = 1.5, .rate_constant = 6}),
        conforms<ParticleAggression>("particle_aggression_later", {.start = 20}),
        conforms<Seasons>("seasons", short_years(), with_nutrients()),
        conforms<ToxinGradient>("toxin_gradient", strong_poison()),
        conforms<TwoNutrients>("two_nutrients"), conforms<Walls>("walls", room_with_a_pillar())),
    [](const auto& test) { return test.param.name; });

/// Nutrients grow by what each patch has room for; nothing else comes or goes.
TEST(Nutrients, GrowByTheRoomOfEveryPatch) {
  const Nutrients::Parameters parameters;
  somas::testing::EnvironmentOptions options;
  options.total = [](somas::testing::TestWorld& world) {
    double sum = 0;
    for (const double content : world.grid("it", "content").values) sum += content;
    return sum;
  };
  options.change = [&](somas::testing::TestWorld& world) {
    const double growth = world.step() / 10 % 2 == 1 ? parameters.patches.regeneration / 2
                                                     : parameters.patches.regeneration;
    double sum = 0;
    for (const double content : world.grid("it", "content").values)
      sum += std::min(growth, parameters.patches.capacity - content);
    return sum;
  };
  EXPECT_THAT(somas::testing::check_environment<Nutrients>(parameters, options),
              ::testing::IsEmpty());
}

/// The check above sees the meals: the cells did eat, so that there was room to grow into.
TEST(Nutrients, AreTakenUpByTheCellsOfATestWorld) {
  const somas::testing::EnvironmentStage stage(std::make_unique<Nutrients>(Nutrients::Parameters()),
                                               {});
  const auto world = stage.world(1);
  world->begin();
  while (world->step() < 20) world->advance();
  EXPECT_GT(world->eaten()[0], 1.0);
}

}  // namespace
}  // namespace somas::environments
