// Hazards, causes of death, what the dying still do, survival, and first hits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/model/hits.hpp"
#include "core/model/team.hpp"
#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Living is free; `fire` is a hazard whose strikes a test scripts by id.
class HazardBench : public Bench {
 public:
  std::shared_ptr<Handles> fire = std::make_shared<Handles>();
  std::function<void(World&)> strikes;

  HazardBench() {
    free_living();
    states[0].skills = {{"capacity", 10}};
    environments = {hazard("fire", fire, [this](World& w) {
      if (strikes) strikes(w);
    })};
  }
  /// Strikes every cell once a step.
  void strike_all(double energy) {
    strikes = [this, energy](World& w) {
      for (std::uint32_t i = 0; i < w.cells().count; ++i) w.strike(i, fire->hazard, energy);
    };
  }
};

std::uint32_t index_of(const World& world, std::uint64_t id) {
  for (std::uint32_t i = 0; i < world.cells().count; ++i)
    if (world.cells().id[i] == id) return i;
  throw std::logic_error("no such cell");
}

// ---- strikes ------------------------------------------------------------------------------------

TEST(Strike, KillsWhenTheAbsorbedEnergyExceedsTheResistance) {
  HazardBench bench;
  bench.states[0].skills["resistance"] = 10;
  bench.strike_all(1);
  bench.start();
  bench.steps(10);
  EXPECT_TRUE(bench.alive(0)) << "10 does not exceed 10";
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0)) << "the eleventh hit";
  EXPECT_EQ(bench.deaths("fire"), 1u);
}

TEST(Strike, KillsAtOnceWithoutResistance) {
  HazardBench bench;
  bench.strike_all(1e-6);
  bench.start();
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
}

TEST(Strike, OfNoEnergyKillsNobody) {
  HazardBench bench;
  bench.strike_all(0);
  bench.start();
  bench.steps(1);
  EXPECT_TRUE(bench.alive(0));
}

TEST(Strike, AccumulatesPerHazardAndByTheCellsOwnState) {
  HazardBench bench;
  auto ice = std::make_shared<Handles>();
  bench.states[0].skills["resistance"] = 2;
  bench.states.push_back({.name = "tough", .parent = 0, .skills = {{"resistance", 5}}});
  bench.environments.push_back(hazard("ice", ice, [&](World& w) {
    for (std::uint32_t i = 0; i < w.cells().count; ++i) w.strike(i, ice->hazard, 0.9);
  }));
  bench.strike_all(0.9);
  bench.start_with({{.id = 0, .x = 0, .state = 0}, {.id = 1, .x = 10, .state = 1}});
  bench.steps(2);
  EXPECT_TRUE(bench.alive(0)) << "1.8 of each, 3.6 together: hazards do not add up";
  EXPECT_NEAR(bench.cells().damage[bench.fire->hazard][bench.at(0)], 1.8, 1e-12);
  EXPECT_NEAR(bench.cells().damage[ice->hazard][bench.at(0)], 1.8, 1e-12);
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
  EXPECT_TRUE(bench.alive(1));
  bench.steps(2);
  EXPECT_TRUE(bench.alive(1)) << "4.5 of 5";
  bench.steps(1);
  EXPECT_FALSE(bench.alive(1));
}

TEST(Kill, RemovesACellUnderTheGivenCause) {
  HazardBench bench;
  bench.strikes = [&](World& w) { w.kill(index_of(w, 1), bench.fire->cause); };
  bench.start_with({{.id = 0}, {.id = 1, .x = 10, .ambrosia = 4}});
  bench.steps(1);
  EXPECT_TRUE(bench.alive(0));
  EXPECT_FALSE(bench.alive(1));
  EXPECT_EQ(bench.deaths("fire_kill"), 1u);
  EXPECT_NEAR(bench.ledger().lost_death.value(), 4, 1e-12);
  EXPECT_NEAR(bench.ledger().energy_lost.value(), 1, 1e-12);
}

