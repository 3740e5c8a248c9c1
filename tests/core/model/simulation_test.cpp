// One simulation as a whole: order of phases, determinism, hash, plugins' failures, allocations.
#include "core/model/simulation.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

// ---- counting allocations -----------------------------------------------------------------------

namespace {

std::atomic<bool> counting = false;
std::atomic<std::size_t> allocations = 0;

void* counted(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  void* memory =
      alignment <= alignof(std::max_align_t)
          ? std::malloc(size == 0 ? 1 : size)
          : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// All of them go to malloc and free, which the compiler takes for a mismatch.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t size) { return counted(size, 1); }
void* operator new[](std::size_t size) { return counted(size, 1); }
void* operator new(std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size, 1); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size, 1); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace somas::model::test {
namespace {

// ---- determinism --------------------------------------------------------------------------------

std::vector<std::uint64_t> hashes(std::uint64_t seed, int steps,
                                  const std::vector<Founder>& founders = {{.key = 1}}) {
  Bench bench;
  const Busy busy;
  busy.set_up(bench);
  bench.seed = seed;
  bench.founders = founders;
  bench.start();
  std::vector<std::uint64_t> all{bench.simulation().hash()};
  for (int i = 0; i < steps; ++i) {
    bench.steps(1);
    all.push_back(bench.simulation().hash());
  }
  return all;
}

TEST(Determinism, SameSeedGivesTheSameHashAfterEveryStep) {
  const auto first = hashes(7, 150), second = hashes(7, 150);
  EXPECT_EQ(first, second);
  EXPECT_EQ(std::set(first.begin(), first.end()).size(), first.size()) << "and every step another";
}

TEST(Determinism, AnotherSeedGivesAnotherRun) {
  const auto first = hashes(7, 60), second = hashes(8, 60);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NE(first[i], second[i]) << i;
}

TEST(Determinism, AnotherKeyDrawsOtherRandomNumbers) {
  // A lone cell's first division has no axis to follow.
  const auto place = [](std::uint64_t key) {
    Bench bench;
    bench.free_living();
    bench.founders = {{.key = key}};
    bench.script = [](const Lane& lane) { lane.out("division", 1); };
    bench.start();
    bench.steps(20);
    return bench.cells().x[0];
  };
  EXPECT_EQ(place(1), place(1));
  EXPECT_NE(place(1), place(2));
}

/// All that a cell carries, bit for bit.
using Record = std::tuple<double, double, double, double, double, double, double, double, double,
                          std::uint64_t, std::uint32_t, Action, double, double, float, float>;

std::map<std::uint64_t, Record> records(Bench& bench, std::uint16_t organism) {
  std::map<std::uint64_t, Record> all;
  const CellStore& c = bench.cells();
  for (std::uint32_t i = 0; i < c.size(); ++i)
    if (c.organism[i] == organism)
      all[c.id[i]] = {c.x[i],
                      c.y[i],
                      c.vx[i],
                      c.vy[i],
                      c.radius[i],
                      c.energy[i],
                      c.ambrosia[i],
                      c.pressure[i],
                      c.stress_xy[i],
                      c.parent[i],
                      c.remaining[i],
                      c.action[i],
                      c.damage[0][i],
                      c.values[0][i],
                      c.memory.row(0)[i],
                      c.memory.row(1)[i]};
  return all;
}

std::array<double, 8> figures(const Ledger& l) {
  return {l.taken.value(),         l.burnt.value(),      l.lost_efficiency.value(),
          l.lost_overflow.value(), l.lost_death.value(), l.lost_outside.value(),
          l.spent.value(),         l.energy_lost.value()};
}

void expect_same_fields(const MorphogenFields& a, const MorphogenFields& b) {
  for (std::size_t kind = 0; kind < a.kinds(); ++kind)
    EXPECT_TRUE(std::equal(a.raw(kind).begin(), a.raw(kind).end(), b.raw(kind).begin()));
}

TEST(Determinism, StorageOrderNeverReachesTheArithmetic) {
  // Cells are stored by state. States that differ in name alone, dealt out differently, permute the
  // storage and must change nothing else, to the last bit.
  Dice dice(3);
  std::vector<Placed> cells;
  for (std::uint64_t id = 0; id < 40; ++id)
    cells.push_back({.id = id,
                     .x = dice.uniform(-6, 6),
                     .y = dice.uniform(-6, 6),
                     .energy = dice.uniform(0.5, 1),
                     .ambrosia = dice.uniform(0, 5)});
  const auto run = [&](std::uint64_t deal, Bench& bench) {
    const Busy busy;
    busy.set_up(bench);
    StateDef alike = bench.states[0];
    for (const char* name : {"second", "third"}) {
      alike.name = name;
      alike.parent = 0;
      bench.states.push_back(alike);
    }
    Dice dealer(deal);
    for (Placed& cell : cells) {
      const std::array<std::uint16_t, 3> states{0, 2, 3};
      cell.state = states[dealer.below(3)];
    }
    const Script busily = bench.script;
    bench.script = [=](const Lane& lane) {
      busily(lane);
      lane.out("specialize.leaf", -9);  // a child of the root alone
    };
    dealer.shuffle(cells);
    bench.start_with(cells);
  };
  Bench first, second;
  run(1, first);
  run(2, second);
  ASSERT_NE(first.cells().id, second.cells().id);
  for (int step = 0; step < 80; ++step) {
    first.steps(1);
    second.steps(1);
    ASSERT_EQ(records(first, 0), records(second, 0)) << "step " << step;
    ASSERT_EQ(first.world().grids, second.world().grids);
    expect_same_fields(first.world().organisms[0].fields, second.world().organisms[0].fields);
  }
  EXPECT_GT(first.world().organisms[0].outcome.divisions, 10u);
  EXPECT_EQ(figures(first.ledger()), figures(second.ledger())) << "sums run by id, not by storage";
}

TEST(Determinism, FarCompanyChangesNothing) {
  // The environments' random strikes go by cell id alone, so both organisms see the same.
  const auto run = [](std::vector<Founder> founders, Bench& bench) {
    const Busy busy;
    busy.set_up(bench);
    bench.config.radius = 60;
    bench.config.max_cells = 30;
    bench.environments.back().instance = [&] {
      auto fire = std::make_shared<ToyEnvironment>();
      fire->on_declare = [h = busy.fire](Declare& d) {
        h->hazard = d.hazard("fire", d.skill("resistance", {}));
        h->value = d.cell_value("wounds", OnDivision::halve);
        h->purpose = d.purpose("strikes");
        d.acts_in(Phase::stress);
      };
      fire->on_act = [h = busy.fire](Phase, World& w) {
        for (std::uint32_t i = 0; i < w.cells().count; ++i) {
          Rng rng = w.rng(h->purpose, w.cells().id[i]);
          if (rng.chance(0.02)) w.strike(i, h->hazard, 0.6);
        }
      };
      return fire;
    }();
    bench.founders = std::move(founders);
    bench.start();
  };
  Bench alone, first, last;
  run({{.key = 5, .x = -30}}, alone);
  run({{.key = 5, .x = -30}, {.key = 9, .x = 31, .y = 3}}, first);  // organism 0 of two
  run({{.key = 2, .x = 31, .y = 3}, {.key = 5, .x = -30}}, last);   // organism 1 of two
  for (int step = 0; step < 100; ++step) {
    for (Bench* bench : {&alone, &first, &last}) bench->steps(1);
    ASSERT_EQ(records(alone, 0), records(first, 0)) << "step " << step;
    ASSERT_EQ(records(alone, 0), records(last, 1)) << "step " << step;
  }
  expect_same_fields(alone.world().organisms[0].fields, first.world().organisms[0].fields);
  expect_same_fields(alone.world().organisms[0].fields, last.world().organisms[1].fields);
  EXPECT_EQ(figures(alone.ledger(0)), figures(first.ledger(0)));
  EXPECT_EQ(figures(alone.ledger(0)), figures(last.ledger(1)));
  EXPECT_GT(alone.world().organisms[0].outcome.divisions, 10u);
  EXPECT_GT(first.world().organisms[1].outcome.divisions, 10u);
}

TEST(Determinism, PermutedRosterPermutesTheOutcomes) {
  const std::vector<Founder> founders{{.key = 7, .x = -3}, {.key = 3, .x = 3}, {.key = 5, .y = 4}};
  const auto run = [&](const std::vector<std::size_t>& order, Bench& bench) {
    const Busy busy;
    busy.set_up(bench);
    bench.founders.clear();
    for (const std::size_t i : order) bench.founders.push_back(founders[i]);
    bench.config.max_steps = 120;
    bench.start();
    bench.simulation().run();
  };
  Bench plain, permuted;
  run({0, 1, 2}, plain);
  run({2, 0, 1}, permuted);
  EXPECT_EQ(plain.simulation().hash(), permuted.simulation().hash());
  const auto a = plain.simulation().outcomes(), b = permuted.simulation().outcomes();
  const std::array<std::size_t, 3> place{1, 2, 0};
  std::set<double> lives;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a[i].survival, b[place[i]].survival);
    EXPECT_EQ(a[i].cell_steps, b[place[i]].cell_steps);
    EXPECT_EQ(a[i].divisions, b[place[i]].divisions);
    EXPECT_EQ(plain.simulation().census(i), permuted.simulation().census(place[i]));
    lives.insert(a[i].cell_steps);
  }
  EXPECT_EQ(lives.size(), 3u) << "three different lives";
  EXPECT_GT(a[0].divisions + a[1].divisions + a[2].divisions, 20u);
}

// ---- hash ---------------------------------------------------------------------------------------

TEST(Hash, ChangesWithAnyColumnOfTheCells) {
  Bench bench;
  const Busy busy;
  busy.set_up(bench);
  bench.start();
  bench.steps(40);
  ASSERT_GT(bench.cells().size(), 3u);
  const std::uint64_t before = bench.simulation().hash();
  EXPECT_EQ(bench.simulation().hash(), before);
  int columns = 0;
  std::set<std::uint64_t> seen{before};
  bench.cells().each_column([&](auto& column) {
    auto& value = column[column.size() / 2];
    const auto kept = value;
    using T = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_enum_v<T>)
      value = kept == Action::none ? Action::apoptosis : Action::none;
    else
      value = static_cast<T>(value + 1);
    EXPECT_TRUE(seen.insert(bench.simulation().hash()).second) << "column " << columns;
    value = kept;
    ++columns;
  });
  EXPECT_EQ(bench.simulation().hash(), before);
  EXPECT_EQ(columns, 21 + 1 + 1) << "a cell value and a hazard beside the model's own";
}

