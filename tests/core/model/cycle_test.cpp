// Section 4 of the model: the four actions, their durations, gates and effects.
#include "core/model/cycle.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Outputs by name that a cell writes until told otherwise.
using Wishes = std::map<std::string, float>;

/// Cells do what `wish` says of their id, live for nothing and all but stand still.
class CycleBench : public Bench {
 public:
  std::map<std::uint64_t, Wishes> wish;

  CycleBench() {
    free_living();
    config.mechanics.time_step = 1e-9;
    states[0].skills = {{"capacity", 10}};
    script = [this](const Lane& lane) {
      const auto found = wish.find(lane.id);
      if (found == wish.end()) return;
      for (const auto& [name, value] : found->second) lane.out(name, value);
    };
  }
  [[nodiscard]] Action action(std::uint64_t id) { return cells().action[at(id)]; }
  [[nodiscard]] std::size_t count() { return cells().size(); }
};

// ---- durations ----------------------------------------------------------------------------------

TEST(Durations, DivisionTakesEffectInItsTwentiethStep) {
  CycleBench bench;
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(19);
  EXPECT_EQ(bench.count(), 1u);
  bench.steps(1);
  EXPECT_EQ(bench.count(), 2u);
  EXPECT_EQ(bench.cells().born[bench.at(1)], 19u) << "chosen at 0, takes effect at 0 + 20 - 1";
}

TEST(Durations, QuiescenceLocksForFiveSteps) {
  CycleBench bench;
  bench.wish[0] = {{"quiescence", 1}};
  bench.start();
  bench.steps(1);
  bench.wish[0] = {{"division", 1}};
  bench.steps(4);
  EXPECT_EQ(bench.cells().radius[0], 1) << "steps 1 to 4 are still quiescent";
  bench.steps(1);
  EXPECT_EQ(bench.action(0), Action::division);
  EXPECT_GT(bench.cells().radius[0], 1);
}

TEST(Durations, ApoptosisKillsInItsFifthStep) {
  CycleBench bench;
  bench.wish[0] = {{"apoptosis", 1}};
  bench.start();
  bench.steps(4);
  EXPECT_EQ(bench.count(), 1u);
  bench.steps(1);
  EXPECT_EQ(bench.count(), 0u);
  EXPECT_EQ(bench.deaths("apoptosis"), 1u);
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 4u);
}

TEST(Durations, SpecializationChangesTheStateInItsTenthStep) {
  CycleBench bench;
  bench.states.push_back({.name = "leaf", .parent = 0});
  bench.wish[0] = {{"specialize.leaf", 1}};
  bench.start();
  bench.steps(9);
  EXPECT_EQ(bench.cells().state[0], 0);
  bench.steps(1);
  EXPECT_EQ(bench.cells().state[0], 1);
}

TEST(Durations, AreTheExperiments) {
  CycleBench bench;
  bench.states.push_back({.name = "leaf", .parent = 0});
  bench.config.cycle.quiescence_steps = 1;
  bench.config.cycle.division_steps = 3;
  bench.config.cycle.apoptosis_steps = 2;
  bench.config.cycle.specialization_steps = 4;
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(2);
  EXPECT_EQ(bench.count(), 1u);
  bench.steps(1);
  ASSERT_EQ(bench.count(), 2u);
  bench.wish[0] = {{"specialize.leaf", 1}};
  bench.wish[1] = {{"apoptosis", 1}};
  bench.steps(1);
  EXPECT_TRUE(bench.alive(1));
  bench.steps(1);
  EXPECT_FALSE(bench.alive(1));
  bench.steps(1);
  EXPECT_EQ(bench.cells().state[0], 0);
  bench.steps(1);
  EXPECT_EQ(bench.cells().state[0], 1);
}

// ---- choosing -----------------------------------------------------------------------------------

/// The action that a root cell with leaf children "x" and "y" chooses.
std::pair<Action, std::uint16_t> chosen(const Wishes& wishes) {
  CycleBench bench;
  bench.states.push_back({.name = "x", .parent = 0});
  bench.states.push_back({.name = "y", .parent = 0});
  bench.wish[0] = wishes;
  bench.start();
  bench.steps(1);
  return {bench.cells().action[0], bench.cells().target[0]};
}

TEST(Choice, IsTheStrongestOutput) {
  EXPECT_EQ(chosen({{"quiescence", 0.4f}, {"division", 0.3f}}).first, Action::quiescence);
  EXPECT_EQ(chosen({{"quiescence", 0.3f}, {"division", 0.4f}}).first, Action::division);
  EXPECT_EQ(chosen({{"apoptosis", 0.5f}, {"division", 0.4f}}).first, Action::apoptosis);
  const auto y = chosen({{"apoptosis", 0.5f}, {"specialize.x", 0.6f}, {"specialize.y", 0.7f}});
  EXPECT_EQ(y, std::pair(Action::specialization, std::uint16_t{2}));
}