// ---- causes -------------------------------------------------------------------------------------

TEST(Cause, FirstOneCounts) {
  // Starvation (phase 5) before the strike (phase 9), the strike before the kill, and all of them
  // before leaving the world (phase 10).
  HazardBench bench;
  bench.config.metabolism.quiescence_cost = 0.03;
  bench.strikes = [&](World& w) {
    for (std::uint32_t i = 0; i < w.cells().count; ++i) {
      if (w.cells().id[i] == 3) continue;
      w.strike(i, bench.fire->hazard, 1);
      w.kill(i, bench.fire->cause);
    }
  };
  bench.start_with({{.id = 0, .x = 70, .energy = 0.01}, {.id = 1, .x = 80}, {.id = 3, .x = 90}});
  bench.steps(1);
  EXPECT_EQ(bench.deaths("starvation"), 1u);
  EXPECT_EQ(bench.deaths("fire"), 1u);
  EXPECT_EQ(bench.deaths("fire_kill"), 0u);
  EXPECT_EQ(bench.deaths("outside"), 1u);
}

TEST(Cause, OutsideIsBeyondTheRadiusOfTheWorld) {
  HazardBench bench;
  bench.start_with({{.id = 0, .x = 60, .ambrosia = 1},
                    {.id = 1, .x = -42.5, .y = 42.5, .energy = 0.5, .ambrosia = 2},
                    {.id = 2, .y = -60.001, .ambrosia = 4}});
  bench.steps(1);
  EXPECT_TRUE(bench.alive(0));
  EXPECT_FALSE(bench.alive(1)) << "distance 60.1";
  EXPECT_FALSE(bench.alive(2));
  EXPECT_EQ(bench.deaths("outside"), 2u);
  EXPECT_NEAR(bench.ledger().lost_outside.value(), 6, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_death.value(), 0, 1e-12);
  EXPECT_NEAR(bench.ledger().energy_lost.value(), 1.5, 1e-12);
}

TEST(Cause, OutsideCatchesACellOfNoFinitePlace) {
  HazardBench bench;
  bench.start_with({{.id = 0},
                    {.id = 1, .x = std::numeric_limits<double>::quiet_NaN()},
                    {.id = 2, .x = 23.0 / 13}});
  bench.steps(1);
  EXPECT_NEAR(bench.cells().x[bench.at(0)], 0, 1e-9) << "nobody else catches it";
  EXPECT_NEAR(bench.cells().x[bench.at(2)], 23.0 / 13, 1e-9);
  EXPECT_FALSE(bench.alive(1));
  EXPECT_EQ(bench.deaths("outside"), 1u);
}

// ---- the dying ----------------------------------------------------------------------------------

TEST(Dying, CellsKilledInTheStepStillAbsorb) {
  HazardBench bench;
  std::vector<std::int32_t> met;
  std::vector<std::uint8_t> dead;
  bench.strikes = [&](World& w) {
    // Two particles in single file: the second is spent on the cell that the first killed.
    const std::array<Segment, 2> paths{Segment{-9, 0, 9, 0}, Segment{-9, 0, 9, 0}};
    for (const Segment& path : paths) {
      std::array<std::int32_t, 1> hit{};
      w.first_hit(std::span(&path, 1), hit);
      met.push_back(static_cast<std::int32_t>(w.cells().id[static_cast<std::size_t>(hit[0])]));
      w.strike(static_cast<std::uint32_t>(hit[0]), bench.fire->hazard, 1);
      dead.push_back(w.cells().dead[static_cast<std::size_t>(hit[0])]);
    }
  };
  bench.start_with({{.id = 4, .x = -3}, {.id = 5, .x = 3}});
  bench.steps(1);
  EXPECT_EQ(met, (std::vector<std::int32_t>{4, 4}));
  EXPECT_EQ(dead, (std::vector<std::uint8_t>{1, 1}));
  EXPECT_TRUE(bench.alive(5));
  EXPECT_EQ(bench.deaths("fire"), 1u);
}