TEST(Hash, ChangesWithAllElseThatTheNextStepReads) {
  Bench bench;
  const Busy busy;
  busy.set_up(bench);
  bench.start();
  while (bench.world().tables[0].rows() == 0 || bench.world().contacts.items.empty())
    bench.steps(1);
  WorldState& world = bench.world();
  const std::uint64_t before = bench.simulation().hash();
  const auto expect_changed = [&](const char* what, auto& value, auto other) {
    const auto kept = value;
    ASSERT_NE(kept, other);
    value = static_cast<std::remove_reference_t<decltype(value)>>(other);
    EXPECT_NE(bench.simulation().hash(), before) << what;
    value = kept;
    EXPECT_EQ(bench.simulation().hash(), before) << what;
  };
  expect_changed("seed", world.seed, 99u);
  expect_changed("step", world.step, 12345u);
  expect_changed("memory", world.cells.memory.row(1)[0], -1.0f);
  expect_changed("memory", world.cells.memory.row(0)[world.cells.size() - 1], -1.0f);
  expect_changed("grid", world.grids[0][77], 0.123);
  expect_changed("scalar", world.scalars[0], -5.0);
  expect_changed("table", world.tables[0].column(1)[0], 77.0);
  expect_changed("next id", world.organisms[0].next_id, 4711u);
  expect_changed("key", world.organisms[0].key, 4711u);
  const Contacts contacts = world.contacts;
  world.contacts.reset(world.cells.size());
  EXPECT_NE(bench.simulation().hash(), before) << "contacts";
  world.contacts = contacts;
  EXPECT_EQ(bench.simulation().hash(), before);
  for (std::size_t kind = 0; kind < 3; ++kind) {
    const float kept = world.organisms[0].fields.value(kind, 20, 20);
    world.organisms[0].fields.set(kind, 20, 20, kept + 0.5f);
    EXPECT_NE(bench.simulation().hash(), before) << "morphogen " << kind;
    world.organisms[0].fields.set(kind, 20, 20, kept);
  }
  EXPECT_EQ(bench.simulation().hash(), before);
  world.tables[0].resize(world.tables[0].rows() + 1);
  EXPECT_NE(bench.simulation().hash(), before) << "rows of a table";
}

