// Cells of different organisms: what the options of `strangers` change, and what they do not.
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Two organisms in a world that moves and burns nothing by itself.
class Pair : public Bench {
 public:
  explicit Pair(Strangers strangers) {
    config.strangers = strangers;
    founders = {{.key = 1}, {.key = 2}};
    states[0].skills = {{"capacity", 10}, {"diffusion", 0.8}};
    free_living();
  }
};

/// Velocity of the second cell after a step of two cells at a distance.
double velocity(Strangers strangers, bool kin, double distance) {
  Pair bench(strangers);
  const auto other = static_cast<std::uint16_t>(kin ? 0 : 1);
  bench.start_with({{.id = 0}, {.id = 1, .x = distance, .organism = other}});
  bench.steps(1);
  return bench.cells().vx[bench.at(1, other)];
}

TEST(Strangers, AdhereAsKinDoIfToldTo) {
  for (const double distance : {1.8, 2.2, 2.39, 2.41}) {
    const double kin = velocity({}, true, distance);
    EXPECT_EQ(velocity({.adhere = true}, false, distance), kin) << distance;
    EXPECT_NE(velocity({}, false, distance), distance < 2.4 ? kin : 1.0) << distance;
  }
  EXPECT_LT(velocity({.adhere = true}, false, 2.2), 0) << "pulled";
  EXPECT_EQ(velocity({}, false, 2.2), 0) << "out of touch";
  EXPECT_EQ(velocity({.feed = true}, false, 2.2), 0) << "feeding is no force";
  EXPECT_EQ(velocity({.feed = true}, false, 1.9), velocity({}, false, 1.9));
}

std::size_t contacts(Strangers strangers, double distance) {
  Pair bench(strangers);
  bench.forceless();
  bench.start_with({{.id = 0}, {.id = 1, .x = distance, .organism = 1}});
  bench.steps(1);
  return bench.world().contacts.of(bench.at(0, 0)).size();
}

TEST(Strangers, AreInContactOnlyWhereTheyTouchAndFeed) {
  EXPECT_EQ(contacts({}, 1.9), 0u);
  EXPECT_EQ(contacts({.adhere = true}, 1.9), 0u) << "sticking does not feed";
  EXPECT_EQ(contacts({.feed = true}, 1.9), 1u) << "colliding";
  EXPECT_EQ(contacts({.feed = true}, 2.1), 0u) << "not colliding";
  EXPECT_EQ(contacts({.adhere = true, .feed = true}, 2.1), 1u) << "adhering";
  EXPECT_EQ(contacts({.adhere = true, .feed = true}, 2.5), 0u);
}

/// A giver between a relative and a stranger; gives half of its 6 in step 1.
class Giving : public Pair {
 public:
  explicit Giving(Strangers strangers) : Pair(strangers) {
    forceless();
    script = [](const Lane& lane) {
      if (lane.step == 1 && lane.id == 0) lane.out("diffusion", 0.5f);
    };
    start_with({{.id = 0, .ambrosia = 6},
                {.id = 1, .x = -1.9},
                {.id = 2, .x = 1.9, .ambrosia = 1, .organism = 1}});
    steps(2);
  }
  double ambrosia(std::uint64_t id, std::uint16_t organism) {
    return cells().ambrosia[at(id, organism)];
  }
};

TEST(Strangers, ShareAGiftWithKinWhenTheyFeed) {
  Giving fed({.feed = true});
  EXPECT_DOUBLE_EQ(fed.ambrosia(0, 0), 3);
  EXPECT_DOUBLE_EQ(fed.ambrosia(1, 0), 1.5 * 0.8);
  EXPECT_DOUBLE_EQ(fed.ambrosia(2, 1), 1 + 1.5 * 0.8);
  EXPECT_DOUBLE_EQ(fed.ledger(0).given.value(), 1.2);
  EXPECT_DOUBLE_EQ(fed.ledger(1).received.value(), 1.2);
  EXPECT_EQ(fed.ledger(0).received.value(), 0);
  EXPECT_EQ(fed.ledger(1).given.value(), 0);
  EXPECT_DOUBLE_EQ(fed.ledger(0).lost_efficiency.value(), 3 * 0.2);

  Giving apart({.adhere = true});
  EXPECT_DOUBLE_EQ(apart.ambrosia(1, 0), 3 * 0.8);
  EXPECT_EQ(apart.ambrosia(2, 1), 1);
  EXPECT_EQ(apart.ledger(0).given.value(), 0);
}

TEST(Strangers, InheritFromADyingNeighbourWhenTheyFeed) {
  for (const bool feed : {false, true}) {
    Pair bench({.feed = feed});
    bench.forceless();
    bench.config.cycle.apoptosis_steps = 1;
    bench.script = [](const Lane& lane) {
      if (lane.step == 1 && lane.id == 0) lane.out("apoptosis", 1);
      if (lane.step == 0) lane.out("quiescence", 1);
    };
    bench.config.cycle.quiescence_steps = 1;
    bench.start_with({{.id = 0, .ambrosia = 5}, {.id = 1, .x = 1.9, .ambrosia = 7, .organism = 1}});
    bench.steps(2);
    ASSERT_FALSE(bench.alive(0, 0));
    // 4 arrive where there is room for 3.
    EXPECT_DOUBLE_EQ(bench.cells().ambrosia[bench.at(1, 1)], feed ? 10 : 7);
    EXPECT_DOUBLE_EQ(bench.ledger(0).given.value(), feed ? 4 : 0);
    EXPECT_DOUBLE_EQ(bench.ledger(1).received.value(), feed ? 4 : 0);
    EXPECT_DOUBLE_EQ(bench.ledger(1).lost_overflow.value(), feed ? 1 : 0);
    EXPECT_DOUBLE_EQ(bench.ledger(0).lost_death.value(), feed ? 0 : 5);
  }
}