TEST(Dying, StarvedCellsAbsorbToo) {
  HazardBench bench;
  bench.config.metabolism.quiescence_cost = 0.03;
  std::optional<std::uint64_t> met;
  bench.strikes = [&](World& w) {
    const Segment path{-9, 0, 9, 0};
    std::array<std::int32_t, 1> hit{};
    w.first_hit(std::span(&path, 1), hit);
    met = w.cells().id[static_cast<std::size_t>(hit[0])];
  };
  bench.start_with({{.id = 0, .x = -3, .energy = 0.02}, {.id = 1, .x = 3}});
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
  EXPECT_EQ(met, 0u);
}

TEST(Dying, StarvedCellsStillCollide) {
  HazardBench bench;
  bench.config.metabolism.quiescence_cost = 0.03;
  bench.states[0].adhesion = 0;
  bench.start_with({{.id = 0, .x = 0, .energy = 0.02}, {.id = 1, .x = 1.5}});
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
  EXPECT_GT(bench.cells().vx[bench.at(1)], 0.1);
  EXPECT_GT(bench.cells().pressure[bench.at(1)], 0.1);
  EXPECT_TRUE(bench.world().contacts.of(bench.at(1)).empty()) << "but are gone afterwards";
}

TEST(Dying, StarvedCellsReceiveWhatIsThenLost) {
  HazardBench bench;
  bench.forceless();
  bench.script = [](const Lane& lane) {
    if (lane.id == 0) lane.out("apoptosis", 1);
  };
  bench.start_with({{.id = 0, .ambrosia = 6}, {.id = 1, .x = 2}, {.id = 2, .x = -2}});
  bench.steps(4);
  bench.world().cells.energy[bench.at(1)] = 1e-10;
  bench.steps(1);
  ASSERT_EQ(bench.cells().size(), 1u);
  EXPECT_EQ(bench.deaths("starvation"), 1u);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(2)], 3, 1e-12) << "its share is not redistributed";
  EXPECT_NEAR(bench.ledger().lost_death.value(), 3, 1e-12);
}

TEST(Dying, StarvedCellsNeitherAdvanceNorDeposit) {
  HazardBench bench;
  bench.states.push_back({.name = "leaf", .parent = 0});
  bench.script = [](const Lane& lane) {
    lane.out("morphogen.0", 1);
    lane.out(lane.id == 0 ? "division" : "specialize.leaf", 1);
  };
  bench.config.cycle.division_steps = bench.config.cycle.specialization_steps = 3;
  bench.config.morphogens.kinds = {{1.0, 1.0}};
  bench.start_with({{.id = 0, .x = 0}, {.id = 1, .x = 20}, {.id = 2, .x = 40}});
  bench.steps(2);
  EXPECT_EQ(bench.world().organisms[0].fields.value(0, 32, 32), 1);
  bench.cells().energy[bench.at(0)] = 0;
  bench.cells().energy[bench.at(1)] = 0;
  bench.steps(1);
  EXPECT_EQ(bench.deaths("starvation"), 2u);
  EXPECT_EQ(bench.world().organisms[0].outcome.divisions, 0u);
  EXPECT_EQ(bench.world().organisms[0].outcome.specializations, 1u) << "of cell 2";
  EXPECT_EQ(bench.world().organisms[0].fields.value(0, 32, 32), 0);
  EXPECT_EQ(bench.world().organisms[0].fields.value(0, 52, 32), 1) << "cell 2 does";
}

TEST(Dying, DoNotBlockTheOthersContacts) {
  // A chain 0 - 1 - 2 - 3 of which 1 dies: the others keep theirs under new indices.
  HazardBench bench;
  bench.forceless();
  bench.strikes = [&](World& w) {
    if (w.step() == 1) w.kill(index_of(w, 1), bench.fire->cause);
  };
  bench.script = [](const Lane& lane) {
    if (lane.step == 2) lane.out("diffusion", lane.id == 2 ? 1.0f : 0.0f);
  };
  bench.start_with(
      {{.id = 0, .x = 0}, {.id = 1, .x = 2}, {.id = 2, .x = 4, .ambrosia = 8}, {.id = 3, .x = 6}});
  bench.steps(3);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(3)], 8, 1e-12) << "the only contact left";
  EXPECT_EQ(bench.cells().ambrosia[bench.at(0)], 0);
}