TEST(Choice, AmongSaturatedOutputsIsByTheUnclampedValue) {
  EXPECT_EQ(chosen({{"quiescence", 1.0f}, {"apoptosis", 1.5f}, {"division", 1.25f}}).first,
            Action::apoptosis);
  EXPECT_EQ(chosen({{"quiescence", -2.0f},
                    {"division", -0.5f},
                    {"apoptosis", -1.0f},
                    {"specialize.x", -3.0f},
                    {"specialize.y", -3.0f}})
                .first,
            Action::division);
}

TEST(Choice, TiesGoToQuiescenceDivisionSpecializationApoptosis) {
  EXPECT_EQ(chosen({}).first, Action::quiescence);
  Wishes wishes{{"quiescence", 1},
                {"division", 1},
                {"specialize.x", 1},
                {"specialize.y", 1},
                {"apoptosis", 1}};
  EXPECT_EQ(chosen(wishes).first, Action::quiescence);
  wishes["quiescence"] = 0;
  EXPECT_EQ(chosen(wishes).first, Action::division);
  wishes["division"] = 0;
  EXPECT_EQ(chosen(wishes), std::pair(Action::specialization, std::uint16_t{1}));
  wishes["specialize.x"] = 0;
  EXPECT_EQ(chosen(wishes), std::pair(Action::specialization, std::uint16_t{2}));
  wishes["specialize.y"] = 0;
  EXPECT_EQ(chosen(wishes).first, Action::apoptosis);
}

TEST(Choice, IsNeverMadeByNotANumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(chosen({{"apoptosis", nan}}).first, Action::quiescence);
  EXPECT_EQ(chosen({{"quiescence", nan}, {"division", 0.1f}}).first, Action::division);
  EXPECT_EQ(chosen({{"quiescence", nan},
                    {"division", nan},
                    {"apoptosis", nan},
                    {"specialize.x", nan},
                    {"specialize.y", nan}})
                .first,
            Action::quiescence);
}

TEST(Choice, AtALeafSpecializationIsNoCandidate) {
  CycleBench bench;
  bench.states.push_back({.name = "leaf", .parent = 0});
  bench.states.push_back({.name = "other", .parent = 0});
  bench.wish[0] = {{"specialize.other", 5}, {"specialize.leaf", 5}, {"apoptosis", 1}};
  bench.start_with({{.id = 0, .state = 1}});
  bench.steps(1);
  EXPECT_EQ(bench.action(0), Action::apoptosis);
}

TEST(Choice, OffersOnlyTheChildrenOfTheOwnState) {
  CycleBench bench;
  bench.states.push_back({.name = "middle", .parent = 0});
  bench.states.push_back({.name = "deep", .parent = 1});
  bench.wish[0] = {{"specialize.deep", 5}, {"specialize.middle", 1}};
  bench.wish[1] = {{"specialize.deep", 5}, {"specialize.middle", 9}};
  bench.start_with({{.id = 0, .state = 0}, {.id = 1, .x = 20, .state = 1}});
  bench.steps(10);
  EXPECT_EQ(bench.cells().state[bench.at(0)], 1);
  EXPECT_EQ(bench.cells().state[bench.at(1)], 2) << "onward, never back";
  bench.wish[1] = {{"specialize.middle", 9}};
  bench.steps(15);
  EXPECT_EQ(bench.cells().state[bench.at(1)], 2);
  EXPECT_EQ(bench.action(1), Action::none) << "three times quiescent, as a leaf can only be";
}

// ---- thresholds ---------------------------------------------------------------------------------

/// What a cell chooses in a state with the given thresholds.
Choice chosen_above(const StateDef& thresholds, const Wishes& wishes) {
  CycleBench bench;
  bench.states[0] = thresholds;
  bench.states.push_back({.name = "x", .parent = 0});
  bench.states.push_back({.name = "y", .parent = 0});
  bench.wish[0] = wishes;
  bench.start();
  bench.steps(1);
  return {bench.cells().action[0], bench.cells().target[0]};
}

TEST(Thresholds, ExcludeAnActionWhoseOutputIsBelow) {
  const Wishes wishes{
      {"quiescence", 0.1f}, {"division", 0.7f}, {"specialize.y", 0.6f}, {"apoptosis", 0.5f}};
  EXPECT_EQ(chosen_above({}, wishes).action, Action::division);
  EXPECT_EQ(chosen_above({.division_threshold = 0.8}, wishes).action, Action::specialization);
  EXPECT_EQ(
      chosen_above({.division_threshold = 0.8, .specialization_threshold = 0.8}, wishes).action,
      Action::apoptosis);
  EXPECT_EQ(
      chosen_above(
          {.division_threshold = 0.8, .specialization_threshold = 0.8, .apoptosis_threshold = 0.8},
          wishes)
          .action,
      Action::quiescence);
}

TEST(Thresholds, AreReachedByAnEqualOutput) {
  for (const double threshold : {0.1, 0.3, 0.7, 1.0}) {
    const auto equal = static_cast<float>(threshold);
    const float below = std::nextafter(equal, 0.0f);
    EXPECT_EQ(chosen_above({.division_threshold = threshold}, {{"division", equal}}).action,
              Action::division);
    EXPECT_EQ(chosen_above({.division_threshold = threshold}, {{"division", below}}).action,
              Action::quiescence);
  }
}

