// Saved worlds: exact, complete, refused where they do not fit, harmless where they are damaged.
#include "core/model/snapshot.hpp"

#define XXH_INLINE_ALL
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>
#include <xxhash.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using Bytes = std::vector<std::byte>;

/// Gives a Busy world's organisms a mind without a stage: what a lane does follows from its memory
/// alone, which it fills from its inputs. Restored simulations have no stage.
class Mindful final : public Controller {
 public:
  explicit Mindful(std::uint32_t memory_rows) : memory_rows_(memory_rows) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView, const Layout& layout) const override {
    return std::make_unique<Mind>(layout, memory_rows_);
  }

 private:
  class Mind final : public Program {
   public:
    Mind(const Layout& layout, std::uint32_t rows) : layout_(layout), rows_(rows) {}
    [[nodiscard]] std::uint32_t memory_per_cell() const override { return rows_; }
    void step(const Batch& batch) const override {
      for (std::uint32_t lane = 0; lane < batch.count; ++lane) {
        std::uint64_t seen = 0;
        for (std::uint32_t c = 0; c < batch.in.channels; ++c)
          seen = seen * 31 + std::bit_cast<std::uint32_t>(batch.in.channel(c)[lane]);
        float& clock = batch.memory.channel(0)[lane];
        float& mood = batch.memory.channel(1)[lane];
        mood = 0.5f * mood + noise(seen, 1, 2);
        clock += 1;
        const auto age = static_cast<std::uint64_t>(clock);
        for (const Port& port : layout_.outputs)
          batch.out.channel(port.channel)[lane] =
              scale(port.name) * noise(age, std::bit_cast<std::uint32_t>(mood), port.key);
      }
    }

   private:
    static float scale(std::string_view output) {
      if (output == "division") return 3.0f;
      if (output == "apoptosis") return 0.35f;
      if (output == "specialize.leaf") return 0.5f;
      return output == "conversion" ? 0.5f : 0.85f;
    }
    Layout layout_;
    std::uint32_t rows_;
  };
  std::uint32_t memory_rows_;
  NoGenes genes_;
};

/// A busy world of three organisms, the roster not in the order of their keys.
struct Crowd {
  Bench bench;
  Busy busy;

  explicit Crowd(std::uint64_t seed = 3, std::uint32_t memory_rows = 2) {
    busy.set_up(bench);
    bench.config.warm_up_steps = 25;
    bench.script = {};
    bench.controller = std::make_shared<Mindful>(memory_rows);
    bench.founders = {{.key = 9, .x = -3}, {.key = 2, .x = 3}, {.key = 4, .y = 3}};
    bench.seed = seed;
    bench.start();
  }
  [[nodiscard]] std::vector<const Phenotype*> phenotypes() const {
    return {&bench.phenotype(0), &bench.phenotype(1), &bench.phenotype(2)};
  }
  [[nodiscard]] std::unique_ptr<Simulation> restored(const Bytes& bytes) {
    return std::make_unique<Simulation>(bench.ecosystem(), phenotypes(), bytes);
  }
  [[nodiscard]] std::string refusal(const Bytes& bytes) {
    try {
      static_cast<void>(restored(bytes));
    } catch (const SnapshotError& error) {
      return error.what();
    }
    return "";
  }
};

void sign(Bytes& bytes) {
  const std::uint64_t sum = XXH3_64bits(bytes.data(), bytes.size() - 8);
  std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
}

bool same(const Outcome& a, const Outcome& b) {
  return a.survival == b.survival && a.censored == b.censored && a.divisions == b.divisions &&
         a.specializations == b.specializations && a.refused_divisions == b.refused_divisions &&
         a.final_cells == b.final_cells && a.peak_cells == b.peak_cells &&
         a.cell_steps == b.cell_steps;
}