// ---- survival -----------------------------------------------------------------------------------

TEST(Survival, IsTheStepOfTheLastDeath) {
  HazardBench bench;
  bench.strikes = [&](World& w) {
    if (w.step() == 3) w.kill(index_of(w, 0), bench.fire->cause);
    if (w.step() == 7) w.kill(index_of(w, 1), bench.fire->cause);
  };
  bench.start_with({{.id = 0}, {.id = 1, .x = 10}});
  EXPECT_TRUE(bench.simulation().run());
  const Outcome outcome = bench.simulation().outcomes()[0];
  EXPECT_EQ(outcome.survival, 7u);
  EXPECT_FALSE(outcome.censored);
  EXPECT_EQ(outcome.final_cells, 0u);
  EXPECT_EQ(outcome.cell_steps, 3 * 2 + 4 * 1);
  EXPECT_EQ(bench.simulation().steps_done(), 8u);
  EXPECT_FALSE(bench.simulation().step()) << "over is over";
  EXPECT_EQ(bench.simulation().steps_done(), 8u);
}

TEST(Survival, OfEachOrganismIsItsOwn) {
  HazardBench bench;
  bench.founders = {{.key = 8, .x = 0}, {.key = 3, .x = 30}};
  bench.strikes = [&](World& w) {
    for (std::uint32_t i = 0; i < w.cells().count; ++i)
      if (w.step() == (w.cells().x[i] < 10 ? 2u : 5u)) w.kill(i, bench.fire->cause);
  };
  bench.start();
  bench.simulation().run();
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 2u);
  EXPECT_EQ(bench.simulation().outcomes()[1].survival, 5u);
}

TEST(Survival, IsCensoredAtTheLastStep) {
  HazardBench bench;
  bench.config.max_steps = 12;
  bench.start_with({{.id = 0}, {.id = 1, .x = 10}});
  bench.simulation().run();
  const Outcome outcome = bench.simulation().outcomes()[0];
  EXPECT_EQ(bench.simulation().steps_done(), 12u);
  EXPECT_TRUE(outcome.censored);
  EXPECT_EQ(outcome.survival, 12u);
  EXPECT_EQ(outcome.final_cells, 2u);
  EXPECT_EQ(outcome.peak_cells, 2u);
}

TEST(Survival, IsCensoredWhereTheFitnessStops) {
  HazardBench bench;
  bench.observe = [](World& w) { return w.step() == 4; };
  bench.start();
  bench.simulation().run();
  EXPECT_EQ(bench.simulation().steps_done(), 5u);
  EXPECT_TRUE(bench.simulation().outcomes()[0].censored);
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 5u);
}

TEST(Survival, LastDeathAtTheLastStepIsNotCensored) {
  HazardBench bench;
  bench.config.max_steps = 5;
  bench.strikes = [&](World& w) {
    if (w.step() == 4) w.kill(0, bench.fire->cause);
  };
  bench.start();
  bench.simulation().run();
  EXPECT_FALSE(bench.simulation().outcomes()[0].censored);
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 4u);
}

// ---- first hits ---------------------------------------------------------------------------------

/// Where along the segment its nearest entry into the disc lies, by projection; nothing if it
/// misses.
std::optional<double> entry(const Segment& s, double cx, double cy, double radius) {
  const long double dx = s.x1 - s.x0, dy = s.y1 - s.y0, length = std::sqrt(dx * dx + dy * dy);
  const long double px = cx - s.x0, py = cy - s.y0;
  if (px * px + py * py <= static_cast<long double>(radius) * radius) return 0;
  if (length == 0) return {};
  const long double along = (px * dx + py * dy) / length, aside = (px * dy - py * dx) / length;
  const long double half_chord_square = static_cast<long double>(radius) * radius - aside * aside;
  if (half_chord_square < 0) return {};
  const long double at = along - std::sqrt(half_chord_square);
  if (at < 0 || at > length) return {};
  return static_cast<double>(at / length);
}

