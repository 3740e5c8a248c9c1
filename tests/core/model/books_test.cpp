// The books of section 2, balanced from snapshots of the state around every step.
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// What lies where, counted from the state; and what the ledgers said by then.
struct Snapshot {
  double nutrients = 0, regrown = 0;
  std::vector<double> ambrosia, energy;  ///< by organism
  std::vector<Ledger> ledgers;
};

Snapshot snapshot(Bench& bench, const Busy& busy) {
  Snapshot s;
  const WorldState& world = bench.world();
  const std::vector<double>& grid = world.grids[busy.food->grid];
  s.nutrients = std::accumulate(grid.begin(), grid.end(), 0.0);
  s.regrown = *busy.regrown;
  s.ambrosia.assign(world.organisms.size(), 0);
  s.energy.assign(world.organisms.size(), 0);
  for (std::uint32_t i = 0; i < world.cells.size(); ++i) {
    s.ambrosia[world.cells.organism[i]] += world.cells.ambrosia[i];
    s.energy[world.cells.organism[i]] += world.cells.energy[i];
  }
  for (const OrganismState& organism : world.organisms) s.ledgers.push_back(organism.ledger);
  return s;
}

double change(const Sum& before, const Sum& after) { return after.value() - before.value(); }

TEST(Books, BalanceInEveryStepOfABusyWorld) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Bench bench;
    const Busy busy;
    busy.set_up(bench);
    bench.seed = seed;
    bench.founders = {{.key = 5, .x = -3}, {.key = 2, .x = 3}};

    // Ambrosia and energy that go with the dead, seen at the very end of the stress phase.
    std::array<double, 2> going{}, going_outside{}, going_energy{};
    bench.environments.push_back(acting("witness", Phase::stress, [&](World& w) {
      going = going_outside = going_energy = {};
      const Cells& c = w.cells();
      for (std::uint32_t i = 0; i < c.count; ++i) {
        const bool outside = std::hypot(c.x[i], c.y[i]) > Busy::radius;
        if (c.dead[i] == 0 && !outside) continue;
        (c.dead[i] != 0 ? going : going_outside)[c.organism[i]] += c.ambrosia[i];
        going_energy[c.organism[i]] += c.energy[i];
      }
    }));
    bench.start();

    Snapshot before = snapshot(bench, busy);
    for (int step = 0; step < 400 && !bench.simulation().finished(); ++step) {
      bench.steps(1);
      const Snapshot after = snapshot(bench, busy);
      double all_taken = 0;
      for (std::size_t k = 0; k < 2; ++k) {
        const Ledger &a = before.ledgers[k], &b = after.ledgers[k];
        all_taken += change(a.taken, b.taken);
        const double lost = change(a.lost_efficiency, b.lost_efficiency) +
                            change(a.lost_overflow, b.lost_overflow) +
                            change(a.lost_death, b.lost_death) +
                            change(a.lost_outside, b.lost_outside);
        ASSERT_NEAR(after.ambrosia[k] - before.ambrosia[k],
                    change(a.taken, b.taken) - change(a.burnt, b.burnt) - lost, 1e-9)
            << "step " << step;
        ASSERT_NEAR(after.energy[k] - before.energy[k],
                    change(a.burnt, b.burnt) - change(a.spent, b.spent) -
                        change(a.energy_lost, b.energy_lost),
                    1e-9);
        ASSERT_NEAR(change(a.lost_death, b.lost_death), going[k], 1e-9);
        ASSERT_NEAR(change(a.lost_outside, b.lost_outside), going_outside[k], 1e-9);
        ASSERT_NEAR(change(a.energy_lost, b.energy_lost), going_energy[k], 1e-9);
        ASSERT_GE(change(a.lost_efficiency, b.lost_efficiency), -1e-12);
        ASSERT_GE(change(a.lost_overflow, b.lost_overflow), -1e-12);
      }
      // Sums of 4,096 squares: rounding of about 1e-9.
      ASSERT_NEAR(after.nutrients - before.nutrients, after.regrown - before.regrown - all_taken,
                  1e-8)
          << "step " << step;
      before = after;
    }

    // Over the whole run, and every channel did something.
    double divisions = 0;
    std::array<double, 4> losses{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Ledger& l = before.ledgers[k];
      EXPECT_NEAR(l.founder_ambrosia + l.taken.value(),
                  before.ambrosia[k] + l.burnt.value() + l.lost(), 1e-9);
      EXPECT_NEAR(l.founder_energy + l.burnt.value(),
                  before.energy[k] + l.spent.value() + l.energy_lost.value(), 1e-9);
      EXPECT_NEAR(l.lost(),
                  l.lost_efficiency.value() + l.lost_overflow.value() + l.lost_death.value() +
                      l.lost_outside.value(),
                  1e-12);
      EXPECT_GT(l.taken.value(), 10);
      EXPECT_GT(l.burnt.value(), 1);
      EXPECT_GT(l.spent.value(), 1);
      EXPECT_GT(l.energy_lost.value(), 0.1);
      losses[0] += l.lost_efficiency.value();
      losses[1] += l.lost_overflow.value();
      losses[2] += l.lost_death.value();
      losses[3] += l.lost_outside.value();
      const Outcome& outcome = bench.world().organisms[k].outcome;
      divisions += static_cast<double>(outcome.divisions);
      EXPECT_GT(outcome.specializations, 0u);
    }
    EXPECT_GT(divisions, 50);
    for (const double loss : losses) EXPECT_GT(loss, 0.01);
    for (const char* cause : {"starvation", "apoptosis", "outside", "fire"})
      EXPECT_GT(bench.deaths(cause, 0) + bench.deaths(cause, 1), 0u) << cause;
  }
}

TEST(Books, SumForgetsNothingThatPlainAdditionWould) {
  Sum sum;
  sum += 1;
  for (int i = 0; i < 1000; ++i) sum += 1e-17;
  EXPECT_NEAR(sum.value() - 1, 1e-14, 1e-15);
  Sum cancelled;
  cancelled += 1;
  cancelled += 1e100;
  cancelled += 1;
  cancelled += -1e100;
  EXPECT_EQ(cancelled.value(), 2);
}

}  // namespace
}  // namespace somas::model::test