void expect_same_books(const WorldState& a, const WorldState& b) {
  for (std::size_t k = 0; k < a.organisms.size(); ++k) {
    const Ledger &x = a.organisms[k].ledger, &y = b.organisms[k].ledger;
    EXPECT_EQ(x.taken.value(), y.taken.value());
    EXPECT_EQ(x.burnt.value(), y.burnt.value());
    EXPECT_EQ(x.spent.value(), y.spent.value());
    EXPECT_EQ(x.lost(), y.lost());
    EXPECT_EQ(x.energy_lost.value(), y.energy_lost.value());
    EXPECT_EQ(a.organisms[k].deaths, b.organisms[k].deaths);
    EXPECT_TRUE(same(a.organisms[k].outcome, b.organisms[k].outcome)) << k;
  }
}

// ---- the law -----------------------------------------------------------------------------------

TEST(Snapshot, LivesOnToTheSameBytesFromAnyStepOfABusyWorld) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Crowd crowd(seed);
    Simulation& original = crowd.bench.simulation();
    std::vector<Bytes> saves{save(original)};
    std::vector<std::uint64_t> hashes{original.hash()};
    while (saves.size() <= 160 && original.step()) {
      saves.push_back(save(original));
      hashes.push_back(original.hash());
    }
    ASSERT_GT(saves.size(), 60u);
    for (std::size_t start = 0; start < saves.size(); start += 29) {
      const auto twin = crowd.restored(saves[start]);
      for (std::size_t step = start; step < saves.size(); ++step) {
        ASSERT_EQ(twin->hash(), hashes[step]) << start << " to " << step;
        ASSERT_EQ(save(*twin), saves[step]) << start << " to " << step;
        if (step + 1 < saves.size()) twin->step();
      }
      EXPECT_EQ(twin->finished(), original.finished());
      expect_same_books(twin->state(), original.state());
    }
    double divisions = 0;
    for (const Outcome& outcome : original.outcomes())
      divisions += static_cast<double>(outcome.divisions);
    EXPECT_GT(divisions, 30) << "something must happen";
    EXPECT_FALSE(original.state().tables[0].rows() == 0 && original.state().contacts.items.empty());
  }
}

TEST(Snapshot, OfAFinishedWorldIsFinished) {
  Crowd crowd;
  crowd.bench.simulation().run();
  const Bytes bytes = save(crowd.bench.simulation());
  const auto twin = crowd.restored(bytes);
  EXPECT_TRUE(twin->finished());
  EXPECT_FALSE(twin->step());
  EXPECT_EQ(save(*twin), bytes);
  EXPECT_EQ(twin->outcomes().size(), 3u);
}

TEST(Snapshot, KeepsEveryBitOfWhatIsNoNumber) {
  Crowd crowd;
  crowd.bench.steps(40);
  WorldState& world = crowd.bench.world();
  ASSERT_GT(world.cells.size(), 3u);
  const std::array<std::uint64_t, 4> odd{0x7FF0000000000001, 0xFFF8000000ABCDEF, 0x8000000000000000,
                                         0x0000000000000001};
  for (std::size_t k = 0; k < odd.size(); ++k) {
    world.cells.vx[k % world.cells.size()] = std::bit_cast<double>(odd[k]);
    world.grids[0][k] = std::bit_cast<double>(odd[k]);
  }
  world.scalars[0] = -std::numeric_limits<double>::infinity();
  world.cells.memory.row(1)[0] = std::bit_cast<float>(0xFFC12345u);
  world.organisms[0].fields.set(0, 3, 4, std::bit_cast<float>(0x7FC00001u));
  const Bytes bytes = save(crowd.bench.simulation());
  const auto twin = crowd.restored(bytes);
  EXPECT_EQ(save(*twin), bytes);
  EXPECT_EQ(twin->hash(), crowd.bench.simulation().hash());
  EXPECT_EQ(std::bit_cast<std::uint64_t>(twin->state().grids[0][1]), odd[1]);
}

