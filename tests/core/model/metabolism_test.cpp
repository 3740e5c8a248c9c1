// Section 2 of the model: nutrients, ambrosia and energy, against sums done by hand.
#include "core/model/metabolism.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Shares that a test sets by cell id.
struct Shares {
  std::map<std::uint64_t, float> uptake, conversion, diffusion;
};

/// A bench whose cells stay where they are put, live for nothing and follow `shares`. Cells placed
/// at spacing 2 touch their next neighbours only (the threshold is 2.4).
class MetabolismBench : public Bench {
 public:
  Shares shares;
  std::shared_ptr<Handles> food = std::make_shared<Handles>();

  MetabolismBench() {
    free_living();
    states[0].skills = {{"capacity", 10}, {"production", 3}};
    forceless();
    script = [this](const Lane& lane) {
      const auto share = [&](const std::map<std::uint64_t, float>& of) {
        const auto found = of.find(lane.id);
        return found == of.end() ? 0.0f : found->second;
      };
      if (food->resource != no_id) lane.out("uptake.food", share(shares.uptake));
      lane.out("conversion", share(shares.conversion));
      lane.out("diffusion", share(shares.diffusion));
    };
  }
  /// A grid of squares of side 100, so that all cells of one quadrant share a square.
  void feed(double content, double side = 100) {
    environments.push_back(resource_grid("food", content, 0, side, 2, "production", food));
  }
  /// Places cells, and lets one step without shares pass so that they are in contact.
  void put(const std::vector<Placed>& cells) {
    const Shares wanted = std::exchange(shares, {});
    start_with(cells);
    steps(1);
    shares = wanted;
  }
  [[nodiscard]] double ambrosia(std::uint64_t id) { return cells().ambrosia[at(id)]; }
  [[nodiscard]] double energy(std::uint64_t id) { return cells().energy[at(id)]; }
  [[nodiscard]] double content(std::size_t square) { return world().grids[food->grid][square]; }
};

// ---- shares -------------------------------------------------------------------------------------