// ---- phases -------------------------------------------------------------------------------------

TEST(Phases, FollowOneAnotherAsTheModelSays) {
  std::vector<std::string> calls;
  Bench bench;
  bench.free_living();
  bench.config.mechanics.substeps = 2;
  for (const char* name : {"a", "b"}) {
    auto toy = std::make_shared<ToyEnvironment>();
    toy->on_declare = [](Declare& d) {
      for (const Phase p :
           {Phase::stress, Phase::forces, Phase::sense, Phase::fields, Phase::parameters})
        d.acts_in(p);
    };
    toy->on_begin = [&, name](World&) { calls.push_back(std::string("begin ") + name); };
    toy->on_act = [&, name](Phase phase, World&) {
      const std::array<const char*, 5> names{"fields ", "sense ", "forces ", "stress ",
                                             "parameters "};
      calls.push_back(names[static_cast<std::size_t>(phase)] + std::string(name));
    };
    bench.environments.push_back({name, toy});
  }
  bench.script = [&](const Lane&) { calls.push_back("control"); };
  bench.observe = [&](World&) {
    calls.push_back("observe");
    return false;
  };
  bench.start();
  EXPECT_EQ(calls, (std::vector<std::string>{"begin a", "begin b"}));
  const std::vector<std::string> step{
      "parameters a", "parameters b", "fields a", "fields b", "sense a",  "sense b",  "control",
      "forces a",     "forces b",     "forces a", "forces b", "stress a", "stress b", "observe"};
  for (int i = 0; i < 2; ++i) {
    calls.clear();
    bench.steps(1);
    EXPECT_EQ(calls, step);
  }
}

TEST(Phases, UndeclaredOnesAreNotCalled) {
  int calls = 0;
  Bench bench;
  bench.environments = {acting("one", Phase::stress, [&](World&) { ++calls; })};
  bench.start();
  bench.steps(3);
  EXPECT_EQ(calls, 3);
}