TEST(Snapshot, HoldsTheErrorOfEverySum) {
  Crowd crowd;
  Sum& taken = crowd.bench.world().organisms[0].ledger.taken;
  taken = Sum(1e16);
  taken += 0.25;
  ASSERT_NE(taken.error(), 0);
  const auto twin = crowd.restored(save(crowd.bench.simulation()));
  EXPECT_EQ(twin->state().organisms[0].ledger.taken.sum(), taken.sum());
  EXPECT_EQ(twin->state().organisms[0].ledger.taken.error(), taken.error());
}

TEST(Snapshot, DoesNotDependOnWhenPairsOfNeighboursWereFound) {
  // The original keeps pairs found in earlier steps; each twin finds its own, at another step.
  Crowd crowd;
  crowd.bench.steps(30);
  std::vector<std::unique_ptr<Simulation>> twins;
  for (int step = 0; step < 12; ++step) {
    twins.push_back(crowd.restored(save(crowd.bench.simulation())));
    crowd.bench.steps(1);
    for (const auto& twin : twins) {
      twin->step();
      ASSERT_EQ(twin->hash(), crowd.bench.simulation().hash()) << step;
    }
  }
}

TEST(Snapshot, ChangedParametersHoldFromThenOn) {
  Crowd crowd;
  crowd.bench.steps(40);
  const Bytes bytes = save(crowd.bench.simulation());
  Crowd dear;
  Metabolism& costs = dear.bench.config.metabolism;
  costs.quiescence_cost = costs.division_cost = costs.apoptosis_cost = costs.specialization_cost =
      5;
  dear.bench.start();
  const auto twin = dear.restored(bytes);
  EXPECT_EQ(twin->hash(), crowd.bench.simulation().hash());
  EXPECT_EQ(twin->steps_done(), 40u);
  twin->step();
  EXPECT_EQ(twin->state().cells.size(), 0u) << "nobody can pay";
}

// ---- refusals ----------------------------------------------------------------------------------

TEST(Snapshot, OfAnotherExperimentSaysWhatDiffers) {
  const Bytes bytes = save(Crowd().bench.simulation());
  const auto refusal = [&](const std::function<void(Bench&)>& change) {
    Crowd other;
    change(other.bench);
    other.bench.start();
    return other.refusal(bytes);
  };
  EXPECT_EQ(refusal([](Bench&) {}), "");
  EXPECT_EQ(refusal([](Bench& b) { b.config.morphogens.size = 33; }),
            "the saved state is of another experiment: morphogens: 3 on 65 x 65 squares of side 2 "
            "in the state, 3 on 33 x 33 squares of side 2 in the experiment");
  EXPECT_THAT(refusal([](Bench& b) { b.config.morphogens.kinds.pop_back(); }),
              HasSubstr("morphogens: 3 on "));
  EXPECT_THAT(refusal([](Bench& b) { b.states[1].name = "thorn"; }),
              HasSubstr("organism 2: states: root, leaf in the state, root, thorn in the "
                        "experiment"));
  EXPECT_THAT(refusal([](Bench& b) { b.controller = std::make_shared<Mindful>(3u); }),
              HasSubstr("organism 2: controller memory of a cell: 2 in the state, 3 in"));
  EXPECT_THAT(refusal([](Bench& b) { b.config.max_steps = 0; }),
              HasSubstr("before step 0, but the world ends after 0 steps"));
  const auto declaring = [&](const std::function<void(Declare&)>& declare) {
    return refusal([&](Bench& b) {
      b.environments.push_back(acting(
          "more", Phase::fields, [](World&) {}, declare));
    });
  };
  EXPECT_THAT(declaring([](Declare& d) { d.skill("speed", {}); }),
              AllOf(HasSubstr("skills: capacity, "), HasSubstr(", speed in the experiment")));
  EXPECT_THAT(declaring([](Declare& d) { d.sensor("light"); }),
              HasSubstr("sensors: content in the state, content, light in the experiment"));
  EXPECT_THAT(declaring([](Declare& d) { d.cell_value("age", OnDivision::zero); }),
              HasSubstr("cell values: fiery.wounds in the state, fiery.wounds, more.age in"));
  EXPECT_THAT(declaring([](Declare& d) { d.scalar("heat", 1); }),
              HasSubstr("scalars: growing.season in the state, growing.season, more.heat in"));
  EXPECT_THAT(declaring([](Declare& d) { d.grid("heat", {.columns = 2, .rows = 3, .side = 0.5}); }),
              HasSubstr(", more.heat 2 x 3 of side 0.5 from (0, 0) in the experiment"));
  EXPECT_THAT(declaring([](Declare& d) {
                d.table("drops", std::array<std::string_view, 2>{"x", "y"});
              }),
              HasSubstr(", more.drops (x, y) in the experiment"));
  EXPECT_THAT(declaring([](Declare& d) { d.cause("drowned"); }),
              HasSubstr("causes of death: starvation, apoptosis, outside, fire, bolt in the "
                        "state, starvation, apoptosis, outside, fire, bolt, drowned in"));
  EXPECT_THAT(declaring([](Declare& d) { d.hazard("water", d.skill("resistance", {})); }),
              HasSubstr("causes of death: "));
  EXPECT_THAT(
      declaring([](Declare& d) { d.resource("air", d.grid("air", {.columns = 1, .rows = 1}), 0); }),
      HasSubstr("grids: "));
}