TEST(Share, ClampsToTheUnitIntervalAndReadsNotANumberAsNothing) {
  EXPECT_EQ(share(0.25f), 0.25);
  EXPECT_EQ(share(-3.0f), 0);
  EXPECT_EQ(share(3.0f), 1);
  EXPECT_EQ(share(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(share(std::numeric_limits<float>::infinity()), 1);
}

// ---- founders -----------------------------------------------------------------------------------

TEST(Founder, StartsWithFullEnergyAndFiveAmbrosiaOrItsCapacity) {
  for (const auto& [capacity, expected] : {std::pair(10.0, 5.0), std::pair(0.5, 0.5)}) {
    Bench bench;
    bench.states[0].skills = {{"capacity", capacity}};
    bench.start();
    EXPECT_EQ(bench.cells().energy[0], 1);
    EXPECT_EQ(bench.cells().ambrosia[0], expected);
    EXPECT_EQ(bench.ledger().founder_ambrosia, expected);
    EXPECT_EQ(bench.ledger().founder_energy, 1);
  }
}

// ---- uptake -------------------------------------------------------------------------------------

TEST(Uptake, IsShareTimesProduction) {
  MetabolismBench bench;
  bench.feed(1000);
  bench.shares.uptake = {{0, 0.25f}, {1, 1.0f}};
  bench.put(
      {{.id = 0, .x = 10, .y = 10}, {.id = 1, .x = 20, .y = 10}, {.id = 2, .x = 30, .y = 10}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 0.75, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 3, 1e-12);
  EXPECT_EQ(bench.ambrosia(2), 0);
  EXPECT_NEAR(bench.content(3), 1000 - 3.75, 1e-12);
  EXPECT_EQ(bench.content(0), 1000) << "nobody is there";
  EXPECT_NEAR(bench.ledger().taken.value(), 3.75, 1e-12);
}

TEST(Uptake, StopsAtTheRoomThatIsLeft) {
  MetabolismBench bench;
  bench.feed(1000);
  bench.shares.uptake = {{0, 1.0f}, {1, 1.0f}};
  bench.put(
      {{.id = 0, .x = 10, .y = 10, .ambrosia = 8.5}, {.id = 1, .x = 20, .y = 10, .ambrosia = 10}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 10, 1e-12);
  EXPECT_EQ(bench.ambrosia(1), 10);
  EXPECT_NEAR(bench.content(3), 998.5, 1e-9);
}

TEST(Uptake, SplitsAScarceSquareInProportionToDemand) {
  // Demands 3, 1.5 and 0.5 (the third by its room) on a content of 2: the factor is 0.4.
  MetabolismBench bench;
  bench.feed(2);
  bench.shares.uptake = {{0, 1.0f}, {1, 0.5f}, {2, 1.0f}};
  bench.put({{.id = 0, .x = 10, .y = 10},
             {.id = 1, .x = 20, .y = 10, .ambrosia = 1},
             {.id = 2, .x = 30, .y = 10, .ambrosia = 9.5}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 1.2, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 1.6, 1e-12);
  EXPECT_NEAR(bench.ambrosia(2), 9.7, 1e-12);
  EXPECT_NEAR(bench.content(3), 0, 1e-12);
  EXPECT_GE(bench.content(3), 0);
}

TEST(Uptake, IsFromTheSquareThatHoldsTheCentre) {
  MetabolismBench bench;
  bench.feed(5);
  bench.shares.uptake = {{0, 1.0f}, {1, 1.0f}, {2, 1.0f}, {3, 1.0f}};
  // The disc of cell 0 hangs over both axes, yet its centre lies in the lower left square; the
  // lower and left edges belong to a square.
  bench.put({{.id = 0, .x = -0.1, .y = -0.1},
             {.id = 1, .x = 0, .y = -30},
             {.id = 2, .x = -30, .y = 0},
             {.id = 3, .x = 0, .y = 0}});
  bench.steps(1);
  for (std::size_t square = 0; square < 4; ++square) EXPECT_NEAR(bench.content(square), 2, 1e-12);
  for (std::uint64_t id = 0; id < 4; ++id) EXPECT_NEAR(bench.ambrosia(id), 3, 1e-12);
}

TEST(Uptake, FindsNothingBesideTheGrid) {
  MetabolismBench bench;
  bench.feed(5, 10);  // covers [-10, 10)
  bench.shares.uptake = {{0, 1.0f}, {1, 1.0f}};
  bench.put({{.id = 0, .x = 10, .y = 0}, {.id = 1, .x = 0, .y = -20}});
  bench.steps(1);
  EXPECT_EQ(bench.ambrosia(0), 0);
  EXPECT_EQ(bench.ambrosia(1), 0);
}

TEST(Uptake, OfAStateWithoutProductionIsNothing) {
  MetabolismBench bench;
  bench.states.push_back({.name = "idle", .parent = 0, .skills = {{"capacity", 10}}});
  bench.forceless();
  bench.feed(5);
  bench.shares.uptake = {{0, 1.0f}, {1, 1.0f}};
  bench.put({{.id = 0, .x = 10, .y = 10}, {.id = 1, .x = 20, .y = 10, .state = 1}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 3, 1e-12);
  EXPECT_EQ(bench.ambrosia(1), 0);
}

TEST(Uptake, OrganismsShareTheNutrients) {
  MetabolismBench bench;
  bench.feed(2);
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.shares.uptake = {{0, 1.0f}, {1, 1.0f}};
  bench.put(
      {{.id = 0, .x = 10, .y = 10, .organism = 0}, {.id = 1, .x = 30, .y = 10, .organism = 1}});
  bench.steps(1);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(0, 0)], 1, 1e-12);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(1, 1)], 1, 1e-12);
  EXPECT_NEAR(bench.ledger(0).taken.value(), 1, 1e-12);
  EXPECT_NEAR(bench.ledger(1).taken.value(), 1, 1e-12);
}

/// Two resources, "sweet" (skill "sweet_production") and "sour".
class TwoFoods : public Bench {
 public:
  std::shared_ptr<Handles> sweet = std::make_shared<Handles>(), sour = std::make_shared<Handles>();
  TwoFoods(double sweet_content, double sour_content, double capacity) {
    free_living();
    states[0].skills = {{"capacity", capacity}, {"sweet_production", 4}, {"sour_production", 2}};
    environments = {resource_grid("sweet", sweet_content, 0, 100, 2, "sweet_production", sweet),
                    resource_grid("sour", sour_content, 0, 100, 2, "sour_production", sour)};
    script = [](const Lane& lane) {
      lane.out("uptake.sweet", 0.75f);
      lane.out("uptake.sour", 0.5f);
    };
    start_with({{.id = 0, .x = 10, .y = 10}});
    steps(1);
  }
  [[nodiscard]] double left(const Handles& h) { return world().grids[h.grid][3]; }
};

TEST(Uptake, OfSeveralResourcesGoesByEachOnesProduction) {
  TwoFoods bench(100, 100, 50);
  EXPECT_NEAR(100 - bench.left(*bench.sweet), 3, 1e-12);
  EXPECT_NEAR(100 - bench.left(*bench.sour), 1, 1e-12);
  EXPECT_NEAR(bench.cells().ambrosia[0], 4, 1e-12);
}

TEST(Uptake, OfSeveralResourcesSharesTheRoomInProportion) {
  // Shares of 3 and 1 with room for 2: each demand alone is at most the room, so 2 and 1; together
  // they are taken in proportion, 4/3 and 2/3.
  TwoFoods bench(100, 100, 2);
  EXPECT_NEAR(100 - bench.left(*bench.sweet), 4.0 / 3, 1e-12);
  EXPECT_NEAR(100 - bench.left(*bench.sour), 2.0 / 3, 1e-12);
  EXPECT_NEAR(bench.cells().ambrosia[0], 2, 1e-12);
}

TEST(Uptake, OfAnEmptyResourceLeavesTheRoomToAFullOne) {
  TwoFoods bench(0, 100, 1);
  EXPECT_EQ(bench.left(*bench.sweet), 0);
  EXPECT_NEAR(100 - bench.left(*bench.sour), 1, 1e-12);
  EXPECT_NEAR(bench.cells().ambrosia[0], 1, 1e-12);
}

// ---- conversion ---------------------------------------------------------------------------------

TEST(Conversion, BurnsAShareOfTheAmbrosiaWithoutLoss) {
  MetabolismBench bench;
  bench.shares.conversion = {{0, 0.25f}};
  bench.put({{.id = 0, .energy = 0.3, .ambrosia = 2}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 1.5, 1e-12);
  EXPECT_NEAR(bench.energy(0), 0.8, 1e-12);
  EXPECT_NEAR(bench.ledger().burnt.value(), 0.5, 1e-12);
}

TEST(Conversion, FillsEnergyToOneAndNoFurther) {
  MetabolismBench bench;
  bench.shares.conversion = {{0, 1.0f}, {1, 1.0f}};
  bench.put({{.id = 0, .energy = 0.3, .ambrosia = 2},
             {.id = 1, .x = 10, .energy = 0.3, .ambrosia = 0.5}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 1.3, 1e-12);
  EXPECT_NEAR(bench.energy(0), 1, 1e-12);
  EXPECT_EQ(bench.ambrosia(1), 0);
  EXPECT_NEAR(bench.energy(1), 0.8, 1e-12);
}

TEST(Conversion, AppliesToWhatUptakeLeft) {
  MetabolismBench bench;
  bench.feed(1000);
  bench.shares.uptake = {{0, 1.0f}};
  bench.shares.conversion = {{0, 0.1f}};
  bench.put({{.id = 0, .x = 10, .y = 10, .energy = 0.1, .ambrosia = 1}});
  bench.steps(1);
  EXPECT_NEAR(bench.energy(0), 0.1 + 0.1f * 4.0, 1e-9);
  EXPECT_NEAR(bench.ambrosia(0), 4 - 0.1f * 4.0, 1e-9);
}

// ---- diffusion ----------------------------------------------------------------------------------

TEST(Diffusion, SplitsTheGiftEquallyAmongContacts) {
  MetabolismBench bench;
  bench.shares.diffusion = {{0, 0.75f}};
  bench.put({{.id = 0, .ambrosia = 8},
             {.id = 1, .x = 2},
             {.id = 2, .x = -2, .ambrosia = 1},
             {.id = 3, .y = 2},
             {.id = 4, .x = 20}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 2, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 2, 1e-12);
  EXPECT_NEAR(bench.ambrosia(2), 3, 1e-12);
  EXPECT_NEAR(bench.ambrosia(3), 2, 1e-12);
  EXPECT_EQ(bench.ambrosia(4), 0) << "not in contact";
}

TEST(Diffusion, CostsTheGiversEfficiencyNotTheReceivers) {
  MetabolismBench bench;
  bench.states[0].skills["diffusion"] = 0.5;
  bench.states.push_back(
      {.name = "perfect", .parent = 0, .skills = {{"capacity", 10}, {"diffusion", 1}}});
  bench.forceless();
  bench.shares.diffusion = {{0, 0.5f}};
  bench.put({{.id = 0, .ambrosia = 8}, {.id = 1, .x = 2, .state = 1}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 4, 1e-12) << "the giver loses q";
  EXPECT_NEAR(bench.ambrosia(1), 2, 1e-12) << "the receiver gains efficiency x q";
  EXPECT_NEAR(bench.ledger().lost_efficiency.value(), 2, 1e-12);

  bench.shares.diffusion = {{1, 1.0f}};
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 6, 1e-12) << "the other way nothing is lost";
  EXPECT_NEAR(bench.ambrosia(1), 0, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_efficiency.value(), 2, 1e-12);
}

TEST(Diffusion, WithoutContactKeepsEverything) {
  MetabolismBench bench;
  bench.shares.diffusion = {{0, 1.0f}};
  bench.put({{.id = 0, .ambrosia = 8}, {.id = 1, .x = 2.5}});
  bench.steps(1);
  EXPECT_EQ(bench.ambrosia(0), 8);
  EXPECT_EQ(bench.ambrosia(1), 0);
}

TEST(Diffusion, ScalesCompetingOffersToTheRoomAndTheRestStays) {
  // Efficiency 0.5. Offers of 6 and 2 arrive as 3 and 1; there is room for 1: a quarter of each is
  // taken, and what is refused stays with its giver.
  MetabolismBench bench;
  bench.states[0].skills["diffusion"] = 0.5;
  bench.shares.diffusion = {{0, 1.0f}, {2, 0.5f}};
  bench.put({{.id = 0, .x = -2, .ambrosia = 6},
             {.id = 1, .x = 0, .ambrosia = 9},
             {.id = 2, .x = 2, .ambrosia = 4}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(1), 10, 1e-12);
  EXPECT_NEAR(bench.ambrosia(0), 6 - 1.5, 1e-12);
  EXPECT_NEAR(bench.ambrosia(2), 4 - 0.5, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_efficiency.value(), 1, 1e-12);
}

TEST(Diffusion, MeasuresRoomBeforeOwnGifts) {
  // Cell 1 is full and gives everything away, yet takes nothing in the same step.
  MetabolismBench bench;
  bench.shares.diffusion = {{0, 1.0f}, {1, 1.0f}};
  bench.put(
      {{.id = 0, .x = -2, .ambrosia = 5}, {.id = 1, .x = 0, .ambrosia = 10}, {.id = 2, .x = 2}});
  bench.steps(1);
  // Of its 10, cell 1 offers 5 to each side; both fit.
  EXPECT_NEAR(bench.ambrosia(0), 5 + 5, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 0, 1e-12);
  EXPECT_NEAR(bench.ambrosia(2), 5, 1e-12);
}

TEST(Diffusion, ComputesAllGiftsBeforeAnyIsReceived) {
  // A chain 0 - 1 - 2, everybody gives all. By hand, with efficiency 0.8 and ambrosia 4, 2, 1:
  // 0 gives 4 to 1; 1 gives 1 to either side; 2 gives 1 to 1.
  MetabolismBench bench;
  bench.states[0].skills["diffusion"] = 0.8;
  bench.shares.diffusion = {{0, 1.0f}, {1, 1.0f}, {2, 1.0f}};
  bench.put({{.id = 0, .x = -2, .ambrosia = 4},
             {.id = 1, .x = 0, .ambrosia = 2},
             {.id = 2, .x = 2, .ambrosia = 1}});
  bench.steps(1);
  EXPECT_NEAR(bench.ambrosia(0), 0.8, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 0.8 * 5, 1e-12);
  EXPECT_NEAR(bench.ambrosia(2), 0.8, 1e-12);
  EXPECT_NEAR(bench.ledger().lost_efficiency.value(), 0.2 * 7, 1e-12);
}

TEST(Diffusion, AppliesToWhatConversionLeft) {
  MetabolismBench bench;
  bench.shares.conversion = {{0, 0.5f}};
  bench.shares.diffusion = {{0, 0.5f}};
  bench.put({{.id = 0, .energy = 0.2, .ambrosia = 1}, {.id = 1, .x = 2}});
  bench.steps(1);
  EXPECT_NEAR(bench.energy(0), 0.7, 1e-12);
  EXPECT_NEAR(bench.ambrosia(0), 0.25, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 0.25, 1e-12);
}

TEST(Diffusion, GiftsOfThisStepAreNotConvertedBeforeTheNext) {
  MetabolismBench bench;
  bench.shares.conversion = {{1, 1.0f}};
  bench.shares.diffusion = {{0, 1.0f}};
  bench.put({{.id = 0, .ambrosia = 0.5}, {.id = 1, .x = 2, .energy = 0.2}});
  bench.steps(1);
  EXPECT_NEAR(bench.energy(1), 0.2, 1e-12);
  EXPECT_NEAR(bench.ambrosia(1), 0.5, 1e-12);
  bench.steps(1);
  EXPECT_NEAR(bench.energy(1), 0.7, 1e-12);
}

TEST(Diffusion, DoesNotReachOtherOrganisms) {
  MetabolismBench bench;
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.shares.diffusion = {{0, 1.0f}};
  bench.put({{.id = 0, .ambrosia = 4, .organism = 0}, {.id = 1, .x = 1.5, .organism = 1}});
  bench.steps(1);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(0, 0)], 4);
  EXPECT_EQ(bench.cells().ambrosia[bench.at(1, 1)], 0);
}

TEST(Diffusion, EqualsAllPairsArithmeticOnRandomClusters) {
  Dice dice(1);
  for (int trial = 0; trial < 20; ++trial) {
    MetabolismBench bench;
    bench.states[0].skills["diffusion"] = 0.7;
    bench.states.push_back(
        {.name = "small", .parent = 0, .skills = {{"capacity", 2}, {"diffusion", 0.9}}});
    bench.forceless();
    std::vector<Placed> cells;
    for (std::uint64_t id = 0; id < 30; ++id) {
      const auto state = static_cast<std::uint16_t>(dice.below(2));
      cells.push_back({.id = id,
                       .x = dice.uniform(-6, 6),
                       .y = dice.uniform(-6, 6),
                       .state = state,
                       .ambrosia = dice.uniform(0, state == 0 ? 10 : 2)});
      bench.shares.diffusion[id] = static_cast<float>(dice.uniform(-0.2, 1.2));
    }
    bench.put(cells);
    bench.steps(1);

    const auto touch = [&](std::size_t a, std::size_t b) {
      return a != b && std::hypot(cells[a].x - cells[b].x, cells[a].y - cells[b].y) < 2.4;
    };
    std::vector<double> offer(30), scale(30), after(30);
    for (std::size_t i = 0; i < 30; ++i) {
      int contacts = 0;
      for (std::size_t j = 0; j < 30; ++j) contacts += touch(i, j);
      const double wish = std::clamp<double>(bench.shares.diffusion[i], 0, 1);
      offer[i] = contacts == 0 ? 0 : wish * cells[i].ambrosia / contacts;
    }
    const auto efficiency = [&](std::size_t i) { return cells[i].state == 0 ? 0.7 : 0.9; };
    for (std::size_t i = 0; i < 30; ++i) {
      double incoming = 0;
      for (std::size_t j = 0; j < 30; ++j)
        if (touch(i, j)) incoming += efficiency(j) * offer[j];
      const double room = (cells[i].state == 0 ? 10 : 2) - cells[i].ambrosia;
      scale[i] = incoming <= room ? 1 : room / incoming;
      after[i] = cells[i].ambrosia + incoming * scale[i];
    }
    for (std::size_t i = 0; i < 30; ++i)
      for (std::size_t j = 0; j < 30; ++j)
        if (touch(i, j)) after[i] -= offer[i] * scale[j];
    for (std::size_t i = 0; i < 30; ++i) EXPECT_NEAR(bench.ambrosia(i), after[i], 1e-9);
  }
}

// ---- cost ---------------------------------------------------------------------------------------

TEST(Cost, IsThatOfTheRunningActionOverEnergyEfficiency) {
  const std::vector<std::pair<std::string, double>> actions{
      {"quiescence", 0.03}, {"division", 0.12}, {"apoptosis", 0.05}, {"specialize.leaf", 0.08}};
  for (const double efficiency : {1.0, 2.0, 0.5})
    for (const auto& [action, cost] : actions) {
      Bench bench;
      bench.states = {{.name = "root", .skills = {{"energy_efficiency", efficiency}}},
                      {.name = "leaf", .parent = 0}};
      bench.script = [&](const Lane& lane) { lane.out(action, 1); };
      bench.start();
      for (int step = 1; step <= 3; ++step) {
        bench.steps(1);
        EXPECT_NEAR(bench.cells().energy[0], 1 - step * cost / efficiency, 1e-12) << action;
        EXPECT_NEAR(bench.ledger().spent.value(), step * cost / efficiency, 1e-12);
      }
    }
}

TEST(Cost, OfMotilityGoesByForceAndIsAddedToThatOfTheAction) {
  for (const double motility : {4.0, -4.0, 0.0})
    for (const double efficiency : {1.0, 2.0}) {
      Bench bench;
      bench.config.metabolism.motility_cost = 0.005;
      bench.states = {
          {.name = "root", .skills = {{"energy_efficiency", efficiency}}, .motility = motility}};
      bench.start();
      bench.steps(3);
      const double cost = (0.03 + (motility == 0 ? 0 : 0.02)) / efficiency;
      EXPECT_NEAR(bench.cells().energy[0], 1 - 3 * cost, 1e-12) << motility;
      EXPECT_NEAR(bench.ledger().spent.value(), 3 * cost, 1e-12) << motility;
    }
}

TEST(Cost, OfMotilityIsNothingUnlessTheExperimentSaysSo) {
  Bench bench;
  bench.states[0].motility = 100;
  bench.start();
  bench.steps(1);
  EXPECT_NEAR(bench.cells().energy[0], 1 - 0.03, 1e-15);
}

TEST(Cost, IsChargedAfterConversionAndDiffusion) {
  // With energy below the cost a cell still lives on what it converts in the same step.
  Bench bench;
  bench.states[0].skills = {{"capacity", 10}};
  bench.script = [](const Lane& lane) { lane.out("conversion", 1); };
  bench.start_with({{.id = 0, .energy = 0.01, .ambrosia = 0.04}});
  bench.steps(1);
  ASSERT_TRUE(bench.alive(0));
  EXPECT_NEAR(bench.cells().energy[0], 0.02, 1e-12);
  EXPECT_EQ(bench.cells().ambrosia[0], 0);
}

TEST(Starvation, IsEnergyOfABillionthOrLess) {
  for (const auto& [left, lives] : {std::pair(2e-9, true), std::pair(0.9e-9, false)}) {
    Bench bench;
    bench.start_with({{.id = 0, .energy = 0.03 + left}, {.id = 1, .x = 10}});
    bench.steps(1);
    EXPECT_EQ(bench.alive(0), lives) << left;
    EXPECT_EQ(bench.deaths("starvation"), lives ? 0u : 1u);
    EXPECT_TRUE(bench.alive(1));
  }
}

TEST(Starvation, BooksTheCostActuallyPaid) {
  Bench bench;
  bench.start_with({{.id = 0, .energy = 0.01}, {.id = 1, .x = 10}});
  bench.steps(1);
  EXPECT_FALSE(bench.alive(0));
  EXPECT_NEAR(bench.ledger().spent.value(), 0.01 + 0.03, 1e-12);
}

TEST(Starvation, LetsAFounderInQuiescenceLiveThirtyThreeSteps) {
  // Energy 1, cost 0.03: after 33 steps 0.01 is left, the 34th cannot be paid.
  Bench bench;
  bench.start();
  bench.steps(33);
  EXPECT_TRUE(bench.alive(0));
  bench.steps(1);
  EXPECT_TRUE(bench.simulation().finished());
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 33u);
}

}  // namespace
}  // namespace somas::model::test