/// Answers of World::first_hit as ids, no cell as -1; cells at rest where placed.
std::vector<std::int64_t> hits(const std::vector<Placed>& cells, const std::vector<double>& radii,
                               const std::vector<Segment>& segments) {
  HazardBench bench;
  bench.config.radius = 1e9;
  bench.forceless();
  std::vector<std::int64_t> answer;
  bench.strikes = [&](World& w) {
    std::vector<std::int32_t> met(segments.size());
    w.first_hit(segments, met);
    for (const std::int32_t i : met)
      answer.push_back(
          i < 0 ? -1 : static_cast<std::int64_t>(w.cells().id[static_cast<std::size_t>(i)]));
  };
  bench.states.push_back({.name = "other", .parent = 0});
  bench.forceless();
  bench.start_with(cells);
  for (std::size_t i = 0; i < radii.size(); ++i)
    bench.cells().radius[bench.at(cells[i].id)] = radii[i];
  bench.steps(1);
  return answer;
}

TEST(FirstHit, EqualsBruteForceOnRandomSegments) {
  Dice dice(1);
  for (int trial = 0; trial < 60; ++trial) {
    const double extent = dice.uniform(3, 60);
    std::vector<Placed> cells;
    std::vector<double> radii;
    const std::size_t count = 1 + dice.below(80);
    for (std::uint64_t id = 0; id < count; ++id) {
      cells.push_back({.id = id,
                       .x = dice.uniform(-extent, extent),
                       .y = dice.uniform(-extent, extent),
                       .state = static_cast<std::uint16_t>(dice.below(2))});
      radii.push_back(dice.uniform(0.3, 1.6));
    }
    std::vector<Segment> segments;
    for (int i = 0; i < 200; ++i) {
      Segment s{dice.uniform(-80, 80), dice.uniform(-80, 80), 0, 0};
      const double reach = i % 2 == 0 ? 0.5 : 100;  // slow and fast particles
      s.x1 = s.x0 + dice.uniform(-reach, reach);
      s.y1 = i % 7 == 0 ? s.y0 : s.y0 + dice.uniform(-reach, reach);
      segments.push_back(s);
    }
    const std::vector<std::int64_t> met = hits(cells, radii, segments);
    ASSERT_EQ(met.size(), segments.size());
    for (std::size_t k = 0; k < segments.size(); ++k) {
      std::int64_t expected = -1;
      double nearest = 2;
      for (std::size_t i = 0; i < count; ++i) {
        const auto at = entry(segments[k], cells[i].x, cells[i].y, radii[i]);
        if (at && *at < nearest) nearest = *at, expected = static_cast<std::int64_t>(i);
      }
      ASSERT_EQ(met[k], expected) << "trial " << trial << " segment " << k;
    }
  }
}

TEST(FirstHit, TiesGoToTheLowestId) {
  // Mirror images above and below the path; id 9 precedes id 2 in storage by its state.
  EXPECT_EQ(
      hits({{.id = 9, .x = 3, .y = 0.5, .state = 0}, {.id = 2, .x = 3, .y = -0.5, .state = 1}},
           {1, 1}, {{-9, 0, 9, 0}})[0],
      2);
  EXPECT_EQ(
      hits({{.id = 2, .x = 3, .y = 0.5, .state = 0}, {.id = 9, .x = 3, .y = -0.5, .state = 1}},
           {1, 1}, {{-9, 0, 9, 0}})[0],
      2);
  // A start inside several discs is a tie as well.
  EXPECT_EQ(hits({{.id = 9, .state = 0},
                  {.id = 7, .x = 0.3, .state = 1},
                  {.id = 8, .x = -0.2, .state = 1}},
                 {1, 1, 1}, {{0, 0, 5, 0}})[0],
            7);
}