TEST(Thresholds, AreComparedWithTheClampedOutputTheWinnerWithTheUnclamped) {
  const StateDef all{.quiescence_threshold = 1,
                     .division_threshold = 1,
                     .specialization_threshold = 1,
                     .apoptosis_threshold = 1};
  EXPECT_EQ(
      chosen_above(all, {{"quiescence", 1.5f}, {"apoptosis", 2.5f}, {"division", 0.99f}}).action,
      Action::apoptosis);
  // Below 0 an output counts as 0, which a threshold of 0 lets pass.
  EXPECT_EQ(chosen_above({}, {{"quiescence", -2.0f},
                              {"division", -1.0f},
                              {"specialize.x", -3.0f},
                              {"specialize.y", -3.0f},
                              {"apoptosis", -3.0f}})
                .action,
            Action::division);
}

TEST(Thresholds, OfQuiescenceLetsAWeakerActionWin) {
  const Wishes wishes{{"quiescence", 0.4f}, {"division", -0.2f}, {"apoptosis", 0.1f}};
  EXPECT_EQ(chosen_above({}, wishes).action, Action::quiescence);
  EXPECT_EQ(chosen_above({.quiescence_threshold = 0.5}, wishes).action, Action::apoptosis);
  EXPECT_EQ(chosen_above({.quiescence_threshold = 0.5,
                          .division_threshold = 0.2,
                          .specialization_threshold = 0.2,
                          .apoptosis_threshold = 0.2},
                         wishes)
                .action,
            Action::quiescence)
      << "nothing else is left";
}

TEST(Thresholds, OfSpecializationHoldsForEveryTarget) {
  const StateDef half{.specialization_threshold = 0.5};
  EXPECT_EQ(chosen_above(half, {{"specialize.x", 0.4f}, {"specialize.y", 0.49f}}).action,
            Action::quiescence);
  const Choice y = chosen_above(half, {{"specialize.x", 0.4f}, {"specialize.y", 0.5f}});
  EXPECT_EQ(y.action, Action::specialization);
  EXPECT_EQ(y.target, 2);
}

TEST(Thresholds, AreThoseOfTheCellsOwnState) {
  CycleBench bench;
  bench.states.push_back({.name = "shy", .parent = 0, .division_threshold = 0.9});
  bench.wish[0] = bench.wish[1] = {{"division", 0.5f}};
  bench.start_with({{.id = 0}, {.id = 1, .x = 20, .state = 1}});
  bench.steps(1);
  EXPECT_EQ(bench.action(0), Action::division);
  EXPECT_EQ(bench.action(1), Action::quiescence);
}

TEST(Thresholds, AreNotPassedByNotANumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(chosen_above({.quiescence_threshold = 0.5},
                         {{"division", nan}, {"apoptosis", 0.1f}, {"quiescence", 0.1f}})
                .action,
            Action::apoptosis);
}

// ---- locks --------------------------------------------------------------------------------------

TEST(Locks, HoldTheDecisionWhileAllElseGoesOn) {
  struct Case {
    const char* name;
    Action action;
    int steps;
  };
  for (const Case& c :
       {Case{"quiescence", Action::quiescence, 5}, Case{"division", Action::division, 20},
        Case{"apoptosis", Action::apoptosis, 5},
        Case{"specialize.leaf", Action::specialization, 10}}) {
    CycleBench bench;
    bench.config.morphogens.kinds = {{0.1, 1.0}};  // gone within a step
    bench.states[0].skills = {{"capacity", 100}, {"production", 1}};
    bench.states.push_back({.name = "leaf", .parent = 0, .skills = {{"capacity", 100}}});
    bench.environments = {resource_grid("food", 1000)};
    const Wishes always{{"morphogen.0", 1}, {"uptake.food", 1}, {"conversion", 0.001f}};
    bench.wish[0] = always;
    bench.wish[0][c.name] = 1;
    bench.start_with({{.id = 0, .energy = 0.6}});
    bench.steps(1);
    for (const char* other : {"quiescence", "division", "apoptosis", "specialize.leaf"})
      bench.wish[0][other] = std::string(other) == c.name ? -1.0f : 100.0f;
    for (int step = 1; step < c.steps; ++step) {
      ASSERT_EQ(bench.action(0), c.action) << c.name << ' ' << step;
      ASSERT_EQ(bench.world().organisms[0].fields.value(0, 32, 32), 1.0f) << "it deposits";
      const double taken = bench.ledger().taken.value(), burnt = bench.ledger().burnt.value();
      ASSERT_NEAR(taken, step, 1e-9) << "it feeds";
      ASSERT_GT(burnt, 0);
      bench.steps(1);
      ASSERT_NEAR(bench.ledger().taken.value(), taken + 1, 1e-9);
      ASSERT_GT(bench.ledger().burnt.value(), burnt);
    }
    if (bench.alive(0)) {
      EXPECT_EQ(bench.action(0), Action::none) << c.name;
      bench.steps(1);
      EXPECT_NE(bench.action(0), Action::none) << "now it may choose again";
    }
  }
}