TEST(Snapshot, OfAnotherRosterIsRefused) {
  Crowd crowd;
  const Bytes bytes = save(crowd.bench.simulation());
  std::vector<const Phenotype*> two = crowd.phenotypes();
  two.pop_back();
  try {
    const Simulation twin(crowd.bench.ecosystem(), two, bytes);
    FAIL() << "no exception";
  } catch (const SnapshotError& error) {
    EXPECT_THAT(error.what(), HasSubstr("organisms: 3 in the state, 2 in the experiment"));
  }
  EXPECT_THROW(Simulation(crowd.bench.ecosystem(), std::span<const Phenotype* const>(), bytes),
               std::invalid_argument);
}

TEST(Snapshot, OfAnotherFormatOrNoneIsRefused) {
  Crowd crowd;
  Bytes bytes = save(crowd.bench.simulation());
  EXPECT_EQ(crowd.refusal({}), "this is no saved state: it does not begin with SOMASNAP");
  bytes[8] = std::byte{9};
  EXPECT_EQ(crowd.refusal(bytes), "the saved state has format 9; this version reads format 1");
  bytes[0] = std::byte{'s'};
  EXPECT_THAT(crowd.refusal(bytes), StartsWith("this is no saved state"));
}

// ---- damage ------------------------------------------------------------------------------------

/// A world small enough to damage everywhere.
Crowd small_crowd() {
  Crowd crowd;
  crowd.bench.config.morphogens.size = 7;
  crowd.bench.environments.erase(crowd.bench.environments.begin());
  crowd.bench.states[0].skills.erase("production");
  crowd.bench.start();
  crowd.bench.steps(25);
  return crowd;
}

TEST(Snapshot, EveryTruncationIsRefused) {
  Crowd crowd = small_crowd();
  const Bytes bytes = save(crowd.bench.simulation());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_FALSE(crowd.refusal({bytes.begin(), bytes.begin() + static_cast<long>(size)}).empty())
        << size << " of " << bytes.size();
  Bytes longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_THAT(crowd.refusal(longer), HasSubstr("its checksum is wrong"));
}

TEST(Snapshot, TruncationsUnderARightChecksumAreRefusedToo) {
  Crowd crowd = small_crowd();
  const Bytes bytes = save(crowd.bench.simulation());
  for (std::size_t size = 20; size < bytes.size(); ++size) {
    Bytes cut(bytes.begin(), bytes.begin() + static_cast<long>(size));
    sign(cut);
    ASSERT_FALSE(crowd.refusal(cut).empty()) << size << " of " << bytes.size();
  }
  Bytes longer = bytes;
  longer.resize(bytes.size() + 5);
  sign(longer);
  EXPECT_THAT(crowd.refusal(longer), HasSubstr("there is more in it than a world"));
}