TEST(FirstHit, StartInsideADiscMeetsItAtOnce) {
  const std::vector<Placed> cells{{.id = 1, .x = 0}, {.id = 2, .x = 3}};
  EXPECT_EQ(hits(cells, {1, 1}, {{0.5, 0, 3, 0}})[0], 1);
  EXPECT_EQ(hits(cells, {1, 1}, {{0.9, 0, 5, 0}})[0], 1) << "even when it is leaving";
  EXPECT_EQ(hits(cells, {1, 1}, {{0.5, 0, 0.5, 0}})[0], 1) << "even when it does not move";
  EXPECT_EQ(hits(cells, {1, 1}, {{1.5, 0, 1.5, 0}})[0], -1);
}

TEST(FirstHit, FastParticlesDoNotTunnel) {
  EXPECT_EQ(hits({{.id = 1, .x = 0}}, {0.01}, {{-1000, 0, 1000, 0}})[0], 1);
  EXPECT_EQ(hits({{.id = 1, .x = 0}, {.id = 2, .x = -500}}, {0.01, 0.01}, {{-1000, 0, 1000, 0}})[0],
            2);
}

TEST(FirstHit, MissesWhatLiesBehindAheadOrBeside) {
  const std::vector<Placed> cells{{.id = 1, .x = 0}};
  const std::vector<Segment> paths{{1.1, 0, 5, 0}, {-5, 0, -1.1, 0}, {-5, 1.001, 5, 1.001}};
  EXPECT_EQ(hits(cells, {1}, paths), (std::vector<std::int64_t>{-1, -1, -1}));
  EXPECT_EQ(hits(cells, {1}, {{-5, 0, -0.999, 0}})[0], 1);
  EXPECT_EQ(hits(cells, {1}, {{-5, 0.999, 5, 0.999}})[0], 1);
}

TEST(FirstHit, SeesCellsWhereMechanicsLeftThem) {
  HazardBench bench;
  std::vector<std::int32_t> met;
  bench.config.mechanics.drag = 0;
  bench.strikes = [&](World& w) {
    const Segment path{1.2, -5, 1.2, 5};
    std::array<std::int32_t, 1> hit{};
    w.first_hit(std::span(&path, 1), hit);
    met.push_back(hit[0]);
  };
  bench.start_with({{.id = 0, .x = 0, .vx = 5}});
  bench.steps(2);  // moves 0.5 a step
  EXPECT_EQ(met, (std::vector<std::int32_t>{0, 0}));
  bench.steps(5);
  EXPECT_EQ(met[5], -1) << "gone by";
}

/// Places of bodies, cells in storage and canonical order are three different things.
struct Names {
  std::vector<std::uint32_t> cells;  ///< by place
  std::vector<std::uint32_t> rank;   ///< by cell

  Names(std::size_t count, Dice& dice) : cells(count), rank(count) {
    std::iota(cells.begin(), cells.end(), 0u);
    std::iota(rank.begin(), rank.end(), 0u);
    dice.shuffle(cells);
    dice.shuffle(rank);
  }
};

/// The cell that is met first, the lowest in canonical order of equals; -1: none.
std::int32_t first_of_all(const Segment& path, const std::vector<Body>& bodies,
                          const Names& names) {
  std::int32_t first = -1;
  double nearest = 2;
  for (std::size_t place = 0; place < bodies.size(); ++place) {
    const double t = meeting(path, bodies[place].x, bodies[place].y, bodies[place].radius);
    const std::uint32_t cell = names.cells[place];
    if (t < 0 || t > nearest) continue;
    if (t == nearest && names.rank[cell] > names.rank[static_cast<std::size_t>(first)]) continue;
    nearest = t;
    first = static_cast<std::int32_t>(cell);
  }
  return first;
}