// ---- growth and gates ---------------------------------------------------------------------------

TEST(Division, GrowsTheRadiusSoThatTheAreaDoubles) {
  for (const std::uint32_t steps : {20u, 7u}) {
    CycleBench bench;
    bench.states[0].radius = 0.8;
    bench.config.cycle.division_steps = steps;
    bench.wish[0] = {{"division", 1}};
    bench.start();
    for (std::uint32_t k = 1; k < steps; ++k) {
      bench.steps(1);
      EXPECT_NEAR(bench.cells().radius[0], 0.8 * std::sqrt(1 + double(k) / steps), 1e-12);
    }
    bench.steps(1);
    EXPECT_EQ(bench.cells().radius[bench.at(0)], 0.8) << "two of the initial size";
    EXPECT_EQ(bench.cells().radius[bench.at(1)], 0.8);
  }
}

TEST(Division, KeepsTheMassWhileGrowing) {
  // A force of 1 through the whole of a division: constant acceleration.
  CycleBench bench;
  bench.config.mechanics = {.substeps = 1, .time_step = 0.01, .damping = 0, .drag = 0};
  bench.states[0].mass = 2;
  bench.environments = {acting("wind", Phase::forces, [](World& w) {
    for (double& f : w.force_x()) f += 1;
  })};
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(19);
  EXPECT_NEAR(bench.cells().vx[0], 19 * 0.01 / 2, 1e-12);
}

TEST(Division, NeedsEnergyWhenItBegins) {
  for (const auto& [energy, allowed] : {std::pair(0.6, true), std::pair(0.5999, false)}) {
    CycleBench bench;
    bench.wish[0] = {{"division", 1}};
    bench.start_with({{.id = 0, .energy = energy}});
    bench.steps(1);
    EXPECT_EQ(bench.action(0), allowed ? Action::division : Action::quiescence);
    bench.steps(4);
    EXPECT_EQ(bench.action(0), allowed ? Action::division : Action::none)
        << "what is not allowed becomes a whole quiescence";
    EXPECT_EQ(bench.simulation().state().organisms[0].outcome.refused_divisions, 0u)
        << "only the cap's refusals count";
  }
}

TEST(Division, OnceBegunDoesNotAskForEnergyAgain) {
  CycleBench bench;
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(1);
  bench.cells().energy[0] = 0.1;
  bench.cells().pressure[0] = 0.99;
  bench.steps(19);
  EXPECT_EQ(bench.count(), 2u);
}

TEST(Division, NeedsLowPressureWhenItBegins) {
  for (const auto& [pressure, allowed] : {std::pair(0.7, true), std::pair(0.7001, false)}) {
    CycleBench bench;
    bench.wish[0] = {{"division", 1}};
    bench.start();
    bench.cells().pressure[0] = pressure;
    bench.steps(1);
    EXPECT_EQ(bench.action(0), allowed ? Action::division : Action::quiescence);
  }
}

TEST(Division, StopsAtTheCapInAscendingIdAndCountsRefusals) {
  CycleBench bench;
  bench.config.max_cells = 6;
  // Id 9 lies in the first state and so first in storage; ids decide nevertheless.
  bench.states.push_back({.name = "other", .parent = 0});
  for (const std::uint64_t id : {9u, 2u, 7u, 4u}) bench.wish[id] = {{"division", 1}};
  bench.start_with({{.id = 9, .x = 0, .state = 0},
                    {.id = 2, .x = 10, .state = 1},
                    {.id = 7, .x = 20, .state = 0},
                    {.id = 4, .x = 30, .state = 1}});
  bench.steps(1);
  EXPECT_EQ(bench.action(2), Action::division);
  EXPECT_EQ(bench.action(4), Action::division);
  EXPECT_EQ(bench.action(7), Action::quiescence) << "4 live + 2 dividing reach 6";
  EXPECT_EQ(bench.action(9), Action::quiescence);
  EXPECT_EQ(bench.world().organisms[0].outcome.refused_divisions, 2u);
  bench.steps(5);  // at step 5 both ask again
  EXPECT_EQ(bench.world().organisms[0].outcome.refused_divisions, 4u);
  bench.steps(60);
  EXPECT_EQ(bench.count(), 6u);
}

TEST(Division, RefusalsOfTheCapDoNotCountCellsThatMayNotDivideAnyway) {
  CycleBench bench;
  bench.config.max_cells = 2;
  bench.wish[0] = bench.wish[1] = {{"division", 1}};
  bench.start_with({{.id = 0, .energy = 0.5}, {.id = 1, .x = 10}});
  bench.steps(1);
  EXPECT_EQ(bench.world().organisms[0].outcome.refused_divisions, 1u);
}

