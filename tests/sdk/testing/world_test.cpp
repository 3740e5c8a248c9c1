// The reference host itself: its rules, its script, and that its saved bytes are all there is.
#include "somas/sdk/testing/world.hpp"

#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

const WorldInfo info{.radius = 60, .max_steps = 100, .substeps = 2, .time_step = 0.05};

/// Does nothing but what a test tells it.
class Puppet final : public Environment {
 public:
  void declare(Declare&) override {}
  void act(Phase phase, World& world) const override { on_act(phase, world); }
  std::function<void(Phase, World&)> on_act = [](Phase, World&) {};
};

/// A world with one of everything, in which `puppet` acts in all phases.
std::unique_ptr<TestWorld> stage(const Puppet& puppet, Script script = {}) {
  Declared declared;
  TestDeclare d(declared, info, "it");
  for (const Phase phase :
       {Phase::parameters, Phase::fields, Phase::sense, Phase::forces, Phase::stress})
    d.acts_in(phase);
  const Id skill = d.skill("production", {});
  const Id grid = d.grid(
      "food", {.columns = 2, .rows = 2, .side = 40, .left = -40, .bottom = -40, .initial = 5});
  static_cast<void>(d.resource("food", grid, skill));
  static_cast<void>(d.hazard("fire", d.skill("hide", {.fallback = 1})));
  static_cast<void>(d.cell_value("dose", OnDivision::halve));
  static_cast<void>(d.cell_value("mark", OnDivision::copy));
  static_cast<void>(d.cell_value("age", OnDivision::zero));
  static_cast<void>(d.sensor("smell"));
  static_cast<void>(d.parameter("heat", {.value = 4, .minimum = 3}));
  return std::make_unique<TestWorld>(info, declared, 1, std::move(script),
                                     std::vector<TestActor>{{"it", &puppet}});
}

Script quiet(std::vector<TestCell> cells) {
  Script script;
  script.founders = std::move(cells);
  script.birth_every = script.death_every = 0;
  return script;
}

TEST(TestWorld, CallsThePhasesInTheHostsOrder) {
  Puppet puppet;
  std::vector<Phase> phases;
  puppet.on_act = [&](Phase phase, World&) { phases.push_back(phase); };
  const auto world = stage(puppet);
  world->begin();
  world->advance();
  EXPECT_THAT(phases, ::testing::ElementsAre(Phase::parameters, Phase::fields, Phase::sense,
                                             Phase::forces, Phase::forces, Phase::stress));
}

TEST(TestWorld, BeginsOnceAndFirst) {
  const Puppet puppet;
  const auto world = stage(puppet);
  EXPECT_THROW(world->advance(), std::logic_error);
  world->begin();
  EXPECT_THROW(world->begin(), std::logic_error);
}

TEST(TestWorld, CellsAreBornMoveAndDie) {
  const Puppet puppet;
  const auto world = stage(puppet);
  world->begin();
  const std::uint64_t newest = world->test_cells().back().id;
  const double x = world->test_cells()[0].x;
  world->advance();
  EXPECT_EQ(world->test_cells().size(), 17u);
  EXPECT_EQ(world->test_cells().back().id, newest + 1);
  EXPECT_NE(world->test_cells()[0].x, x);
  while (world->step() < 7) world->advance();
  EXPECT_EQ(world->test_cells().size(), 17u);  // two were born, one has died
}

TEST(TestWorld, ChildrenInheritCellValuesByTheirRule) {
  Puppet puppet;
  puppet.on_act = [](Phase phase, World& world) {
    for (const Id value : {0, 1, 2})
      if (phase == Phase::sense) world.cell_value(value)[0] = 8;
  };
  Script script = quiet({{.id = 1}});
  script.birth_every = 1;
  const auto world = stage(puppet, script);
  world->begin();
  world->advance();
  ASSERT_EQ(world->test_cells().size(), 2u);
  EXPECT_THAT(world->test_cells()[0].values, ::testing::ElementsAre(4, 8, 8));
  EXPECT_THAT(world->test_cells()[1].values, ::testing::ElementsAre(4, 8, 0));
}

TEST(TestWorld, WhatCellsEatLeavesTheGrid) {
  const Puppet puppet;
  const auto world = stage(puppet);
  world->begin();
  for (int i = 0; i < 5; ++i) world->advance();
  double left = 0;
  for (const double content : world->grid("it", "food").values) left += content;
  EXPECT_GT(world->eaten()[0], 1);
  EXPECT_NEAR(left + world->eaten()[0], 20, 1e-9);
}