// Discs and paths lie on the borders of bins, of thirds of them, and just beside; bodies have
// drifted as far as they may. Whether it is known that many paths come changes nothing.
TEST(FirstHit, EqualsBruteForceAtTheBordersOfBins) {
  Dice dice(2);
  Team team(2, 1);
  std::size_t met = 0;
  for (int trial = 0; trial < 200; ++trial) {
    constexpr double range = 1.2, margin = 0.1, third = (1 + 1e-9) * (range + margin) * 2 / 3;
    const int extent = 1 + static_cast<int>(dice.below(30));
    const auto border = [&] {
      const int thirds = static_cast<int>(dice.below(2u * extent + 9)) - extent - 4;
      const std::array<double, 4> aside{0, 1e-12, -1e-12, dice.uniform(-1, 1)};
      return thirds * third + aside[dice.below(4)];
    };
    std::vector<Disc> discs{{-extent * third, -extent * third, 1, margin}};
    for (std::size_t n = dice.below(60); n > 0; --n) {
      const double x = std::clamp(border(), -extent * third, extent * third);
      const double y = std::clamp(border(), -extent * third, extent * third);
      discs.push_back({x, y, dice.below(2) == 0 ? 1 : dice.uniform(0.3, 1), margin});
    }
    std::vector<Body> bodies(discs.size());
    for (std::size_t i = 0; i < discs.size(); ++i) {
      const double angle = dice.uniform(-4, 4), drift = 0.2 * discs[i].radius + margin;
      bodies[i].x = discs[i].x + drift * std::cos(angle);
      bodies[i].y = discs[i].y + drift * std::sin(angle);
      bodies[i].radius = discs[i].radius;
    }
    std::vector<Segment> paths(1 + dice.below(700));
    for (Segment& path : paths) {
      const double angle = dice.uniform(-4, 4);
      const double length = dice.below(8) == 0 ? dice.uniform(0, 30) : dice.uniform(0, 0.9);
      path = {border(), border(), 0, 0};
      path.x1 = path.x0 + length * std::cos(angle);
      path.y1 = path.y0 + length * std::sin(angle);
    }
    DiscBins bins;
    bins.sort(discs, range);
    const Names names(bodies.size(), dice);
    HitFinder finder;
    finder.prepare(bodies, bins, names.cells, names.rank);
    std::vector<std::int32_t> few(paths.size(), 7), many(paths.size(), 7);
    finder.first(paths, few);
    finder.expect(1'000'000, trial % 2 == 0 ? nullptr : &team);
    finder.first(paths, many);
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const std::int32_t expected = first_of_all(paths[k], bodies, names);
      met += expected >= 0 ? 1 : 0;
      ASSERT_EQ(few[k], expected) << "trial " << trial << " path " << k;
      ASSERT_EQ(many[k], expected) << "trial " << trial << " path " << k;
      ASSERT_EQ(finder.first(paths[k]), expected) << "trial " << trial << " path " << k;
    }
  }
  EXPECT_GT(met, 1'000u);
}

TEST(FirstHitDeathTest, SurvivesACellOfNoFinitePlace) {
  // A plugin's force that is not a number must not take the host down with it.
  const auto hit_with_cell_at = [](double place) {
    std::array<Body, 3> bodies{};
    bodies[1].x = place;
    bodies[2].x = 4;
    for (Body& body : bodies) body.radius = 1;
    const std::array<Disc, 3> discs{{{0, 0, 1, 0.1}, {place, 0, 1, 0.1}, {4, 0, 1, 0.1}}};
    DiscBins bins;
    bins.sort(discs, 1.2);
    const std::array<std::uint32_t, 3> cells{0, 1, 2};
    HitFinder finder;
    finder.prepare(bodies, bins, cells, cells);
    return finder.first({-9, 0, 9, 0});
  };
  for (const double place :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_EXIT(std::_Exit(hit_with_cell_at(place) == 0 ? 0 : 1), ::testing::ExitedWithCode(0), "")
        << place;
}

}  // namespace
}  // namespace somas::model::test