TEST(Division, CapIsEachOrganismsOwn) {
  CycleBench bench;
  bench.config.max_cells = 2;
  bench.founders = {{.key = 1}, {.key = 2, .x = 20}};
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(20);
  EXPECT_EQ(bench.world().organisms[0].live, 2u);
  EXPECT_EQ(bench.world().organisms[1].live, 2u);
}

// ---- the split ----------------------------------------------------------------------------------

TEST(Split, HalvesEnergyAndAmbrosia) {
  CycleBench bench;
  bench.wish[0] = {{"division", 1}};
  bench.start_with({{.id = 0, .energy = 0.9, .ambrosia = 7}});
  bench.steps(20);
  for (const std::uint64_t id : {0u, 1u}) {
    EXPECT_EQ(bench.cells().energy[bench.at(id)], 0.45);
    EXPECT_EQ(bench.cells().ambrosia[bench.at(id)], 3.5);
  }
  EXPECT_EQ(bench.world().organisms[0].outcome.divisions, 1u);
  EXPECT_EQ(bench.world().organisms[0].live, 2u);
}

/// Mother and daughter of a division at (3, -2) under a given stress.
struct Pair2 {
  double mx, my, dx, dy, mvx, mvy, dvx, dvy;
};

Pair2 split_under(double xx, double xy, double yy, std::uint64_t seed = 1, std::uint64_t id = 0,
                  double radius = 1) {
  CycleBench bench;
  bench.seed = seed;
  bench.states[0].radius = radius;
  bench.wish[id] = {{"division", 1}};
  bench.start_with({{.id = id, .x = 3, .y = -2, .vx = 0.3, .vy = -0.2}});
  bench.steps(19);
  CellStore& c = bench.cells();
  c.stress_xx[0] = xx, c.stress_xy[0] = xy, c.stress_yy[0] = yy;
  bench.steps(1);
  const std::uint32_t m = bench.at(id), d = bench.at(id + 1);
  return {c.x[m], c.y[m], c.x[d], c.y[d], c.vx[m], c.vy[m], c.vx[d], c.vy[d]};
}

TEST(Split, IsPerpendicularToTheMostCompressedAxis) {
  const double half = 0.5 * 23 / 13, diagonal = half / std::numbers::sqrt2;
  struct Case {
    double xx, xy, yy, ax, ay;
  };
  for (const Case& c : {Case{5, 0, 1, 0, half}, Case{1, 0, 5, half, 0},
                        Case{3, 2, 3, diagonal, -diagonal}, Case{3, -2, 3, diagonal, diagonal},
                        // 4 n n^T + 1 with n at 30 degrees
                        Case{4 * 0.75 + 1, 4 * std::sqrt(3.0) / 4, 4 * 0.25 + 1, half * 0.5,
                             -half * std::sqrt(3.0) / 2}}) {
    const Pair2 p = split_under(c.xx, c.xy, c.yy);
    EXPECT_NEAR(std::abs((p.mx - p.dx) * c.ax + (p.my - p.dy) * c.ay), 2 * half * half, 1e-6);
    EXPECT_NEAR((p.mx - p.dx) * c.ay - (p.my - p.dy) * c.ax, 0, 1e-6);
  }
}

TEST(Split, FollowsTheSqueezeOfRealNeighbours) {
  // Squeezed from left and right, a cell divides up and down.
  CycleBench bench;
  bench.wish[0] = {{"division", 1}};
  bench.start_with({{.id = 0}, {.id = 5, .x = 1.8, .y = 0}, {.id = 6, .x = -1.8, .y = 0}});
  bench.steps(20);
  EXPECT_NEAR(bench.cells().x[bench.at(0)], 0, 1e-5);
  EXPECT_NEAR(std::abs(bench.cells().y[bench.at(0)]), 0.5 * 23 / 13, 1e-5);
}

TEST(Split, PutsCentresHalfTheRestDistanceFromTheMothersWithHerVelocity) {
  for (const double radius : {1.0, 0.6}) {
    const Pair2 p = split_under(5, 0, 1, 1, 0, radius);
    EXPECT_NEAR(0.5 * (p.mx + p.dx), 3, 1e-7);
    EXPECT_NEAR(0.5 * (p.my + p.dy), -2, 1e-7);
    EXPECT_NEAR(std::hypot(p.mx - p.dx, p.my - p.dy), 23.0 / 13 * radius, 1e-7);
    EXPECT_NEAR(p.mvx, 0.3, 1e-6);
    EXPECT_NEAR(p.mvy, -0.2, 1e-6);
    EXPECT_NEAR(p.dvx, 0.3, 1e-6);
    EXPECT_NEAR(p.dvy, -0.2, 1e-6);
  }
}

