// The engine lives as the plain reference does (reference/), to the last bit, among toy plugins;
// and a reference that errs is found out. Among the bundled plugins:
// tests/plugins/experiments/reference_test.cpp. SOMAS_REFERENCE_SEEDS makes more of the random
// worlds (reference/seeds.hpp).
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/core/model/reference/compare.hpp"
#include "tests/core/model/reference/seeds.hpp"
#include "tests/core/model/support.hpp"

namespace somas::reference {
namespace {

using model::test::Bench;
using model::test::Busy;
using model::test::Dice;
using model::test::Handles;
using model::test::Placed;

/// Rays from all sides that burn the first cell they meet, and values of every rule of division.
model::NamedEnvironment rays() {
  auto handles = std::make_shared<Handles>();
  auto toy = std::make_shared<model::test::ToyEnvironment>();
  toy->on_declare = [=](Declare& d) {
    handles->hazard = d.hazard("ray", d.skill("resistance", {}));
    handles->purpose = d.purpose("rays");
    handles->value = d.cell_value("burns", OnDivision::copy);
    handles->scalar = d.cell_value("burns_of_its_own", OnDivision::zero);
    d.acts_in(Phase::stress);
  };
  toy->on_act = [=](Phase, somas::World& world) {
    for (std::uint64_t ray = 0; ray < 3; ++ray) {
      Rng rng = world.rng(handles->purpose, ray);
      const Segment path{rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-8, 8),
                         rng.uniform(-8, 8)};
      std::int32_t hit = -1;
      world.first_hit({&path, 1}, {&hit, 1});
      if (hit < 0) continue;
      const auto cell = static_cast<std::uint32_t>(hit);
      world.strike(cell, handles->hazard, 0.1);
      world.cell_value(handles->value)[cell] += 1;
      world.cell_value(handles->scalar)[cell] += 1;
    }
  };
  return {"rays", toy};
}

/// Now and then something that is no share.
void write_nonsense(const model::test::Lane& lane) {
  const float odd[] = {std::numeric_limits<float>::quiet_NaN(),
                       std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity(), -3.0f, 40.0f};
  const char* outputs[] = {"quiescence", "division",    "specialize.leaf", "apoptosis",
                           "conversion", "morphogen.1", "diffusion",       "uptake.food"};
  for (std::uint64_t o = 0; o < std::size(outputs); ++o) {
    const float draw = model::test::noise(lane.id, lane.step, 100 + o);
    if (draw < 0.1f) lane.out(outputs[o], odd[static_cast<std::size_t>(draw * 50)]);
  }
}

/// A world in which everything happens to three organisms that begin side by side.
struct BusyWorld {
  Bench bench;
  World reference;

  explicit BusyWorld(model::Strangers strangers) {
    Busy().set_up(bench);
    bench.environments.push_back(rays());
    bench.config.strangers = strangers;
    bench.script = [sensible = bench.script](const model::test::Lane& lane) {
      sensible(lane);
      write_nonsense(lane);
    };
    bench.config.metabolism.motility_cost = 0.003;
    bench.config.morphogens.size = 7;  // the world goes on beyond it
    bench.config.morphogens.side = 1.5;
    bench.states[0].skills["production"] = 2.9;  // demands that are rounded
    bench.states[1].skills["production"] = 0.7;
    bench.states[0].motility = 0.4;
    bench.states[1].motility = -0.7;
    bench.states[1].motility_signal = 2;
    bench.states[1].adhesion_with = {1.5};
    bench.states[1].division_threshold = 0.6;
    bench.founders = {{.key = 9, .x = -1}, {.key = 4, .x = 1}, {.key = 7, .y = 1.5}};
    bench.start();
    reference = copy_of(bench.simulation());
  }