TEST(Snapshot, EveryFlippedByteIsRefused) {
  Crowd crowd = small_crowd();
  const Bytes bytes = save(crowd.bench.simulation());
  Dice dice(5);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    Bytes flipped = bytes;
    flipped[at] ^= static_cast<std::byte>(1 + dice.below(255));
    ASSERT_FALSE(crowd.refusal(flipped).empty()) << at;
  }
}

TEST(Snapshot, ForgedBytesAreRefusedOrLive) {
  Crowd crowd = small_crowd();
  const Bytes bytes = save(crowd.bench.simulation());
  Dice dice(6);
  int lived = 0, refused = 0;
  for (int attempt = 0; attempt < 4000; ++attempt) {
    Bytes forged = bytes;
    for (std::uint64_t flips = 1 + dice.below(3); flips > 0; --flips) {
      const std::size_t at = 12 + dice.below(bytes.size() - 20);
      forged[at] = dice.below(3) == 0 ? std::byte{0xFF} : static_cast<std::byte>(dice.below(256));
    }
    sign(forged);
    try {
      const auto twin = crowd.restored(forged);
      // What was let in is a world: it can be saved, and steps without going out of bounds.
      ASSERT_EQ(save(*twin), forged);
      for (int step = 0; step < 3; ++step) twin->step();
      ++lived;
    } catch (const SnapshotError&) {
      ++refused;
    } catch (const PluginFailure&) {
      ++lived;  // numbers that an environment or a controller rejects
    }
  }
  EXPECT_GT(lived, 100);
  EXPECT_GT(refused, 100);
}

TEST(Snapshot, DamageIsNamed) {
  Crowd crowd;
  crowd.bench.steps(40);
  WorldState& world = crowd.bench.world();
  ASSERT_GT(world.cells.size(), 3u);
  const auto refusal = [&](auto& place, auto value) {
    const auto before = place;
    place = static_cast<std::remove_reference_t<decltype(place)>>(value);
    const std::string text = crowd.refusal(save(crowd.bench.simulation()));
    place = before;
    return text;
  };
  const CellStore& c = world.cells;
  const std::uint32_t i = c.order[1];
  CellStore& cells = world.cells;
  EXPECT_THAT(refusal(cells.organism[i], 7), HasSubstr("a cell is of no organism"));
  EXPECT_THAT(refusal(cells.id[i], 1u << 30), HasSubstr("a name that is still to be given"));
  EXPECT_THAT(refusal(cells.id[i], cells.id[c.order[0]]), HasSubstr("cells are out of order"));
  EXPECT_THAT(refusal(cells.state[i], 2), HasSubstr("in no state of its tree"));
  EXPECT_THAT(refusal(cells.action[i], Action{5}), HasSubstr("does what no cell can"));
  EXPECT_THAT(refusal(cells.dead[i], 2), HasSubstr("neither dead nor alive"));
  EXPECT_THAT(refusal(cells.cause[i], 99), HasSubstr("died of no cause"));
  cells.target[i] = no_state;
  EXPECT_THAT(refusal(cells.action[i], Action::specialization),
              HasSubstr("specializes into no state of its tree"));
  EXPECT_THAT(refusal(world.organisms[0].live, 99), HasSubstr("another number of cells"));
  EXPECT_THAT(refusal(world.organisms[0].key, 100), HasSubstr("organisms are out of order"));
  EXPECT_THAT(refusal(world.organisms[0].roster_index, 3), HasSubstr("no place in the roster"));
  EXPECT_THAT(refusal(world.organisms[0].roster_index, world.organisms[1].roster_index),
              HasSubstr("two organisms have one place in the roster"));
  ASSERT_FALSE(world.contacts.items.empty());
  std::uint32_t owner = 0;
  while (world.contacts.of(owner).empty()) ++owner;
  EXPECT_THAT(refusal(world.contacts.items[world.contacts.runs[owner].begin], owner),
              HasSubstr("touches no other cell"));
}

// ---- wounds ------------------------------------------------------------------------------------