TEST(TestWorld, ACellDiesOfWhatExceedsItsResistance) {
  Puppet puppet;
  puppet.on_act = [](Phase phase, World& world) {
    if (phase == Phase::stress) world.strike(0, 0, 0.6);
  };
  const auto world = stage(puppet, quiet({{.id = 1}, {.id = 2, .x = 5}}));
  world->begin();
  world->advance();
  EXPECT_EQ(world->test_cells().size(), 2u);  // 0.6 of 1
  world->advance();
  ASSERT_EQ(world->test_cells().size(), 1u);  // 1.2 of 1
  EXPECT_EQ(world->test_cells()[0].id, 2u);
}

TEST(TestWorld, TheFirstCellOnAPathIsHit) {
  Puppet puppet;
  std::int32_t hits[3];
  puppet.on_act = [&](Phase phase, World& world) {
    const Segment paths[] = {{-5, 0, 50, 0}, {-5, 0, -3, 0}, {50, 0, -5, 0}};
    if (phase == Phase::stress) world.first_hit(paths, hits);
  };
  const auto world = stage(puppet, quiet({{.id = 2, .x = 20}, {.id = 1, .x = 10}}));
  world->begin();
  world->advance();
  EXPECT_THAT(hits, ::testing::ElementsAre(1, -1, 0));
}

TEST(TestWorld, ForcesMoveCells) {
  Puppet puppet;
  puppet.on_act = [](Phase phase, World& world) {
    if (phase == Phase::forces) world.force_y()[0] += 10;
  };
  const auto world = stage(puppet, quiet({{.id = 1}}));
  world->begin();
  world->advance();
  // v = 0.5, then 1: y = 0.05 (0.5 + 1)
  EXPECT_DOUBLE_EQ(world->test_cells()[0].y, 0.075);
}

TEST(TestWorld, VariesParametersThatNobodyHasInCharge) {
  const Puppet puppet;
  const auto world = stage(puppet);
  world->begin();
  world->advance();
  EXPECT_EQ(world->parameter(0), 4);
  while (world->step() < 11) world->advance();
  EXPECT_EQ(world->parameter(0), 3);  // half of it is below its minimum
}

TEST(TestWorld, SavedBytesRestoreTheWorldAndNoOther) {
  const Puppet puppet;
  const auto world = stage(puppet), other = stage(puppet);
  world->begin();
  for (int i = 0; i < 9; ++i) world->advance();
  other->restore(world->save());
  EXPECT_EQ(other->save(), world->save());
  world->advance();
  EXPECT_NE(other->save(), world->save());
  other->advance();
  EXPECT_EQ(other->save(), world->save());
  EXPECT_EQ(other->marks(), world->marks());

  Bytes cut = world->save();
  cut.pop_back();
  EXPECT_THROW(other->restore(cut), std::runtime_error);
  TestWorld empty(info, Declared{}, 1, {}, {});
  EXPECT_THROW(empty.restore(world->save()), std::runtime_error);
}

TEST(TestWorld, AnotherStorageOrderIsTheSameWorld) {
  const Puppet puppet;
  Script shuffled;
  shuffled.shuffle = 1;
  const auto world = stage(puppet), other = stage(puppet, shuffled);
  world->begin();
  other->begin();
  bool moved = false;
  for (int i = 0; i < 20; ++i) {
    world->advance();
    other->advance();
    EXPECT_EQ(other->marks(), world->marks());
    moved = moved || other->test_cells()[0].id != world->test_cells()[0].id;
  }
  EXPECT_TRUE(moved);
}

TEST(TestDeclare, RefusesWhatTheHostRefuses) {
  Declared declared;
  TestDeclare d(declared, info, "it");
  static_cast<void>(d.skill("claw", {.cost = 2}));
  EXPECT_EQ(d.skill("claw", {.cost = 2}), 3u);  // the model's three come first
  EXPECT_THROW(static_cast<void>(d.skill("claw", {.cost = 3})), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.sensor("pressure")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.grid("g", {})), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.cause("starvation")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.hazard("h", 77)), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.resource("r", 77, 3)), std::runtime_error);
  EXPECT_THROW(static_cast<void>(d.parameter("p", {.value = 1, .minimum = 2})), std::runtime_error);
  const Point point[] = {{0, 0}};
  EXPECT_THROW(d.outline("o", point, false), std::runtime_error);
}

TEST(TestConnections, GiveAParameterToOneInstance) {
  Declared declared;
  TestDeclare d(declared, info, "river");
  static_cast<void>(d.parameter("flow", {.value = 2}));
  TestConnections first(declared, "tap"), second(declared, "dam");
  EXPECT_EQ(first.vary("river", "flow").spec.value, 2);
  EXPECT_THROW(static_cast<void>(second.vary("river", "flow")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(second.vary("river", "depth")), std::runtime_error);
}

}  // namespace
}  // namespace somas::testing