TEST(Phases, CellsDecideBeforeMetabolismAndMetabolismPrecedesTheCycle) {
  // A dying cell converts in its last step, before its ambrosia is given away; and a division
  // halves what metabolism left.
  Bench bench;
  bench.free_living();
  bench.states[0].skills = {{"capacity", 10}};
  bench.config.mechanics.time_step = 1e-9;
  bench.config.cycle.apoptosis_steps = bench.config.cycle.division_steps = 2;
  bench.script = [](const Lane& lane) {
    lane.out(lane.id == 0 ? "apoptosis" : "division", 1);
    if (lane.step == 1) lane.out("conversion", 0.25f);
  };
  bench.start_with({{.id = 0, .x = 0, .energy = 0, .ambrosia = 4},
                    {.id = 5, .x = 2, .energy = 0.7, .ambrosia = 1}});
  bench.cells().energy[bench.at(0)] = 1e-3;
  bench.steps(2);
  ASSERT_FALSE(bench.alive(0));
  // Cell 5: 1 - 0.25 converted, + 3 (4 - 0.999) received, both in phase order, then halved.
  EXPECT_NEAR(bench.cells().energy[bench.at(5)], 0.95 / 2, 1e-9);
  EXPECT_NEAR(bench.cells().ambrosia[bench.at(5)], (0.75 + 4 - 0.999) / 2, 1e-9);
  EXPECT_NEAR(bench.ledger().burnt.value(), 0.25 + 0.999, 1e-9);
}

TEST(Phases, WrongCallsThrow) {
  std::map<std::string, std::set<std::string>> allowed;
  const auto tried = [&](const char* phase, World& w) {
    std::array<std::int32_t, 1> met{};
    const Segment path{0, 0, 1, 0};
    const std::vector<std::pair<const char*, std::function<void()>>> calls{
        {"sensor", [&] { (void)w.sensor(0); }},
        {"force_x", [&] { (void)w.force_x(); }},
        {"force_y", [&] { (void)w.force_y(); }},
        {"first_hit", [&] { w.first_hit(std::span(&path, 1), met); }},
        {"strike", [&] { w.strike(0, 0, 0); }},
        {"kill", [&] { w.kill(1, 0); }}};
    for (const auto& [name, call] : calls) {
      try {
        call();
        allowed[name].insert(phase);
      } catch (const std::logic_error& error) {
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      }
    }
  };
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [](Declare& d) {
    for (const Phase p : {Phase::stress, Phase::forces, Phase::sense, Phase::fields}) d.acts_in(p);
    (void)d.sensor("light");
    (void)d.hazard("fire", d.skill("resistance", {}));
  };
  toy->on_begin = [&](World& w) { tried("begin", w); };
  toy->on_act = [&](Phase phase, World& w) {
    const std::array<const char*, 4> names{"fields", "sense", "forces", "stress"};
    tried(names[static_cast<std::size_t>(phase)], w);
  };
  Bench bench;
  bench.environments = {{"toy", toy}};
  bench.observe = [&](World& w) {
    tried("observe", w);
    return false;
  };
  bench.founders = {{.key = 1}, {.key = 2, .x = 20}};
  bench.start();
  bench.steps(1);
  const std::map<std::string, std::set<std::string>> expected{
      {"sensor", {"sense"}},     {"force_x", {"forces"}}, {"force_y", {"forces"}},
      {"first_hit", {"stress"}}, {"strike", {"stress"}},  {"kill", {"stress"}}};
  EXPECT_EQ(allowed, expected);
}

TEST(Phases, WrongIndicesThrow) {
  Bench bench;
  int thrown = 0, tried = 0;
  bench.environments = {acting(
      "toy", Phase::stress,
      [&](World& w) {
        const auto expect_throw = [&](auto&& call) {
          ++tried;
          try {
            call();
          } catch (const std::logic_error&) {
            ++thrown;
          }
        };
        expect_throw([&] { w.strike(1, 0, 1); });
        expect_throw([&] { w.strike(0, 7, 1); });
        expect_throw([&] { w.kill(5, 0); });
        expect_throw([&] { w.kill(0, 99); });
        expect_throw([&] { (void)w.scalar(3); });
        expect_throw([&] { (void)w.grid(3); });
        expect_throw([&] { (void)w.table(3); });
        expect_throw([&] { (void)w.cell_value(3); });
        expect_throw([&] { (void)w.rng(3, 0); });
        const std::array<Segment, 2> paths{};
        std::array<std::int32_t, 1> met{};
        expect_throw([&] { w.first_hit(paths, met); });
      },
      [](Declare& d) { (void)d.hazard("fire", d.skill("resistance", {})); })};
  bench.start();
  bench.steps(1);
  EXPECT_EQ(thrown, tried);
  EXPECT_TRUE(bench.alive(0));
}

// ---- the world as plugins see it ----------------------------------------------------------------

