// Adhesion by pair of states (section 3 of the model): the springs, and what they lead to.
#include "core/model/springs.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

constexpr double mean = std::numeric_limits<double>::quiet_NaN();

/// Force along x on the second of two cells at rest, by their states.
double force_between(const std::vector<StateDef>& states, std::uint16_t a, std::uint16_t b,
                     double distance) {
  Bench bench;
  bench.free_living();
  bench.states = states;
  bench.config.mechanics.substeps = 1;
  bench.config.mechanics.time_step = 1e-6;
  bench.start_with({{.id = 0, .x = 0, .state = a}, {.id = 1, .x = distance, .state = b}});
  bench.steps(1);
  return bench.cells().vx[bench.at(1)] / 1e-6;
}

TEST(PairAdhesion, IsWhatTheLaterStateSaysAndElseTheMean) {
  const std::vector<StateDef> states = {
      {.name = "a", .adhesion = 2},
      {.name = "b", .parent = 0, .adhesion = 4, .adhesion_with = {0.5}},
      {.name = "c", .parent = 0, .adhesion = 6, .adhesion_with = {mean, 7}},
      {.name = "d", .parent = 0, .adhesion = 8, .adhesion_with = {0}}};
  // Rows and columns a, b, c, d.
  const double strength[4][4] = {{2, 0.5, 4, 0}, {0.5, 4, 7, 6}, {4, 7, 6, 7}, {0, 6, 7, 8}};
  for (std::uint16_t a = 0; a < 4; ++a)
    for (std::uint16_t b = 0; b < 4; ++b)
      EXPECT_NEAR(force_between(states, a, b, 2.2), -strength[a][b] * (2.2 - 1), 1e-5)
          << a << ' ' << b;
}

TEST(PairAdhesion, LeavesCollisionAndRangeAsTheyAre) {
  const std::vector<StateDef> states = {{.name = "a"},
                                        {.name = "b", .parent = 0, .adhesion_with = {1}}};
  EXPECT_NEAR(force_between(states, 0, 1, 1.5), 10 * 0.5 - 1 * (1.5 - 1), 1e-5);
  EXPECT_NEAR(force_between(states, 0, 1, 2.39), -1 * (2.39 - 1), 1e-5);
  EXPECT_EQ(force_between(states, 0, 1, 2.41), 0);
}

TEST(PairAdhesion, DoesNotJoinOrganisms) {
  Bench bench;
  bench.free_living();
  bench.states = {{.name = "a"}, {.name = "b", .parent = 0, .adhesion_with = {9}}};
  bench.config.mechanics.time_step = 0.02;
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.start_with({{.id = 0, .state = 0}, {.id = 0, .x = 2.2, .state = 1, .organism = 1}});
  bench.steps(3);
  EXPECT_EQ(bench.cells().x[bench.at(0, 1)], 2.2);
}

TEST(PairAdhesion, CountsForTheLimitOfTheTimeStep) {
  Bench bench;
  bench.config.mechanics.time_step = 0.04;
  bench.states = {{.name = "a"}, {.name = "b", .parent = 0, .adhesion_with = {13}}};
  EXPECT_THROW(bench.wire(), UnstableTimeStep);
  bench.states[1].adhesion_with = {0};
  EXPECT_NO_THROW(bench.wire());
}

// ---- sorting ------------------------------------------------------------------------------------

/// A disc-shaped aggregate of two states in random order, shaken by forces of a strength.
class Aggregate {
 public:
  Aggregate(double between, std::uint64_t seed, double shaking = 10, std::uint32_t count = 90) {
    bench_.free_living();
    bench_.config.max_steps = 1000000;
    bench_.states = {{.name = "root"},
                     {.name = "a", .parent = 0},
                     {.name = "b", .parent = 0, .adhesion_with = {mean, between}}};
    bench_.environments = {acting("shaking", Phase::forces, [=](World& world) {
      for (std::uint32_t i = 0; i < world.cells().count; ++i) {
        const std::uint64_t id = world.cells().id[i], step = seed * 1000000 + world.step();
        world.force_x()[i] += shaking * (2.0 * static_cast<double>(noise(id, step, 0)) - 1);
        world.force_y()[i] += shaking * (2.0 * static_cast<double>(noise(id, step, 1)) - 1);
      }
    })};
    bench_.start_with(mixed(count, seed));
  }

  void steps(int count) { bench_.steps(count); }

  /// Contacts of a with b, over all contacts.
  [[nodiscard]] double mixing() {
    const CellStore& cells = bench_.cells();
    const Contacts& contacts = bench_.world().contacts;
    std::size_t all = 0, unlike = 0;
    for (std::uint32_t i = 0; i < cells.size(); ++i)
      for (const std::uint32_t j : contacts.of(i)) {
        ++all;
        if (cells.state[i] != cells.state[j]) ++unlike;
      }
    return static_cast<double>(unlike) / static_cast<double>(all);
  }
  /// Greatest distance of a cell from the origin.
  [[nodiscard]] double extent() {
    double most = 0;
    const CellStore& cells = bench_.cells();
    for (std::uint32_t i = 0; i < cells.size(); ++i)
      most = std::max(most, std::hypot(cells.x[i], cells.y[i]));
    return most;
  }

 private:
  /// The points of a hexagonal lattice within a disc, half of them a and half b.
  static std::vector<Placed> mixed(std::uint32_t count, std::uint64_t seed) {
    std::vector<std::pair<double, double>> points;
    const double spacing = 23.0 / 13;
    for (int row = -12; row <= 12; ++row)
      for (int column = -12; column <= 12; ++column)
        points.emplace_back(spacing * (column + 0.5 * (row & 1)),
                            spacing * row * std::numbers::sqrt3 / 2);
    std::stable_sort(points.begin(), points.end(), [](const auto& p, const auto& q) {
      return std::hypot(p.first, p.second) < std::hypot(q.first, q.second);
    });
    std::vector<std::uint16_t> states;
    for (std::uint32_t i = 0; i < count; ++i)
      states.push_back(static_cast<std::uint16_t>(1 + i % 2));
    Dice dice(seed);
    dice.shuffle(states);
    std::vector<Placed> cells;
    for (std::uint32_t i = 0; i < count; ++i)
      cells.push_back({.id = i, .x = points[i].first, .y = points[i].second, .state = states[i]});
    return cells;
  }

  Bench bench_;
};

// Steinberg's differential adhesion hypothesis: where unlike cells adhere less than like ones, a
// shaken mixture sorts into one body of each kind; where all adhere alike it stays mixed.
TEST(Sorting, HeterotypicBoundaryFallsWhereUnlikeCellsAdhereLess) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Aggregate sorting(2, seed), equal(3, seed);
    sorting.steps(1);
    equal.steps(1);
    const double start = sorting.mixing();
    EXPECT_GT(start, 0.45);
    EXPECT_EQ(equal.mixing(), start);
    sorting.steps(2500);
    equal.steps(2500);
    const double halfway = sorting.mixing();
    EXPECT_LT(halfway, 0.8 * start) << seed;
    sorting.steps(4500);
    equal.steps(4500);
    EXPECT_LT(sorting.mixing(), halfway) << seed;
    EXPECT_LT(sorting.mixing(), 0.6 * start) << seed;
    EXPECT_GT(equal.mixing(), 0.85 * start) << seed;
    EXPECT_LT(sorting.extent(), 20) << "one body, from a disc of radius 9";
  }
}

}  // namespace
}  // namespace somas::model::test
