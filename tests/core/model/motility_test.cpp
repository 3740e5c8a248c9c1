// Crawling along gradients (section 3 of the model).
#include "core/model/motility.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

struct Force {
  double x = 0, y = 0;
};

/// Cells of a motile state over fields that nothing changes.
class MotilityBench : public Bench {
 public:
  MotilityBench() {
    free_living();
    config.max_steps = 100000;
    config.morphogens.kinds = {{1, 0}, {1, 0}};
    states = {{.name = "root"}, {.name = "motile", .parent = 0, .motility = 2.5}};
  }

  /// Sets every square to c(x, y) of its centre.
  template <class Concentration>
  void field(Concentration&& c, std::size_t kind = 0, std::size_t organism = 0) {
    MorphogenFields& fields = world().organisms[organism].fields;
    for (std::uint32_t row = 0; row < fields.size(); ++row)
      for (std::uint32_t column = 0; column < fields.size(); ++column)
        fields.set(kind, column, row,
                   static_cast<float>(c(fields.centre(column), fields.centre(row))));
  }
  /// What motility adds for the cells as they are now.
  [[nodiscard]] Force force_on(std::uint64_t id, std::uint16_t organism = 0) {
    Motility motility;
    motility.prepare(world());
    std::vector<double> fx(cells().size()), fy(cells().size());
    motility.add(fx, fy);
    return {fx[at(id, organism)], fy[at(id, organism)]};
  }
};

/// Slope 5/1024 towards (0.6, 0.8); exact in single precision.
double slanted(double x, double y) { return 0.5 + 3.0 / 1024 * x + 4.0 / 1024 * y; }

TEST(Motility, PushesAlongALinearFieldsGradientWithItsWholeStrength) {
  MotilityBench bench;
  Dice dice(1);
  for (int trial = 0; trial < 200; ++trial) {
    bench.start_with(
        {{.id = 0, .x = dice.uniform(-59, 59), .y = dice.uniform(-59, 59), .state = 1}});
    bench.field(slanted);
    const Force force = bench.force_on(0);
    EXPECT_NEAR(force.x, 2.5 * 0.6, 1e-12);
    EXPECT_NEAR(force.y, 2.5 * 0.8, 1e-12);
  }
}

TEST(Motility, IsDownTheGradientWhenNegative) {
  MotilityBench bench;
  bench.states[1].motility = -1;
  bench.start_with({{.id = 0, .x = 3, .y = 4, .state = 1}});
  bench.field(slanted);
  EXPECT_NEAR(bench.force_on(0).x, -0.6, 1e-12);
  EXPECT_NEAR(bench.force_on(0).y, -0.8, 1e-12);
}

TEST(Motility, DoesNotDependOnHowSteepTheGradientIsAboveAMillionth) {
  for (const double slope : {1e-3, 1.1e-6, 0.9e-6, 0.0}) {
    MotilityBench bench;
    bench.start_with({{.id = 0, .state = 1}});
    bench.field([&](double x, double) { return 1e-4 + slope * x; });
    EXPECT_NEAR(bench.force_on(0).x, slope > 1e-6 ? 2.5 : 0.0, 1e-9) << slope;
    EXPECT_EQ(bench.force_on(0).y, 0) << slope;
  }
}

TEST(Motility, FollowsTheSignalOfTheState) {
  MotilityBench bench;
  bench.states[1].motility_signal = 1;
  bench.start_with({{.id = 0, .state = 1}});
  bench.field([](double x, double) { return 0.5 + x / 1024; }, 0);
  bench.field([](double, double y) { return 0.5 - y / 1024; }, 1);
  EXPECT_EQ(bench.force_on(0).x, 0);
  EXPECT_EQ(bench.force_on(0).y, -2.5);
}

TEST(Motility, FollowsTheFieldOfTheOwnOrganismOnly) {
  MotilityBench bench;
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.start_with({{.id = 0, .state = 1}, {.id = 0, .x = 5, .state = 1, .organism = 1}});
  bench.field(slanted, 0, 1);
  EXPECT_EQ(bench.force_on(0, 0).x, 0);
  EXPECT_NEAR(bench.force_on(0, 1).x, 1.5, 1e-12);
}

TEST(Motility, IsThatOfLiveCellsOfMotileStates) {
  MotilityBench bench;
  bench.start_with(
      {{.id = 0, .state = 0}, {.id = 1, .x = 9, .state = 1}, {.id = 2, .y = 9, .state = 1}});
  bench.field(slanted);
  bench.cells().kill(bench.at(1), cause_starvation);
  EXPECT_EQ(bench.force_on(0).x, 0) << "a state without motility";
  EXPECT_EQ(bench.force_on(1).x, 0) << "dead";
  EXPECT_NEAR(bench.force_on(2).x, 1.5, 1e-12);
}