TEST(WorldView, KeepsWhatEnvironmentsDeclareFromStepToStep) {
  Handles h;
  std::vector<double> scalars, cells, tables;
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [&](Declare& d) {
    const std::array<std::string_view, 2> columns{"x", "y"};
    h.scalar = d.scalar("count", 10);
    h.grid = d.grid("heat",
                    {.columns = 3, .rows = 2, .side = 4, .left = -1, .bottom = 5, .initial = 0.5});
    h.table = d.table("things", columns);
    h.value = d.cell_value("age", OnDivision::copy);
    d.acts_in(Phase::fields);
    EXPECT_EQ(d.instance(), "toy");
    EXPECT_EQ(d.world().radius, 60);
    EXPECT_EQ(d.world().max_steps, 3000u);
    EXPECT_EQ(d.world().substeps, 3u);
    EXPECT_EQ(d.world().time_step, 1.0 / 30);
  };
  toy->on_act = [&](Phase, World& w) {
    w.scalar(h.scalar) += 1;
    const Grid grid = w.grid(h.grid);
    ASSERT_EQ(grid.values.size(), 6u);
    grid.values[4] += 1;
    Table& table = w.table(h.table);
    table.resize(table.rows() + 1);
    ASSERT_EQ(table.column(1).size(), table.rows());
    EXPECT_EQ(table.column(1).back(), 0) << "new rows are zero";
    table.column(1).back() = static_cast<double>(w.step()) + 0.5;
    w.cell_value(h.value)[0] += 2;
    scalars.push_back(w.scalar(h.scalar));
    cells.push_back(w.cell_value(h.value)[0]);
    tables.push_back(table.column(1)[0]);
  };
  Bench bench;
  bench.environments = {{"toy", toy}};
  bench.start();
  bench.steps(3);
  EXPECT_EQ(scalars, (std::vector<double>{11, 12, 13}));
  EXPECT_EQ(cells, (std::vector<double>{2, 4, 6}));
  EXPECT_EQ(tables, (std::vector<double>{0.5, 0.5, 0.5}));
  EXPECT_EQ(bench.world().tables[h.table].rows(), 3u);
  EXPECT_EQ(bench.world().grids[h.grid], (std::vector<double>{0.5, 0.5, 0.5, 0.5, 3.5, 0.5}));
}

TEST(WorldView, ShowsCellsAndTheirSkillsByState) {
  Bench bench;
  bench.free_living();
  bench.states = {{.name = "a", .skills = {{"warmth", 3}}}, {.name = "b", .parent = 0}};
  Id warmth = no_id;
  int calls = 0;
  bench.environments = {acting(
      "toy", Phase::fields,
      [&](World& w) {
        ++calls;
        ASSERT_EQ(w.cells().count, 3u);
        for (std::uint32_t i = 0; i < 3; ++i) {
          const bool first_state = w.cells().id[i] != 4;
          EXPECT_EQ(w.skill(warmth)[i], first_state ? 3 : 0.25);
          EXPECT_EQ(w.cells().state[i], first_state ? 0 : 1);
          EXPECT_EQ(w.cells().x[i], 10.0 * static_cast<double>(w.cells().id[i]));
          EXPECT_EQ(w.cells().dead[i], 0);
        }
      },
      [&](Declare& d) { warmth = d.skill("warmth", {.fallback = 0.25}); })};
  bench.start_with({{.id = 4, .x = 40, .state = 1}, {.id = 2, .x = 20}, {.id = 5, .x = 50}});
  bench.steps(1);
  EXPECT_EQ(calls, 1);
}

TEST(WorldView, RandomStreamsGoBySeedStepPurposeAndEntity) {
  const auto draws = [](std::uint64_t seed) {
    std::vector<std::uint64_t> all;
    std::array<Id, 2> purposes{};
    Bench bench;
    bench.seed = seed;
    bench.environments = {acting(
        "toy", Phase::fields,
        [&](World& w) {
          for (const Id purpose : purposes)
            for (std::uint64_t entity = 0; entity < 3; ++entity) {
              all.push_back(w.rng(purpose, entity).bits());
              EXPECT_EQ(w.rng(purpose, entity).bits(), all.back()) << "asking again starts again";
            }
        },
        [&](Declare& d) {
          purposes = {d.purpose("one"), d.purpose("two")};
        })};
    bench.start();
    bench.steps(2);
    return all;
  };
  const auto first = draws(1);
  EXPECT_EQ(first, draws(1));
  std::set<std::uint64_t> all(first.begin(), first.end());
  for (const std::uint64_t bits : draws(2)) all.insert(bits);
  EXPECT_EQ(all.size(), 24u) << "all different";
}