TEST(Wounds, TakeTheCellsWhoseCentresLieInTheDisc) {
  Bench bench;
  bench.free_living();
  bench.forceless();
  bench.start_with(
      {{.id = 0, .x = 0}, {.id = 1, .x = 2}, {.id = 2, .x = 2.001}, {.id = 3, .y = -3}});
  EXPECT_EQ(bench.simulation().wound({.x = 1, .y = 0, .radius = 1}), 2u);
  EXPECT_FALSE(bench.alive(0) || bench.alive(1));
  EXPECT_TRUE(bench.alive(2) && bench.alive(3));
  EXPECT_EQ(bench.world().organisms[0].live, 2u);
  EXPECT_EQ(bench.simulation().wound({.x = 50, .y = 0, .radius = 1}), 0u);
  EXPECT_FALSE(bench.simulation().finished());
}

TEST(Wounds, KeepTheBooksAndNameNoCause) {
  Crowd crowd;
  crowd.bench.steps(60);
  WorldState& world = crowd.bench.world();
  double ambrosia = 0, energy = 0;
  for (std::uint32_t i = 0; i < world.cells.size(); ++i) {
    if (world.cells.x[i] * world.cells.x[i] + world.cells.y[i] * world.cells.y[i] > 9) continue;
    ambrosia += world.cells.ambrosia[i];
    energy += world.cells.energy[i];
  }
  const auto lost = [&] {
    double sum[2] = {0, 0};
    for (const OrganismState& o : world.organisms) {
      sum[0] += o.ledger.lost_death.value();
      sum[1] += o.ledger.energy_lost.value();
    }
    return std::pair(sum[0], sum[1]);
  };
  const auto before = lost();
  const auto deaths = world.organisms[0].deaths;
  ASSERT_GT(crowd.bench.simulation().wound({.x = 0, .y = 0, .radius = 3}), 2u);
  EXPECT_NEAR(lost().first - before.first, ambrosia, 1e-9);
  EXPECT_NEAR(lost().second - before.second, energy, 1e-9);
  EXPECT_EQ(world.organisms[0].deaths, deaths);
}

TEST(Wounds, LeaveTheContactsOfTheOthers) {
  Bench bench;
  bench.free_living();
  bench.start_with({{.id = 0, .x = 0}, {.id = 1, .x = 1.7}, {.id = 2, .x = 3.4}});
  bench.steps(1);
  ASSERT_EQ(bench.world().contacts.of(bench.at(1)).size(), 2u);
  bench.simulation().wound({.x = 0, .y = 0, .radius = 0.5});
  ASSERT_EQ(bench.world().contacts.of(bench.at(1)).size(), 1u);
  EXPECT_EQ(bench.world().contacts.of(bench.at(1))[0], bench.at(2));
}

TEST(Wounds, ThatTakeEverybodyEndTheLife) {
  Bench bench;
  bench.free_living();
  bench.start();
  bench.steps(5);
  EXPECT_EQ(bench.simulation().wound({.x = 0, .y = 0, .radius = 100}), 1u);
  EXPECT_TRUE(bench.simulation().finished());
  EXPECT_FALSE(bench.simulation().step());
  const Outcome outcome = bench.simulation().outcomes()[0];
  EXPECT_EQ(outcome.survival, 5u);
  EXPECT_FALSE(outcome.censored);
  EXPECT_EQ(outcome.final_cells, 0u);
}

TEST(Wounds, ThatTakeOneOrganismLeaveTheOther) {
  Bench bench;
  bench.free_living();
  bench.founders = {{.key = 1, .x = -10}, {.key = 2, .x = 10}};
  bench.start();
  bench.steps(5);
  EXPECT_EQ(bench.simulation().wound({.x = -10, .y = 0, .radius = 3}), 1u);
  EXPECT_FALSE(bench.simulation().finished());
  bench.steps(5);
  EXPECT_EQ(bench.simulation().outcomes()[0].survival, 5u);
  EXPECT_EQ(bench.world().organisms[1].live, 1u);
}

}  // namespace
}  // namespace somas::model::test