TEST(Split, WithoutAnAxisIsRandomYetReproducible) {
  const auto angle = [](std::uint64_t seed, std::uint64_t id, double stress) {
    const Pair2 p = split_under(stress, 0, stress, seed, id);
    EXPECT_NEAR(std::hypot(p.mx - p.dx, p.my - p.dy), 23.0 / 13, 1e-7);
    return std::atan2(p.my - p.dy, p.mx - p.dx);
  };
  EXPECT_EQ(angle(1, 0, 0), angle(1, 0, 0));
  EXPECT_EQ(angle(1, 0, 0), angle(1, 0, 4)) << "equal eigenvalues, whatever they are";
  EXPECT_NE(angle(1, 0, 0), angle(2, 0, 0));
  EXPECT_NE(angle(1, 0, 0), angle(1, 1, 0));
  std::array<int, 4> quadrants{};
  for (std::uint64_t seed = 0; seed < 400; ++seed)
    ++quadrants[static_cast<std::size_t>((angle(seed, 0, 0) + std::numbers::pi) / 1.5708) & 3];
  for (const int n : quadrants) EXPECT_NEAR(n, 100, 40);
}

TEST(Split, CountsEigenvaluesWithinABillionthAsEqual) {
  double ax = 0, ay = 0;
  EXPECT_FALSE(division_axis(0, 0, 0, ax, ay));
  EXPECT_FALSE(division_axis(2, 0, 2 + 0.9e-9, ax, ay));
  EXPECT_FALSE(division_axis(0, 0.45e-9, 0, ax, ay));
  ASSERT_TRUE(division_axis(0, 0, 1.1e-9, ax, ay));
  EXPECT_NEAR(std::abs(ax), 1, 1e-12);
  ASSERT_TRUE(division_axis(0, 0.55e-9, 0, ax, ay));
  EXPECT_NEAR(ax * ay, -0.5, 1e-9);
}

TEST(Split, AxisIsAUnitVectorAlongTheLeastEigenvector) {
  Dice dice(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const double angle = dice.uniform(0, 6.2832), most = dice.uniform(0.01, 50),
                 least = dice.uniform(0, 0.99) * most;
    const double nx = std::cos(angle), ny = std::sin(angle);
    double ax = 0, ay = 0;
    ASSERT_TRUE(division_axis(most * nx * nx + least * ny * ny, (most - least) * nx * ny,
                              most * ny * ny + least * nx * nx, ax, ay));
    ASSERT_NEAR(ax * ax + ay * ay, 1, 1e-12);
    ASSERT_NEAR(ax * nx + ay * ny, 0, 1e-8) << "perpendicular to the most compressed axis";
  }
}

TEST(Split, NumbersDaughtersByAscendingMother) {
  CycleBench bench;
  bench.states.push_back({.name = "other", .parent = 0});
  bench.wish[3] = bench.wish[5] = bench.wish[4] = {{"division", 1}};
  bench.start_with({{.id = 5, .x = 0, .state = 0},
                    {.id = 4, .x = 10, .state = 1},
                    {.id = 3, .x = 20, .state = 1},
                    {.id = 8, .x = 30, .state = 0}});
  bench.steps(20);
  ASSERT_EQ(bench.count(), 7u);
  EXPECT_EQ(bench.cells().parent[bench.at(9)], 3u);
  EXPECT_EQ(bench.cells().parent[bench.at(10)], 4u);
  EXPECT_EQ(bench.cells().parent[bench.at(11)], 5u);
  EXPECT_EQ(bench.cells().state[bench.at(9)], 1);
  EXPECT_EQ(bench.cells().state[bench.at(11)], 0);
  EXPECT_NEAR(bench.cells().x[bench.at(9)], 20, 1) << "beside her mother";
}

TEST(Split, PassesOnConcentrationsAndDamage) {
  CycleBench bench;
  auto handles = std::make_shared<Handles>();
  bench.environments = {hazard("fire", handles, [](World&) {})};
  bench.memory_rows = 2;
  const auto follow = bench.script;
  bench.script = [=](const Lane& lane) {
    follow(lane);
    lane.memory(0) += 1;
  };
  bench.states[0].skills["resistance"] = 10;
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.cells().memory.row(1)[0] = 0.625f;
  bench.cells().damage[handles->hazard][0] = 2.5;
  bench.steps(20);
  for (const std::uint64_t id : {0u, 1u}) {
    EXPECT_EQ(bench.cells().memory.row(0)[bench.at(id)], 20.0f);
    EXPECT_EQ(bench.cells().memory.row(1)[bench.at(id)], 0.625f);
    EXPECT_EQ(bench.cells().damage[handles->hazard][bench.at(id)], 2.5);
  }
}

TEST(Split, TreatsCellValuesByTheirRule) {
  CycleBench bench;
  std::array<Id, 3> ids{};
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [&](Declare& d) {
    ids = {d.cell_value("copied", OnDivision::copy), d.cell_value("halved", OnDivision::halve),
           d.cell_value("dropped", OnDivision::zero)};
  };
  bench.environments = {{"toy", toy}};
  bench.wish[0] = {{"division", 1}};
  bench.start();
  for (const Id id : ids) {
    EXPECT_EQ(bench.cells().values[id][0], 0) << "a founder has none";
    bench.cells().values[id][0] = 8;
  }
  bench.steps(20);
  const std::uint32_t mother = bench.at(0), daughter = bench.at(1);
  EXPECT_EQ(bench.cells().values[ids[0]][mother], 8);
  EXPECT_EQ(bench.cells().values[ids[0]][daughter], 8);
  EXPECT_EQ(bench.cells().values[ids[1]][mother], 4);
  EXPECT_EQ(bench.cells().values[ids[1]][daughter], 4);
  EXPECT_EQ(bench.cells().values[ids[2]][mother], 8);
  EXPECT_EQ(bench.cells().values[ids[2]][daughter], 0);
}