TEST(Inputs, CarryWhatTheCellSenses) {
  Bench bench;
  bench.free_living();
  bench.forceless();
  bench.states[0].skills = {{"capacity", 8}};
  bench.states.push_back({.name = "bare", .parent = 0});
  Id light = no_id;
  bench.environments = {acting(
      "toy", Phase::sense,
      [&](World& w) {
        for (std::uint32_t i = 0; i < w.cells().count; ++i)
          w.sensor(light)[i] = 0.125f * static_cast<float>(w.cells().id[i]);
      },
      [&](Declare& d) {
        (void)d.sensor("dark");
        light = d.sensor("light");
      })};
  int seen = 0;
  bench.script = [&](const Lane& lane) {
    ++seen;
    EXPECT_EQ(lane.in("energy"), lane.id == 1 ? 0.75f : 1.0f);
    EXPECT_EQ(lane.in("ambrosia"), lane.id == 1 ? 0.25f : 0.0f) << "content / capacity, or 0";
    EXPECT_EQ(lane.in("pressure"), lane.id == 1 ? 0.375f : 0.0f);
    EXPECT_EQ(lane.in("light"), 0.125f * static_cast<float>(lane.id));
    EXPECT_EQ(lane.in("dark"), 0.0f) << "what nobody fills is 0";
  };
  bench.start_with({{.id = 1, .energy = 0.75, .ambrosia = 2}, {.id = 2, .x = 20, .state = 1}});
  bench.cells().pressure[bench.at(1)] = 0.375;
  bench.steps(1);
  EXPECT_EQ(seen, 2);
}

// ---- control ------------------------------------------------------------------------------------

TEST(Control, GivesEachStatesBatchItsOwnLanesOnly) {
  Bench bench;
  bench.free_living();
  bench.forceless();
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.states = {{.name = "a"}, {.name = "b", .parent = 0}, {.name = "c", .parent = 0}};
  bench.forceless();
  bench.memory_rows = 1;
  std::map<std::pair<int, int>, std::vector<float>> lanes;  // by organism and state: the ids
  bench.script = [&](const Lane& lane) {
    lanes[{lane.organism(), lane.state()}].push_back(lane.memory(0));
    EXPECT_EQ(lane.memory(0), static_cast<float>(lane.id));
    EXPECT_EQ(lane.in("energy"), static_cast<float>(1.0 / (1.0 + static_cast<double>(lane.id))));
    EXPECT_EQ(lane.batch.in.channels, lane.layout.input_channels);
    EXPECT_EQ(lane.batch.out.channels, lane.layout.outputs.size());
    EXPECT_EQ(lane.batch.memory.channels, 1u);
    EXPECT_EQ(lane.batch.in.lanes, lane.batch.count);
    EXPECT_EQ(lane.batch.out.lanes, lane.batch.count);
    lane.out("morphogen.0", 0.001f * static_cast<float>(lane.id));
  };
  std::vector<Placed> cells;
  for (std::uint64_t id = 0; id < 12; ++id)
    cells.push_back({.id = id,
                     .x = 4.0 * static_cast<double>(id) - 24,
                     .state = static_cast<std::uint16_t>(id % 3),
                     .energy = 1.0 / (1.0 + double(id)),
                     .organism = static_cast<std::uint16_t>(id / 6)});
  bench.start_with(cells);
  for (std::uint32_t i = 0; i < 12; ++i)
    bench.cells().memory.row(0)[i] = static_cast<float>(bench.cells().id[i]);
  bench.steps(1);
  const std::map<std::pair<int, int>, std::vector<float>> expected{
      {{0, 0}, {0, 3}}, {{0, 1}, {1, 4}},  {{0, 2}, {2, 5}},
      {{1, 0}, {6, 9}}, {{1, 1}, {7, 10}}, {{1, 2}, {8, 11}}};
  EXPECT_EQ(lanes, expected);
  for (std::uint64_t id = 0; id < 12; ++id)
    EXPECT_NEAR(bench.world().organisms[id / 6].fields.value(
                    0, static_cast<std::uint32_t>(20 + 2 * id), 32),
                0.001 * static_cast<double>(id), 1e-7)
        << "and each lane's outputs reach its own cell";
}

/// Counts its calls in memory; `start` sets a mark.
class CountingProgram final : public Program {
 public:
  [[nodiscard]] std::uint32_t memory_per_cell() const override { return 3; }
  void start(const Batch& batch) const override {
    for (std::uint32_t lane = 0; lane < batch.count; ++lane) {
      EXPECT_EQ(batch.memory.channel(0)[lane], 0) << "zeroed, and before any step";
      batch.memory.channel(1)[lane] += 1;
    }
  }
  void step(const Batch& batch) const override {
    for (std::uint32_t c = 0; c < batch.out.channels; ++c)
      for (float& value : batch.out.channel(c)) value = 0;
    for (std::uint32_t lane = 0; lane < batch.count; ++lane) {
      batch.memory.channel(0)[lane] += 1;
      batch.memory.channel(2)[lane] += batch.in.channel(4)[lane];  // energy
      batch.out.channel(1)[lane] = 1;                              // division
    }
  }
};

class CountingController final : public Controller {
 public:
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView, const Layout& layout) const override {
    EXPECT_EQ(layout.inputs[4].name, "root/energy");
    EXPECT_EQ(layout.outputs[1].name, "division");
    return std::make_unique<CountingProgram>();
  }

 private:
  NoGenes genes_;
};

