#include "plugins/environments/seasons/seasons.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::ElementsAre;
using testing::Pair;

Seasons::Cycle cycle_of(const std::string& shape, std::int64_t period, double phase = 0,
                        std::int64_t from = 0) {
  return {.environment = "food",
          .parameter = "growth",
          .shape = shape,
          .period = period,
          .amplitude = 0.5,
          .phase = phase,
          .from = from};
}

/// Lets the given parameters vary, each once.
class FakeConnections final : public Connections {
 public:
  explicit FakeConnections(std::map<std::string, VariableSpec> known) : known_(std::move(known)) {}
  Variable vary(std::string_view instance, std::string_view parameter) override {
    const std::string name = std::string(instance) + "." + std::string(parameter);
    const auto found = known_.find(name);
    if (found == known_.end()) throw std::runtime_error("no " + name);
    const Variable variable{next_++, found->second};
    known_.erase(found);
    return variable;
  }

 private:
  std::map<std::string, VariableSpec> known_;
  Id next_ = 0;
};

std::pair<std::string, std::string> refusal_to_connect(const Seasons::Parameters& parameters,
                                                       const VariableSpec& spec) {
  return refusal([&] {
    Seasons seasons(parameters);
    FakeConnections connections({{"food.growth", spec}});
    seasons.connect(connections);
  });
}

TEST(Wave, FollowsItsFormulaThroughAPeriod) {
  for (int k = 0; k < 40; ++k) {
    const double u = k / 40.0;
    const auto t = static_cast<std::uint64_t>(k);
    EXPECT_NEAR(cycle_of("sine", 40).wave(t), std::sin(2 * std::numbers::pi * u), 1e-15);
    EXPECT_EQ(cycle_of("square", 40).wave(t), k < 20 ? 1 : -1);
    const double triangle = std::asin(std::sin(2 * std::numbers::pi * u)) * 2 / std::numbers::pi;
    EXPECT_NEAR(cycle_of("triangle", 40).wave(t), triangle, 1e-14);
    EXPECT_DOUBLE_EQ(cycle_of("ramp", 40).wave(t), u);
  }
  EXPECT_EQ(cycle_of("ramp", 40).wave(1000), 1);
}

TEST(Wave, RepeatsItselfExactly) {
  for (const char* shape : {"sine", "square", "triangle"})
    for (std::uint64_t t = 0; t < 37; ++t)
      EXPECT_EQ(cycle_of(shape, 37, 0.3).wave(t), cycle_of(shape, 37, 0.3).wave(t + 37 * 1000003));
}

TEST(Wave, IsZeroOnAverageOverAPeriod) {
  for (const char* shape : {"sine", "square", "triangle"}) {
    double sum = 0;
    for (std::uint64_t t = 0; t < 60; ++t) sum += cycle_of(shape, 60, 0.1).wave(t);
    EXPECT_NEAR(sum, 0, 1e-12) << shape;
  }
}

TEST(Wave, BeginsWhereThePhaseSays) {
  EXPECT_NEAR(cycle_of("sine", 100, 0.25).wave(0), 1, 1e-15);
  EXPECT_EQ(cycle_of("square", 100, 0.5).wave(0), -1);
  EXPECT_EQ(cycle_of("triangle", 100, 0.75).wave(0), -1);
}

TEST(Wave, IsZeroBeforeItsFirstStep) {
  for (const char* shape : {"sine", "square", "triangle", "ramp"})
    for (std::uint64_t t = 0; t < 50; ++t)
      EXPECT_EQ(cycle_of(shape, 40, 0.25, 50).wave(t), 0) << shape;
  EXPECT_NEAR(cycle_of("sine", 40, 0.25, 50).wave(50), 1, 1e-15);
}

TEST(Seasons, SetsEveryParameterByItsOwnCycle) {
  Seasons seasons({{cycle_of("square", 10),
                    {.environment = "enemy", .parameter = "rate", .shape = "ramp", .period = 4}}});
  FakeDeclare declared({60, 100, 3, 1.0 / 30}, "seasons");
  seasons.declare(declared);
  EXPECT_THAT(declared.phases, ElementsAre(Phase::parameters));
  FakeConnections connections({{"food.growth", {.value = 4}}, {"enemy.rate", {.value = 3}}});
  seasons.connect(connections);
  FakeWorld world({60, 100, 3, 1.0 / 30}, 1, declared);
  world.parameters = {-1, -1};
  for (std::uint64_t t = 0; t < 30; ++t) {
    world.set_step(t);
    seasons.act(Phase::parameters, world);
    EXPECT_EQ(world.parameters[0], t % 10 < 5 ? 6 : 2);
    EXPECT_DOUBLE_EQ(world.parameters[1], t < 4 ? 3 + 0.75 * static_cast<double>(t) : 6);
  }
}

TEST(Seasons, RefusesWhatNobodyLetsVary) {
  EXPECT_THAT(
      refusal_to_connect({{cycle_of("sine", 10), {.environment = "food", .parameter = "colour"}}},
                         {.value = 1}),
      Pair("cycles[1].parameter", "no food.colour"));
}

TEST(Seasons, RefusesTheSameParameterTwice) {
  EXPECT_THAT(refusal_to_connect({{cycle_of("sine", 10), cycle_of("ramp", 10)}}, {.value = 1}),
              Pair("cycles[1].parameter", "no food.growth"));
}

TEST(Seasons, RefusesACycleThatChangesNothing) {
  EXPECT_THAT(refusal_to_connect({{cycle_of("sine", 10)}}, {.value = 0}),
              Pair("cycles[0].parameter",
                   "'food.growth' is 0 in this experiment, and 0 times anything is 0"));
}

TEST(Seasons, RefusesToLeaveTheRangeOfAParameter) {
  auto deep = cycle_of("sine", 10);
  deep.amplitude = 1.1;
  const VariableSpec spec{.value = 1, .minimum = 0, .maximum = 2.1};
  EXPECT_THAT(
      refusal_to_connect({{deep}}, spec),
      Pair("cycles[0].amplitude", "with this amplitude 'food.growth' would leave its range"));
  deep.shape = "ramp";  // goes up only
  EXPECT_EQ(refusal_to_connect({{deep}}, spec).first, "");
  deep.amplitude = 1.2;
  EXPECT_EQ(refusal_to_connect({{deep}}, spec).first, "cycles[0].amplitude");
  deep.amplitude = -1.1;
  EXPECT_EQ(refusal_to_connect({{deep}}, spec).first, "cycles[0].amplitude");
}

TEST(Seasons, NeedsACycle) {
  EXPECT_THAT(refusal([] { Seasons({}); }), Pair("cycles", "seasons need at least one cycle"));
}

}  // namespace
}  // namespace somas::environments