TEST(Split, DaughterDepositsAndActsFromTheNextStepOnly) {
  CycleBench bench;
  bench.config.morphogens = {.size = 65, .side = 0.25, .kinds = {{1.0, 1.0}}};
  bench.config.metabolism.quiescence_cost = 0.03;
  bench.wish[0] = {{"division", 1}, {"morphogen.0", 1}};
  bench.wish[1] = {{"morphogen.0", 1}};
  bench.start();
  bench.steps(20);
  const auto field_at = [&](std::uint64_t id) {
    const CellStore& c = bench.cells();
    const auto square = [](double v) { return static_cast<std::uint32_t>(v / 0.25 + 32.5); };
    return bench.world().organisms[0].fields.value(0, square(c.x[bench.at(id)]),
                                                   square(c.y[bench.at(id)]));
  };
  EXPECT_NEAR(field_at(0), 1, 1e-6) << "the mother deposits where she now stands";
  EXPECT_EQ(field_at(1), 0);
  EXPECT_EQ(bench.action(1), Action::none);
  EXPECT_EQ(bench.cells().energy[bench.at(1)], 0.5);
  bench.steps(1);
  EXPECT_NEAR(field_at(1), 1, 1e-6);
  EXPECT_EQ(bench.action(1), Action::quiescence);
  EXPECT_NEAR(bench.cells().energy[bench.at(1)], 0.47, 1e-12);
}

TEST(Split, DaughterJoinsMechanicsAtOnce) {
  CycleBench bench;
  bench.config.mechanics.time_step = 1.0 / 30;
  bench.wish[0] = {{"division", 1}};
  bench.start();
  bench.steps(20);
  const CellStore& c = bench.cells();
  EXPECT_EQ(bench.world().contacts.of(bench.at(1)).size(), 1u);
  const double overlap = 2 - std::hypot(c.x[0] - c.x[1], c.y[0] - c.y[1]);
  EXPECT_NEAR(c.pressure[bench.at(1)], 10 * overlap / (10 * overlap + 10), 1e-12);
}

// ---- apoptosis ----------------------------------------------------------------------------------

TEST(Apoptosis, GivesItsAmbrosiaToItsContactsTimesEfficiency) {
  // 8 in two parts of 4, of which half arrives: 2 each; cell 1 has room for 1 of them.
  CycleBench bench;
  bench.states[0].skills = {{"capacity", 10}, {"diffusion", 0.5}};
  bench.wish[0] = {{"apoptosis", 1}};
  bench.start_with({{.id = 0, .ambrosia = 8},
                    {.id = 1, .x = 2, .ambrosia = 9},
                    {.id = 2, .x = -2},
                    {.id = 3, .x = -4}});
  bench.steps(4);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(2)], 0) << "not before the end";
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(1)], 10, 1e-12);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(2)], 2, 1e-12);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(3)], 0) << "no contact of the dying cell";
  EXPECT_NEAR(bench.ledger().lost_efficiency.value(), 4, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_overflow.value(), 1, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_death.value(), 0, 1e-12);
}

TEST(Apoptosis, WithoutContactsLosesEverything) {
  CycleBench bench;
  bench.wish[0] = {{"apoptosis", 1}};
  bench.start_with({{.id = 0, .ambrosia = 8}, {.id = 1, .x = 10, .ambrosia = 1}});
  bench.steps(5);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(1)], 1);
  EXPECT_NEAR(bench.ledger().lost_death.value(), 8, 1e-12);
}

TEST(Apoptosis, OfTwoNeighboursAtOnceLosesWhatTheyGiveEachOther) {
  // A chain 0 - 1 - 2: 0 gives 4 to 1; 1 gives 3 to 0 (lost) and 3 to 2.
  CycleBench bench;
  bench.wish[0] = bench.wish[1] = {{"apoptosis", 1}};
  bench.start_with(
      {{.id = 0, .x = -2, .ambrosia = 4}, {.id = 1, .ambrosia = 6}, {.id = 2, .x = 2}});
  bench.steps(5);
  ASSERT_EQ(bench.count(), 1u);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(2)], 3, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_death.value(), 7, 1e-12);
}

// ---- specialization -----------------------------------------------------------------------------