  /// Up to so many steps of both.
  std::optional<Difference> run(int steps) {
    for (int s = 0; s < steps && !bench.simulation().finished(); ++s) {
      // The reference first: the scripted controllers look at the engine's world.
      step(reference);
      bench.simulation().step();
      if (auto difference = compare(bench.simulation(), reference)) return difference;
    }
    return {};
  }
};

/// As worlds of thousands of cells are moved.
void move_by_island_for_some(std::uint64_t seed, Bench& bench) {
  if (seed % 4 < 2) bench.simulation().move_by_island_from(2);
}

TEST(Reference, LivesAsTheEngineDoesInABusyWorld) {
  Events events;
  for (const bool adhere : {false, true}) {
    for (const bool feed : {false, true}) {
      BusyWorld world({.adhere = adhere, .feed = feed});
      move_by_island_for_some(feed ? 0 : 2, world.bench);
      const auto difference = world.run(250);
      ASSERT_FALSE(difference) << difference->text();
      events.add(world.reference.events);
    }
  }
  EXPECT_GT(events.births, 500u);
  EXPECT_GT(events.specializations, 50u);
  EXPECT_GT(events.refused_divisions, 0u);
  EXPECT_GT(events.gifts_to_strangers, 100u);
  EXPECT_GT(events.shrunk_gifts, 100u);
  EXPECT_GT(events.legacies, 10u);
  EXPECT_GT(events.scarce_demands, 100u);
  EXPECT_GT(events.crawls, 100u);
  EXPECT_GT(events.hits, 100u);
  for (const char* cause : {"starvation", "apoptosis", "outside", "fire", "ray", "bolt"})
    EXPECT_GT(events.deaths[cause], 0u) << cause;
}

// ---- bodies placed by hand ----------------------------------------------------------------------

/// Somewhere awkward: in a heap, on edges and centres of grids, at another's place, far outside.
void place(Dice& dice, const std::vector<Placed>& others, Placed& cell) {
  const auto coordinate = [&] { return dice.uniform(-2.5, 2.5); };
  cell.x = coordinate(), cell.y = coordinate();
  switch (dice.below(8)) {
    case 0:
      if (others.empty()) return;
      cell.x = others[dice.below(others.size())].x;
      cell.y = others.back().y;
      return;
    case 1: {  // at the same place, or nearly
      if (others.empty()) return;
      const double offsets[] = {0, 0, 1e-13, 1e-11, 1e-7};
      cell.x = others.back().x + offsets[dice.below(5)], cell.y = others.back().y;
      return;
    }
    case 2:  // an edge of the nutrients' grid and one of the morphogens'
      cell.x = 2 * static_cast<double>(dice.below(5)) - 4;
      cell.y = 1.5 * static_cast<double>(dice.below(8)) - 5.25;
      return;
    case 3:  // a centre of each
      cell.x = 2 * static_cast<double>(dice.below(5)) - 3;
      cell.y = 1.5 * static_cast<double>(dice.below(7)) - 4.5;
      if (dice.below(2) == 0) cell.x = 1.5 * static_cast<double>(dice.below(9)) - 6;
      return;
    case 4:
      cell.x = dice.below(2) == 0 ? Busy::radius : -Busy::radius, cell.y = 0;
      return;
    case 5:
      if (dice.below(4) == 0) cell.x = dice.below(2) == 0 ? 1e7 : 1e160;
      return;
    default:
      return;
  }
}

std::vector<Placed> heap(Dice& dice) {
  std::vector<Placed> cells;
  for (std::uint64_t id = 0, count = 2 + dice.below(80); id < count; ++id) {
    Placed cell{.id = id,
                .vx = dice.uniform(-3, 3),
                .vy = dice.uniform(-3, 3),
                .state = static_cast<std::uint16_t>(dice.below(2)),
                .energy = dice.uniform(0, 1),
                .ambrosia = dice.uniform(0, 0.6),
                .organism = static_cast<std::uint16_t>(dice.below(3))};
    place(dice, cells, cell);
    cells.push_back(cell);
  }
  dice.shuffle(cells);
  return cells;
}

TEST(Reference, LivesAsTheEngineDoesWithHeapsOfCellsInAwkwardPlaces) {
  Events events;
  const Seeds seeds = seeds_asked_for(40);
  for (std::uint64_t seed = seeds.first; seed < seeds.end; ++seed) {
    Dice dice(seed);
    BusyWorld world({.adhere = dice.below(2) == 0, .feed = dice.below(2) == 0});
    world.bench.replace(heap(dice));
    move_by_island_for_some(seed, world.bench);
    world.reference = copy_of(world.bench.simulation());
    const auto difference = world.run(12);
    ASSERT_FALSE(difference) << "seed " << seed << ": " << difference->text();
    events.add(world.reference.events);
  }
  if (seeds.count() < 40) return;
  EXPECT_GT(events.coincident_pairs, 50u);
  EXPECT_GT(events.deaths["outside"], 50u);
}

// ---- who meets whom -----------------------------------------------------------------------------

/// Cells that fly at each other in an empty world, some of them growing on the way: whether pairs
/// are found in time depends on these few alone.
void set_up_flight(Dice& dice, Bench& bench) {
  bench.free_living();
  bench.config.morphogens.size = 3;  // nobody signals
  bench.config.mechanics.drag = dice.below(2) == 0 ? 0 : dice.uniform(0, 0.3);
  bench.config.mechanics.substeps = static_cast<std::uint32_t>(1 + dice.below(4));
  bench.config.mechanics.time_step = dice.uniform(0.01, 0.04);
  bench.config.cycle.division_steps = static_cast<std::uint32_t>(1 + dice.below(20));
  bench.config.strangers = {.adhere = dice.below(2) == 0, .feed = true};
  bench.states = {{.name = "root", .adhesion_range = dice.uniform(1, 1.4)},
                  {.name = "leaf",
                   .parent = 0,
                   .radius = 0.7,
                   .adhesion = 1,
                   .adhesion_range = dice.uniform(1, 1.7)}};
  bench.founders = {{.key = 1}, {.key = 2}};
  if (dice.below(2) == 0) {  // some crawl up what there is, others down
    bench.states[0].motility = dice.uniform(0, 3);
    bench.states[1].motility = dice.uniform(-3, 0);
  }
  const auto divides_at = static_cast<std::uint64_t>(dice.below(30));
  bench.script = [divides_at](const model::test::Lane& lane) {
    if (lane.step >= divides_at && lane.id == 0) lane.out("division", 1);
    if (lane.step >= divides_at && lane.id == 1) lane.out("specialize.leaf", 1);
  };
}

std::vector<Placed> flying(Dice& dice) {
  std::vector<Placed> cells;
  const double angle = dice.uniform(0, 6.3), speed = std::exp(dice.uniform(-3, 3));
  const auto fly = [&](double distance, double direction, double towards) {
    cells.push_back({.id = cells.size(),
                     .x = distance * std::cos(direction),
                     .y = distance * std::sin(direction),
                     .vx = -towards * std::cos(direction),
                     .vy = -towards * std::sin(direction),
                     .state = static_cast<std::uint16_t>(dice.below(2)),
                     .organism = static_cast<std::uint16_t>(dice.below(2))});
  };
  // Two head on, perhaps as fast as each other; others from any side, or standing there.
  const double distance = dice.uniform(1, 2);
  fly(distance, angle, speed);
  fly(distance, angle + std::numbers::pi, dice.below(3) > 0 ? speed : dice.uniform(0, speed));
  for (std::uint64_t others = dice.below(3); others > 0; --others)
    fly(dice.uniform(1, 5), dice.uniform(0, 6.3), dice.below(2) == 0 ? 0 : speed);
  return cells;
}

/// Lives on from these cells, for so many steps.
std::optional<Difference> compare_from(const std::vector<Placed>& cells, int steps,
                                       std::uint64_t seed, Bench& bench) {
  bench.start_with(cells);
  for (model::OrganismState& organism : bench.world().organisms) organism.fields.set(0, 2, 1, 1);
  move_by_island_for_some(seed, bench);
  World reference = copy_of(bench.simulation());
  for (int s = 0; s < steps; ++s) {
    step(reference);
    bench.simulation().step();
    if (auto difference = compare(bench.simulation(), reference)) return difference;
  }
  return {};
}

TEST(Reference, LivesAsTheEngineDoesWithFewCellsThatFlyAtEachOther) {
  const Seeds seeds = seeds_asked_for(800);
  for (std::uint64_t seed = seeds.first; seed < seeds.end; ++seed) {
    Dice dice(seed);
    Bench bench;
    set_up_flight(dice, bench);
    const auto difference = compare_from(flying(dice), 40, seed, bench);
    ASSERT_FALSE(difference) << "seed " << seed << ": " << difference->text();
  }
}

TEST(Reference, LivesAsTheEngineDoesWithCrowdsThatOnlyMove) {
  // All of one size, so that who may meet whom is as narrow as it can be.
  const Seeds seeds = seeds_asked_for(40);
  for (std::uint64_t seed = seeds.first; seed < seeds.end; ++seed) {
    Dice dice(seed);
    Bench bench;
    set_up_flight(dice, bench);
    bench.script = {};
    bench.states[1].radius = 1;
    const double pitch = 2 * bench.states[0].adhesion_range * dice.uniform(0.98, 1);
    const bool lattice = seed % 2 == 0;  // each hardly within reach of the next
    std::vector<Placed> cells(20 + dice.below(130));
    const double extent = dice.uniform(3, 12), speed = lattice ? 0.05 : dice.uniform(0, 1);
    for (std::uint64_t id = 0; id < cells.size(); ++id) {
      Placed& cell = cells[id];
      cell = {.id = id,
              .x = dice.uniform(-extent, extent),
              .y = dice.uniform(-extent, extent),
              .vx = dice.uniform(-speed, speed),
              .vy = dice.uniform(-speed, speed),
              .state = static_cast<std::uint16_t>(dice.below(1 + seed / 2 % 2)),
              .organism = static_cast<std::uint16_t>(dice.below(2))};
      if (!lattice) continue;
      cell.x = pitch * static_cast<double>(id % 12);
      cell.y = pitch * static_cast<double>(id / 12);
    }
    const auto difference = compare_from(cells, 20, seed, bench);
    ASSERT_FALSE(difference) << "seed " << seed << ": " << difference->text();
  }
}

// ---- a difference is found ----------------------------------------------------------------------

/// The first difference that a mistake makes, in a life from founders or in a heap of cells.
std::optional<Difference> difference_by(Mistake mistake) {
  BusyWorld world({.adhere = true, .feed = true});
  world.reference.mistake = mistake;
  if (auto difference = world.run(250)) return difference;
  Dice dice(1);
  BusyWorld heaped({.adhere = true, .feed = true});
  heaped.bench.replace(heap(dice));
  heaped.reference = copy_of(heaped.bench.simulation());
  heaped.reference.mistake = mistake;
  return heaped.run(12);
}

struct Fault {
  Mistake mistake;
  std::string what;  ///< how the first difference ends
};

TEST(Reference, ThatErrsIsFoundOutByTheFirstThingThatItGetsWrong) {
  const Fault faults[] = {{Mistake::no_damper, ": vx"},
                          {Mistake::forces_descending, ": vx"},
                          {Mistake::stress_descending, ": stress_xx"},
                          {Mistake::gifts_descending, ": ambrosia"},
                          {Mistake::demands_descending, ": taken, its error"},
                          {Mistake::books_by_name, ": burnt, the sum"},
                          {Mistake::late_adhesion, ": vx"},
                          {Mistake::share_of_all, ": ambrosia"},
                          {Mistake::own_gift_first, ": ambrosia"},
                          {Mistake::divisions_first, ": ambrosia"},
                          {Mistake::second_cause, ": deaths by cause 1"},
                          {Mistake::last_hit, ": cell value"},
                          {Mistake::spread_first, ": morphogen 0 at column 2, row 1"}};
  for (const Fault& fault : faults) {
    const auto difference = difference_by(fault.mistake);
    EXPECT_TRUE(difference) << "missed: " << fault.what;
    if (!difference) continue;
    EXPECT_TRUE(difference->what.ends_with(fault.what)) << fault.what << "; " << difference->text();
  }
}

/// Changes one thing in a world.
struct Change {
  const char* what;  ///< the difference
  std::function<void(World&)> make;
};

/// Those of the third cell.
std::vector<Change> changes_of_a_cell() {
  const auto number = [](const char* what, double Cell::*member) {
    return Change{what, [=](World& world) {
                    double& value = world.cells[2].*member;
                    value = std::nextafter(value, 1e9);
                  }};
  };
  const auto cell = [](const char* what, std::function<void(Cell&)> make) {
    return Change{what, [=](World& world) { make(world.cells[2]); }};
  };
  return {number("vx", &Cell::vx),
          number("vy", &Cell::vy),
          number("x", &Cell::x),
          number("y", &Cell::y),
          number("radius", &Cell::radius),
          number("energy", &Cell::energy),
          number("ambrosia", &Cell::ambrosia),
          number("pressure", &Cell::pressure),
          number("stress_xx", &Cell::stress_xx),
          number("stress_xy", &Cell::stress_xy),
          number("stress_yy", &Cell::stress_yy),
          cell("id", [](Cell& c) { c.name.id += 1000; }),
          cell("organism", [](Cell& c) { ++c.name.organism; }),
          cell("state", [](Cell& c) { c.state ^= 1; }),
          cell("parent", [](Cell& c) { ++c.parent; }),
          cell("born", [](Cell& c) { ++c.born; }),
          cell("action",
               [](Cell& c) {
                 c.action = c.action == Action::none ? Action::quiescence : Action::none;
               }),
          cell("target", [](Cell& c) { ++c.target; }),
          cell("remaining", [](Cell& c) { ++c.remaining; }),
          cell("dead", [](Cell& c) { c.dead = true; }),
          cell("cause", [](Cell& c) { c.cause = 0; }),
          cell("cell value", [](Cell& c) { c.values[0] += 1; }),
          cell("damage", [](Cell& c) { c.damage[1] += 1e-9; }),
          cell("memory", [](Cell& c) { c.memory[1] = std::nextafter(c.memory[1], 1e9f); }),
          cell("contacts, how many", [](Cell& c) { c.contacts.pop_back(); }),
          cell("contact's id", [](Cell& c) { ++c.contacts.back().id; }),
          cell("contact's organism", [](Cell& c) { ++c.contacts.back().organism; })};
}

/// Those of the second organism and of what surrounds the cells.
std::vector<Change> changes_of_the_world() {
  const auto organism = [](const char* what, std::function<void(Organism&)> make) {
    return Change{what, [=](World& world) { make(world.organisms[1]); }};
  };
  return {{"how many", [](World& w) { w.cells.pop_back(); }},
          organism("next id", [](Organism& o) { ++o.next_id; }),
          organism("live", [](Organism& o) { ++o.live; }),
          organism("shares", [](Organism& o) { o.shares += 1e-9; }),
          organism("deaths by cause 2", [](Organism& o) { ++o.deaths[2]; }),
          organism("divisions", [](Organism& o) { ++o.outcome.divisions; }),
          organism("refused divisions", [](Organism& o) { ++o.outcome.refused_divisions; }),
          organism("cell steps", [](Organism& o) { ++o.outcome.cell_steps; }),
          organism("given, the sum", [](Organism& o) { o.ledger.given.sum += 1e-9; }),
          organism("spent, its error", [](Organism& o) { o.ledger.spent.error += 1e-20; }),
          organism("morphogen 1 at column 4, row 0",
                   [](Organism& o) { o.fields[1].squares[4] = 1e-30f; }),
          {"square 7", [](World& w) { w.grids[0][7] += 1e-9; }},
          {"cell of row, how many", [](World& w) { w.tables[0].columns[0].push_back(1); }},
          {"scalar 0", [](World& w) { w.scalars[0] = -w.scalars[0]; }},
          {"step", [](World& w) { ++w.step; }},
          {"seed", [](World& w) { ++w.seed; }},
          {"finished", [](World& w) { w.finished = true; }}};
}

TEST(Reference, ThatDiffersInOneNumberIsFoundOutByItsName) {
  BusyWorld world({.feed = true});
  ASSERT_FALSE(world.run(60));
  ASSERT_FALSE(compare(world.bench.simulation(), copy_of(world.bench.simulation())));
  std::vector<Change> changes = changes_of_a_cell();
  for (const Change& change : changes_of_the_world()) changes.push_back(change);
  for (const Change& change : changes) {
    World changed = copy_of(world.bench.simulation());
    change.make(changed);
    const auto difference = compare(world.bench.simulation(), changed);
    EXPECT_TRUE(difference) << "missed: " << change.what;
    if (!difference) continue;
    EXPECT_TRUE(difference->what.ends_with(std::string(": ") + change.what))
        << change.what << ": " << difference->text();
    EXPECT_EQ(difference->step, 59u);
  }
}

TEST(Reference, HashesAWorldAsTheEngineDoesAndMissesNothingThatCounts) {
  BusyWorld world({.feed = true});
  ASSERT_FALSE(world.run(60));
  const World same = copy_of(world.bench.simulation());
  EXPECT_EQ(hash_of(same), world.bench.simulation().hash());
  for (const Change& change : changes_of_a_cell()) {
    World changed = same;
    change.make(changed);
    EXPECT_NE(hash_of(changed), hash_of(same)) << change.what;
  }
}

}  // namespace
}  // namespace somas::reference