TEST(Control, WarmsTheFounderUpForTwentyFiveStepsOnItsFirstInputs) {
  Bench bench;
  bench.config.warm_up_steps = Config{}.warm_up_steps;
  bench.config.cycle.division_steps = 2;
  bench.config.metabolism.division_cost = 0.25;
  bench.controller = std::make_shared<CountingController>();
  bench.start();
  EXPECT_EQ(bench.cells().memory.row(0)[0], 0);
  bench.steps(1);
  EXPECT_EQ(bench.cells().memory.row(0)[0], 26) << "25, and step 0's ordinary one";
  EXPECT_EQ(bench.cells().memory.row(1)[0], 1) << "started once";
  EXPECT_EQ(bench.cells().memory.row(2)[0], 26) << "always at the energy of step 0";
  bench.steps(3);
  ASSERT_TRUE(bench.alive(1));
  for (const std::uint64_t id : {0u, 1u}) {
    EXPECT_EQ(bench.cells().memory.row(0)[bench.at(id)], 29) << "daughters are not warmed up";
    EXPECT_EQ(bench.cells().memory.row(1)[bench.at(id)], 1);
  }
}

// ---- failures -----------------------------------------------------------------------------------

/// The failure of a run of three steps, if any.
std::optional<PluginFailure> failure_of(Bench& bench) {
  try {
    bench.start();
    bench.steps(3);
  } catch (const PluginFailure& failure) {
    return failure;
  }
  return {};
}

TEST(Failure, NamesInstanceCallAndStepOfAnEnvironment) {
  const std::array<std::pair<Phase, const char*>, 5> phases{
      {{Phase::parameters, "act(parameters) at step 2"},
       {Phase::fields, "act(fields) at step 2"},
       {Phase::sense, "act(sense) at step 2"},
       {Phase::forces, "act(forces) at step 2"},
       {Phase::stress, "act(stress) at step 2"}}};
  for (const auto& [phase, call] : phases) {
    Bench bench;
    bench.environments = {acting("quiet", phase, [](World&) {}),
                          acting("rogue", phase, [](World& w) {
                            if (w.step() == 2) throw std::runtime_error("out of juice");
                          })};
    const auto failure = failure_of(bench);
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->instance(), "rogue");
    EXPECT_EQ(failure->call(), call);
    EXPECT_EQ(failure->what(), std::string("rogue: ") + call + ": out of juice");
  }
}

TEST(Failure, InBeginNamesIt) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_begin = [](World&) { throw std::runtime_error("no fuel"); };
  Bench bench;
  bench.environments = {{"rogue", toy}};
  const auto failure = failure_of(bench);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->instance(), "rogue");
  EXPECT_NE(std::string(failure->what()).find("begin"), std::string::npos);
  EXPECT_NE(std::string(failure->what()).find("no fuel"), std::string::npos);
}

TEST(Failure, OfASensorThatIsNoNumberIsTold) {
  auto toy = std::make_shared<ToyEnvironment>();
  auto sensor = std::make_shared<Id>();
  toy->on_declare = [=](Declare& d) {
    d.acts_in(Phase::sense);
    *sensor = d.sensor("light");
  };
  toy->on_act = [=](Phase, World& w) {
    if (w.step() == 2) w.sensor(*sensor)[0] = std::numeric_limits<float>::quiet_NaN();
  };
  Bench bench;
  bench.environments = {{"lamp", toy}};
  const auto failure = failure_of(bench);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->call(), "act(sense) at step 2");
  EXPECT_NE(std::string(failure->what()).find("'light'"), std::string::npos);
}

TEST(Failure, OfSomethingThatIsNoExceptionIsNamedToo) {
  Bench bench;
  bench.environments = {acting("rogue", Phase::fields, [](World&) { throw 42; })};
  const auto failure = failure_of(bench);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->instance(), "rogue");
  EXPECT_EQ(failure->call(), "act(fields) at step 0");
}

TEST(Failure, OfAFitnessNamesIt) {
  Bench bench;
  bench.observe = [](World& w) -> bool {
    if (w.step() == 1) throw std::runtime_error("bad day");
    return false;
  };
  const auto failure = failure_of(bench);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->instance(), "fitness");
  EXPECT_EQ(failure->call(), "observe at step 1");
}

TEST(Failure, OfAControllersProgramNamesIt) {
  Bench bench;
  bench.script = [](const Lane& lane) {
    if (lane.step == 1) throw std::runtime_error("bad genes");
  };
  std::optional<PluginFailure> failure;
  try {
    failure = failure_of(bench);
  } catch (const std::exception& error) {
    FAIL() << "left as a bare '" << error.what() << "'";
  }
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->instance(), "controller");
  EXPECT_NE(failure->call().find("step 1"), std::string::npos) << failure->call();
}

TEST(Roster, RefusesNobodyAndRepeatedKeys) {
  Bench bench;
  bench.start();
  EXPECT_THROW(Simulation(bench.ecosystem(), {}, 1), std::invalid_argument);
  const std::array<RosterEntry, 2> twins{RosterEntry{&bench.phenotype(0), 4, 0, 0},
                                         RosterEntry{&bench.phenotype(0), 4, 9, 0}};
  EXPECT_THROW(Simulation(bench.ecosystem(), twins, 1), std::invalid_argument);
}