TEST(Specialization, KeepsTheOldAttributesUntilItEndsThenTakesTheChilds) {
  CycleBench bench;
  bench.config.mechanics = {.substeps = 1, .time_step = 0.01, .damping = 0, .drag = 0};
  bench.states = {{.name = "root",
                   .mass = 1,
                   .radius = 1,
                   .skills = {{"capacity", 100}, {"production", 3}, {"energy_efficiency", 1}}},
                  {.name = "child",
                   .parent = 0,
                   .mass = 4,
                   .radius = 0.5,
                   .skills = {{"capacity", 100}, {"production", 0.5}, {"energy_efficiency", 2}}}};
  bench.config.metabolism.specialization_cost = 0.01;
  bench.config.metabolism.quiescence_cost = 0.02;
  bench.environments = {resource_grid("food", 1000), acting("wind", Phase::forces, [](World& w) {
                          for (double& f : w.force_x()) f += 1;
                        })};
  bench.wish[0] = {{"specialize.child", 1}, {"uptake.food", 1}};
  bench.start_with({{.id = 0}});
  for (int step = 1; step <= 10; ++step) {
    bench.steps(1);
    const CellStore& c = bench.cells();
    EXPECT_NEAR(c.ambrosia[0], 3 * step, 1e-9);
    EXPECT_NEAR(c.energy[0], 1 - 0.01 * step, 1e-12);
    EXPECT_EQ(c.state[0], step < 10 ? 0 : 1);
    EXPECT_EQ(c.radius[0], step < 10 ? 1 : 0.5);
  }
  // Phase 6 of the tenth step lies before its mechanics: nine steps of mass 1, then mass 4.
  EXPECT_NEAR(bench.cells().vx[0], 0.01 * (9 + 0.25), 1e-12);
  bench.steps(1);
  EXPECT_NEAR(bench.cells().ambrosia[0], 30.5, 1e-9);
  EXPECT_NEAR(bench.cells().energy[0], 0.9 - 0.02 / 2, 1e-12);
  EXPECT_EQ(bench.world().organisms[0].outcome.specializations, 1u);
}

TEST(Specialization, LosesExcessAmbrosiaAndKeepsDamageAndConcentrations) {
  CycleBench bench;
  auto handles = std::make_shared<Handles>();
  bench.environments = {hazard("fire", handles, [](World&) {})};
  bench.memory_rows = 1;
  bench.states[0].skills = {{"capacity", 10}, {"resistance", 5}};
  bench.states.push_back(
      {.name = "child", .parent = 0, .skills = {{"capacity", 3}, {"resistance", 5}}});
  bench.wish[0] = {{"specialize.child", 1}};
  bench.wish[1] = {{"specialize.child", 1}};
  bench.start_with({{.id = 0, .ambrosia = 8}, {.id = 1, .x = 20, .ambrosia = 2}});
  bench.cells().memory.row(0)[bench.at(0)] = 0.75f;
  bench.cells().damage[handles->hazard][bench.at(0)] = 1.5;
  bench.steps(9);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(0)], 8);
  bench.steps(1);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(0)], 3);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(1)], 2);
  EXPECT_NEAR(bench.ledger().lost_overflow.value(), 5, 1e-12);
  EXPECT_EQ(bench.cells().memory.row(0)[bench.at(0)], 0.75f);
  EXPECT_EQ(bench.cells().damage[handles->hazard][bench.at(0)], 1.5);
}

TEST(Specialization, KillsACellThatAbsorbedMoreThanItsNewStateWithstands) {
  for (const double absorbed : {2.0, 2.5}) {
    CycleBench bench;
    auto handles = std::make_shared<Handles>();
    bench.environments = {hazard("fire", handles, [](World&) {})};
    bench.states[0].skills = {{"capacity", 10}, {"resistance", 5}};
    bench.states.push_back(
        {.name = "child", .parent = 0, .skills = {{"capacity", 10}, {"resistance", 2}}});
    bench.wish[0] = {{"specialize.child", 1}};
    bench.start_with({{.id = 0, .ambrosia = 8}});
    bench.cells().damage[handles->hazard][bench.at(0)] = absorbed;
    bench.steps(9);
    EXPECT_EQ(bench.cells().size(), 1u);
    bench.steps(1);
    EXPECT_EQ(bench.cells().size(), absorbed > 2 ? 0u : 1u) << absorbed;
  }
}

TEST(Specialization, SwitchesTheInputsToThoseOfTheNewState) {
  CycleBench bench;
  bench.states.push_back({.name = "child", .parent = 0, .skills = {{"capacity", 4}}});
  std::vector<std::pair<std::uint16_t, float>> seen;
  const auto follow = bench.script;
  bench.script = [&, follow](const Lane& lane) {
    follow(lane);
    seen.emplace_back(lane.state(), lane.in("ambrosia"));
  };
  bench.wish[0] = {{"specialize.child", 1}};
  bench.start_with({{.id = 0, .ambrosia = 3}});
  bench.steps(12);
  EXPECT_EQ(seen[9], std::pair(std::uint16_t{0}, 0.3f));
  EXPECT_EQ(seen[10], std::pair(std::uint16_t{1}, 0.75f));
}

}  // namespace
}  // namespace somas::model::test