TEST(Motility, GoesOnDuringEveryAction) {
  for (const std::string wish : {"quiescence", "division", "apoptosis", "specialize.leaf"}) {
    MotilityBench bench;
    bench.states.push_back({.name = "leaf", .parent = 1});
    bench.script = [&](const Lane& lane) { lane.out(wish, 1); };
    bench.start_with({{.id = 0, .state = 1}});
    bench.field(slanted);
    bench.steps(2);
    ASSERT_NE(bench.cells().action[0], Action::none) << wish;
    EXPECT_GT(bench.cells().vx[0], 0) << wish;
  }
}

TEST(Motility, LoneCellApproachesForceOverDrag) {
  for (const double drag : {0.5, 1.0, 4.0}) {
    MotilityBench bench;
    bench.config.mechanics.drag = drag;
    bench.states[1].motility = 0.25;
    bench.states[1].mass = 2;
    bench.start_with({{.id = 0, .x = -20, .y = -20, .state = 1}});
    bench.field(slanted);
    // Semi-implicit Euler: v_n = F / drag (1 - (1 - h drag / m)^n).
    const double h = 1.0 / 30;
    bench.steps(10);
    const double speed = 0.25 / drag * (1 - std::pow(1 - h * drag / 2, 30));
    EXPECT_NEAR(bench.cells().vx[0], 0.6 * speed, 1e-12);
    EXPECT_NEAR(bench.cells().vy[0], 0.8 * speed, 1e-12);
    bench.steps(590);
    EXPECT_NEAR(std::hypot(bench.cells().vx[0], bench.cells().vy[0]), 0.25 / drag, 1e-6);
  }
}

TEST(Motility, KeepsTheForceOfTheStartThroughoutAStep) {
  // The gradient turns round at x = 0, which the cell passes in the middle of the step.
  MotilityBench bench;
  bench.config.mechanics.drag = 0;
  bench.start_with({{.id = 0, .x = -2, .vx = 60, .state = 1}});
  bench.field([](double x, double) { return 0.5 - std::abs(x) / 128; });
  bench.steps(1);
  EXPECT_GT(bench.cells().x[0], 3);
  EXPECT_NEAR(bench.cells().vx[0], 60 + 3 * 2.5 / 30, 1e-12);
  bench.steps(1);
  EXPECT_NEAR(bench.cells().vx[0], 60, 1e-12) << "now it is pushed back";
}

TEST(Motility, AddsToTheForcesOfEnvironments) {
  MotilityBench bench;
  bench.config.mechanics.drag = 0;
  std::vector<double> seen;
  bench.environments = {acting("wind", Phase::forces, [&](World& world) {
    seen.push_back(world.force_x()[0]);
    world.force_x()[0] += 3;
  })};
  bench.start_with({{.id = 0, .state = 1}});
  bench.field(slanted);
  bench.steps(1);
  EXPECT_NEAR(bench.cells().vx[0], 3 * (3 + 1.5) / 30, 1e-12);
  EXPECT_NEAR(bench.cells().vy[0], 3 * 2.0 / 30, 1e-12);
  EXPECT_EQ(seen, (std::vector<double>{0, 0, 0})) << "environments do not see it";
}

TEST(Motility, BringsACellToTheSourceOfItsSignal) {
  // A cell that does not move emits; one that crawls up its signal comes to adhere to it, one that
  // crawls down the signal goes away.
  for (const double motility : {1.0, -1.0}) {
    MotilityBench bench;
    bench.config.morphogens.kinds = {{0.05, 0.05}};
    bench.states[1].motility = motility;
    bench.script = [](const Lane& lane) { lane.out("morphogen.0", lane.id == 0 ? 1.0f : 0.0f); };
    bench.start_with({{.id = 0}, {.id = 1, .x = 13, .y = -8, .state = 1}});
    bench.steps(300);
    const CellStore& cells = bench.cells();
    const double distance = std::hypot(cells.x[bench.at(0)] - cells.x[bench.at(1)],
                                       cells.y[bench.at(0)] - cells.y[bench.at(1)]);
    if (motility > 0)
      EXPECT_EQ(bench.world().contacts.of(bench.at(0)).size(), 1u) << distance;
    else
      EXPECT_GT(distance, 30);
  }
}

}  // namespace
}  // namespace somas::model::test