TEST(Roster, FoundersAppearWhereItSays) {
  Bench bench;
  bench.founders = {{.key = 9, .x = 3, .y = -4}, {.key = 2, .x = -7, .y = 5}};
  bench.start();
  ASSERT_EQ(bench.cells().size(), 2u);
  EXPECT_EQ(bench.cells().x[bench.at(0, 0)], -7) << "organisms go by ascending key";
  EXPECT_EQ(bench.cells().y[bench.at(0, 1)], -4);
  EXPECT_EQ(bench.world().organisms[0].roster_index, 1u);
}

TEST(Roster, CensusCountsByState) {
  Bench bench;
  bench.founders = {{.key = 9}, {.key = 2}};
  bench.states = {{.name = "a"}, {.name = "b", .parent = 0}, {.name = "c", .parent = 0}};
  bench.start_with({{.id = 0, .x = 0, .state = 0, .organism = 0},
                    {.id = 1, .x = 5, .state = 2, .organism = 0},
                    {.id = 2, .x = 10, .state = 2, .organism = 0},
                    {.id = 0, .x = 15, .state = 1, .organism = 1}});
  EXPECT_EQ(bench.simulation().census(1), (std::vector<std::uint32_t>{1, 0, 2}));
  EXPECT_EQ(bench.simulation().census(0), (std::vector<std::uint32_t>{0, 1, 0}));
}

TEST(Run, StopsWhenAskedAndResumes) {
  Bench bench;
  bench.free_living();
  bench.config.max_steps = 10;
  bench.start();
  int asked = 0;
  EXPECT_FALSE(bench.simulation().run([&] { return ++asked > 4; }));
  EXPECT_EQ(bench.simulation().steps_done(), 4u);
  EXPECT_FALSE(bench.simulation().finished());
  EXPECT_TRUE(bench.simulation().run());
  EXPECT_EQ(bench.simulation().steps_done(), 10u);
}

// ---- allocations --------------------------------------------------------------------------------
TEST(Run, GoesOnFromWhateverCellsAreLeftByHand) {
  // Fewer, more and other cells than mechanics knew: as if the world had begun with them.
  Dice dice(5);
  Bench used;
  used.free_living();
  std::vector<Placed> cells;
  used.start();
  for (const std::size_t count : {60u, 5u, 80u, 80u, 1u}) {
    cells.clear();
    for (std::uint64_t id = 0; id < count; ++id)
      cells.push_back({.id = id, .x = dice.uniform(-5, 5), .y = dice.uniform(-5, 5)});
    used.replace(cells);
    Bench fresh;
    fresh.free_living();
    fresh.start_with(cells);
    for (int step = 0; step < 4; ++step) {
      used.steps(1);
      fresh.steps(1);
      ASSERT_EQ(used.cells().x, fresh.cells().x) << count;
      ASSERT_EQ(used.cells().pressure, fresh.cells().pressure);
      ASSERT_EQ(used.world().contacts.items, fresh.world().contacts.items);
    }
  }
}

// ---------------------------------------------------------------------------------

void expect_no_allocation(Team* team) {
  // Warm: these very steps have been taken before, so every buffer has seen its greatest size.
  Bench bench;
  const Busy busy;
  busy.set_up(bench);
  bench.start().use(team);
  bench.steps(300);
  const WorldState saved = bench.world();
  const auto go_back = [&] {
    bench.world() = saved;
    bench.simulation().restructured();
    bench.world().contacts = saved.contacts;
  };
  go_back();
  bench.steps(300);
  ASSERT_FALSE(bench.simulation().finished());
  const std::uint64_t hash = bench.simulation().hash();

  go_back();
  allocations = 0;
  counting = true;
  for (int i = 0; i < 300; ++i) bench.simulation().step();
  counting = false;
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(bench.simulation().hash(), hash) << "the state is all that the steps depend on";
  const OrganismState& now = bench.world().organisms[0];
  EXPECT_GT(now.outcome.divisions, saved.organisms[0].outcome.divisions + 100) << "cells were born";
  for (std::size_t cause = 0; cause < now.deaths.size(); ++cause)
    EXPECT_GT(now.deaths[cause], saved.organisms[0].deaths[cause]) << "and died, cause " << cause;

  allocations = 0;
  counting = true;
  void* something = ::operator new(100);  // a call, which a compiler may not leave out
  counting = false;
  ::operator delete(something);
  EXPECT_EQ(allocations, 1u) << "the counter counts";
}

TEST(Allocation, DoesNotHappenInAStepOnceWarm) { expect_no_allocation(nullptr); }

TEST(Allocation, DoesNotHappenWithWorldThreadsOnceWarm) {
  Team team(3, 1);
  expect_no_allocation(&team);
}

}  // namespace
}  // namespace somas::model::test