/// Stored ambrosia by organism.
std::vector<double> stored(Bench& bench) {
  std::vector<double> sums(bench.world().organisms.size());
  for (std::uint32_t i = 0; i < bench.cells().size(); ++i)
    sums[bench.cells().organism[i]] += bench.cells().ambrosia[i];
  return sums;
}

TEST(Strangers, KeepEveryOrganismsBooksBalanced) {
  for (const bool adhere : {false, true}) {
    Bench bench;
    const Busy busy;
    busy.set_up(bench);
    bench.config.strangers = {.adhere = adhere, .feed = true};
    bench.founders = {{.key = 5, .x = -2}, {.key = 2, .x = 2}, {.key = 9, .y = 2}};
    bench.start();
    for (int step = 0; step < 300 && !bench.simulation().finished(); ++step) {
      bench.steps(1);
      const std::vector<double> now = stored(bench);
      double given = 0, received = 0;
      for (std::size_t k = 0; k < now.size(); ++k) {
        const Ledger& l = bench.ledger(k);
        ASSERT_NEAR(l.founder_ambrosia + l.taken.value() + l.received.value(),
                    now[k] + l.burnt.value() + l.given.value() + l.lost(), 1e-9)
            << "organism " << k << ", step " << step;
        given += l.given.value();
        received += l.received.value();
      }
      ASSERT_NEAR(given, received, 1e-9);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GT(bench.ledger(k).given.value(), 0.1) << k;
      EXPECT_GT(bench.ledger(k).received.value(), 0.1) << k;
    }
  }
}

TEST(Strangers, PermutedRostersGivePermutedOutcomes) {
  const std::vector<Founder> founders = {
      {.key = 5, .x = -2}, {.key = 2, .x = 2}, {.key = 9, .y = 2}};
  std::vector<std::uint64_t> hashes;
  std::vector<std::vector<Outcome>> outcomes;
  for (const std::vector<std::size_t>& order :
       {std::vector<std::size_t>{0, 1, 2}, {2, 0, 1}, {1, 0, 2}}) {
    Bench bench;
    const Busy busy;
    busy.set_up(bench);
    bench.config.strangers = {.adhere = true, .feed = true};
    bench.config.max_steps = 150;
    bench.founders.clear();
    for (const std::size_t k : order) bench.founders.push_back(founders[k]);
    bench.start();
    bench.steps(140);
    hashes.push_back(bench.simulation().hash());
    bench.steps(10);
    std::vector<Outcome> sorted(3);
    for (std::size_t place = 0; place < 3; ++place)
      sorted[order[place]] = bench.simulation().outcomes()[place];
    outcomes.push_back(sorted);
  }
  for (std::size_t run = 1; run < 3; ++run) {
    EXPECT_EQ(hashes[run], hashes[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(outcomes[run][k].survival, outcomes[0][k].survival);
      EXPECT_EQ(outcomes[run][k].cell_steps, outcomes[0][k].cell_steps);
      EXPECT_EQ(outcomes[run][k].biomass_share, outcomes[0][k].biomass_share);
    }
  }
  EXPECT_NE(outcomes[0][0].cell_steps, outcomes[0][1].cell_steps);
}

// ---- share of biomass ---------------------------------------------------------------------------

TEST(BiomassShare, IsTheMeanOverStepsOfOwnCellsOverAllCells) {
  Bench bench;
  bench.founders = {{.key = 1, .x = -10}, {.key = 2, .x = 10}};
  bench.config.max_steps = 10;
  bench.free_living();
  bench.start_with({{.id = 0, .x = -10},
                    {.id = 1, .x = -14},
                    {.id = 2, .x = -18},
                    {.id = 3, .x = 10, .energy = 1, .organism = 1}});
  bench.steps(4);
  EXPECT_EQ(bench.simulation().outcomes()[0].biomass_share, 0) << "told at the end";
  bench.cells().energy[bench.at(0, 0)] = 0;  // starves in the next step
  bench.steps(6);
  ASSERT_TRUE(bench.simulation().finished());
  const std::vector<Outcome> outcomes = bench.simulation().outcomes();
  EXPECT_DOUBLE_EQ(outcomes[0].biomass_share, (4 * 0.75 + 6 * (2.0 / 3)) / 10);
  EXPECT_DOUBLE_EQ(outcomes[1].biomass_share, (4 * 0.25 + 6 * (1.0 / 3)) / 10);
}

TEST(BiomassShare, LeavesTheStepOfTheLastDeathOut) {
  Bench bench;
  bench.founders = {{.key = 1, .x = -10}, {.key = 2, .x = 10}};
  bench.free_living();
  bench.start();
  bench.steps(3);
  bench.cells().energy[bench.at(0, 0)] = 0;
  bench.steps(2);
  bench.cells().energy[bench.at(0, 1)] = 0;
  bench.steps(1);
  ASSERT_TRUE(bench.simulation().finished());
  const std::vector<Outcome> outcomes = bench.simulation().outcomes();
  EXPECT_DOUBLE_EQ(outcomes[0].biomass_share, 3 * 0.5 / 5);
  EXPECT_DOUBLE_EQ(outcomes[1].biomass_share, (3 * 0.5 + 2) / 5);
  EXPECT_EQ(outcomes[0].survival, 3u);
}

TEST(BiomassShare, IsOneForAnOrganismAlone) {
  Bench bench;
  bench.start();
  while (bench.simulation().step()) {
  }
  EXPECT_EQ(bench.simulation().outcomes()[0].biomass_share, 1);
}

}  // namespace
}  // namespace somas::model::test
