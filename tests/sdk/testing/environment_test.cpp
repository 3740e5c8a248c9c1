// Toys with one fault each, which check_environment must find, and an honest one.
#include "somas/sdk/testing/environment.hpp"

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Uses everything that a world offers, within the rules; faults are built in by deriving.
class Honest : public Environment {
 public:
  struct Parameters {};
  explicit Honest(const Parameters& = {}) {}

  void declare(Declare& d) override {
    const Id skill = d.skill("grazing", {});
    grid_ = d.grid("grass", {.columns = 20, .rows = 20, .side = 2, .left = -20, .bottom = -20});
    d.resource("grass", grid_, skill);
    sensor_ = d.sensor("grass");
    scalar_ = d.scalar("rain", 0.25);
    value_ = d.cell_value("age", OnDivision::zero);
    constexpr std::string_view columns[] = {"x", "y"};
    table_ = d.table("stones", columns);
    hazard_ = d.hazard("stone", d.skill("shell", {.fallback = 2}));
    purpose_ = d.purpose("stones");
    growth_ = d.parameter("growth", {.value = 0.1, .minimum = 0, .maximum = 1});
    for (const Phase phase : {Phase::fields, Phase::sense, Phase::forces, Phase::stress})
      d.acts_in(phase);
  }
  void begin(World& world) const override {
    for (double& grass : world.grid(grid_).values) grass = 1;
  }
  void act(Phase phase, World& world) const override {
    if (phase == Phase::fields) grow(world, world.parameter(growth_));
    if (phase == Phase::sense) sense(world, 0);
    if (phase == Phase::forces) push(world);
    if (phase == Phase::stress) throw_stones(world, 3);
  }

 protected:
  void grow(World& world, double growth) const {
    double& rain = world.scalar(scalar_);
    rain = 1 - rain;
    for (double& grass : world.grid(grid_).values) grass += growth * rain;
  }
  void sense(World& world, float offset) const {
    const Grid grid = world.grid(grid_);
    const std::span<float> sensed = world.sensor(sensor_);
    for (std::uint32_t i = 0; i < world.cells().count; ++i) {
      const std::int64_t square = grid.index_of(world.cells().x[i], world.cells().y[i]);
      sensed[i] = square < 0 ? 0 : static_cast<float>(grid.values[square]) + offset;
      world.cell_value(value_)[i] += 1;
    }
  }
  static void push(World& world) {
    for (std::uint32_t i = 0; i < world.cells().count; ++i) {
      world.force_x()[i] -= 0.5 * world.cells().x[i];
      world.force_y()[i] -= 0.5 * world.cells().y[i];
    }
  }
  void throw_stones(World& world, std::uint32_t count) const {
    Table& table = world.table(table_);
    table.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      Rng rng = world.rng(purpose_, i);
      const double x = rng.uniform(-12, 12), y = rng.uniform(-12, 12);
      const Segment path{x, y, x + 2, y};
      std::int32_t hit = -1;
      world.first_hit({&path, 1}, {&hit, 1});
      if (hit >= 0) world.strike(static_cast<std::uint32_t>(hit), hazard_, 1);
      table.column(0)[i] = x;
      table.column(1)[i] = y;
    }
  }

  Id grid_ = no_id, sensor_ = no_id, scalar_ = no_id, value_ = no_id, table_ = no_id;
  Id hazard_ = no_id, purpose_ = no_id, growth_ = no_id;
};

TEST(CheckEnvironment, FindsNothingInAnHonestOne) {
  EXPECT_THAT(check_environment<Honest>(), IsEmpty());
}

/// What is found in an environment that does `instead` in one phase and is honest in the others.
class Instead final : public Honest {
 public:
  using Act = std::function<void(const Instead&, World&)>;
  struct Parameters {
    Phase phase;
    Act act;
  };
  explicit Instead(const Parameters& p) : p_(p) {}
  void act(Phase phase, World& world) const override {
    if (phase == p_.phase)
      p_.act(*this, world);
    else
      Honest::act(phase, world);
  }
  using Honest::grid_, Honest::grow, Honest::push, Honest::sense, Honest::sensor_, Honest::scalar_,
      Honest::table_, Honest::throw_stones, Honest::value_;
  mutable std::atomic<int> calls = 0;  // atomic, so that the threads' check is no data race

 private:
  Parameters p_;
};

Failures found(Phase phase, Instead::Act act) {
  return check_environment<Instead>({phase, std::move(act)});
}

TEST(CheckEnvironment, FindsAStaticCounter) {
  static std::atomic<int> calls;
  const Failures failures = found(Phase::sense, [](const Instead& it, World& world) {
    it.sense(world, static_cast<float>(++calls));
  });
  EXPECT_THAT(failures, Contains(HasSubstr("a second instance, the same seed: sensor 'grass' "
                                           "differs in step 0")));
  EXPECT_THAT(failures, Contains(HasSubstr("two instances in turns")));
}

TEST(CheckEnvironment, FindsStateInAMutableMember) {
  const Failures failures = found(Phase::sense, [](const Instead& it, World& world) {
    it.sense(world, static_cast<float>(++it.calls));
  });
  EXPECT_THAT(failures, Contains(HasSubstr("a second simulation of one instance: sensor")));
  EXPECT_THAT(failures, Contains(HasSubstr("one instance serving two worlds in turns: sensor")));
  EXPECT_THAT(failures, Contains(HasSubstr("one instance on several threads: sensor")));
  EXPECT_THAT(failures, Contains(HasSubstr("saved before step 20, restored to a new instance: "
                                           "sensor 'grass' differs in step 20")));
  // Fresh instances agree, so nothing else is wrong.
  EXPECT_THAT(failures, Not(Contains(HasSubstr("two instances in turns"))));
  EXPECT_THAT(failures, Not(Contains(HasSubstr("storage order"))));
}

/// Starts anew with every world, so that only serving another meanwhile, or a restored world,
/// shows.
class Forgetful final : public Honest {
 public:
  void begin(World& world) const override {
    Honest::begin(world);
    age = 0;
  }
  void act(Phase phase, World& world) const override {
    if (phase != Phase::sense) return Honest::act(phase, world);
    sense(world, static_cast<float>(++age));
  }
  static thread_local int age;
  using Honest::Honest;
};
thread_local int Forgetful::age = 0;

TEST(CheckEnvironment, FindsStateInAThreadLocal) {
  const Failures failures = check_environment<Forgetful>();
  EXPECT_THAT(failures, Not(Contains(HasSubstr("a second simulation of one instance"))));
  EXPECT_THAT(failures, Contains(HasSubstr("two instances in turns: sensor")));
  EXPECT_THAT(failures, Contains(HasSubstr("one instance serving two worlds in turns: sensor")));
  EXPECT_THAT(failures, Contains(HasSubstr("restored to a new instance: sensor")));
}

TEST(CheckEnvironment, FindsStorageOrderInASum) {
  const Failures failures = found(Phase::fields, [](const Instead& it, World& world) {
    double sum = 0;
    for (const double x : world.cells().x) sum += x;
    world.scalar(it.scalar_) = sum;
  });
  EXPECT_THAT(failures, Contains(HasSubstr("another storage order of the cells: scalar 'rain'")));
  EXPECT_THAT(failures, Each(HasSubstr("another storage order")));
}

TEST(CheckEnvironment, FindsCellsNamedByTheirPlace) {
  EXPECT_THAT(found(Phase::sense,
                    [](const Instead& it, World& world) {
                      const std::span<float> sensed = world.sensor(it.sensor_);
                      for (std::size_t i = 0; i < sensed.size(); ++i)
                        sensed[i] = static_cast<float>(i);
                    }),
              Contains(HasSubstr("another storage order of the cells: sensor 'grass'")));
}

TEST(CheckEnvironment, FindsNumbersThatAreNone) {
  EXPECT_THAT(
      found(Phase::sense, [](const Instead& it, World& world) { it.sense(world, std::nanf("")); }),
      Contains(HasSubstr("step 0: the sensor 'grass' is no finite number")));
  EXPECT_THAT(found(Phase::forces,
                    [](const Instead&, World& world) {
                      for (double& f : world.force_x()) f += HUGE_VAL;
                    }),
              Contains(HasSubstr("step 0: a force is not a finite number")));
  EXPECT_THAT(
      found(Phase::fields, [](const Instead& it, World& world) { it.grow(world, HUGE_VAL); }),
      Contains(HasSubstr("after act(fields) the grid 'grass' holds")));
  EXPECT_THAT(found(Phase::fields, [](const Instead& it, World& world) { it.grow(world, -9); }),
              Contains(AllOf(HasSubstr("the grid 'grass' holds -"),
                             HasSubstr("yet cells take up from it"))));
}

TEST(CheckEnvironment, FindsForcesThatReplaceThoseOfOthers) {
  const Failures failures = found(Phase::forces, [](const Instead&, World& world) {
    for (double& f : world.force_x()) f = 0.5;
  });
  EXPECT_THAT(failures,
              ::testing::ElementsAre("act(forces): step 0: forces that are in place already are "
                                     "not added to"));
}

TEST(CheckEnvironment, FindsCallsInTheWrongPhase) {
  EXPECT_THAT(found(Phase::fields,
                    [](const Instead& it, World& world) { world.sensor(it.sensor_)[0] = 1; }),
              Contains(HasSubstr("step 0: sensor belongs in act(sense)")));
  EXPECT_THAT(found(Phase::sense, [](const Instead&, World& world) { world.kill(0, 0); }),
              Contains(HasSubstr("step 0: kill belongs in act(stress)")));
  EXPECT_THAT(found(Phase::stress, [](const Instead&, World& world) { world.force_x()[0] = 1; }),
              Contains(HasSubstr("step 0: force_x belongs in act(forces)")));
}

TEST(CheckEnvironment, FindsWhatBelongsToOthers) {
  EXPECT_THAT(found(Phase::fields, [](const Instead&, World& world) { world.scalar(0) = 1; }),
              Contains(HasSubstr("the scalar 'scalar' belongs to the instance 'other_instance'")));
  EXPECT_THAT(
      found(Phase::fields, [](const Instead&, World& world) { world.grid(0).values[0] = 1; }),
      Contains(HasSubstr("the grid 'grid' belongs to the instance 'other_instance'")));
}

/// Declares under another name each time.
class Fickle final : public Honest {
 public:
  using Honest::Honest;
  void declare(Declare& d) override {
    Honest::declare(d);
    static int times = 0;
    static_cast<void>(d.scalar("scalar_" + std::to_string(times++ % 2), 0));
  }
};

TEST(CheckEnvironment, FindsDeclarationsThatDiffer) {
  EXPECT_THAT(check_environment<Fickle>(),
              ::testing::ElementsAre("declare: a second instance declares 'scalar it scalar_1 0', "
                                     "not 'scalar it scalar_0 0'"));
}

TEST(CheckEnvironment, ReportsWhatDeclareThrows) {
  class Twice final : public Honest {
   public:
    using Honest::Honest;
    void declare(Declare& d) override {
      Honest::declare(d);
      static_cast<void>(d.scalar("rain", 1));
    }
  };
  EXPECT_THAT(check_environment<Twice>(),
              ::testing::ElementsAre("declare: it declares a scalar 'rain', which is declared "
                                     "already"));
}

// ---- conservation ------------------------------------------------------------------------------

double all_grass(TestWorld& world) {
  double sum = 0;
  for (const double grass : world.grid("it", "grass").values) sum += grass;
  return sum;
}

TEST(CheckEnvironment, HoldsTheTotalAgainstItsExpectedChange) {
  EnvironmentOptions options;
  options.total = all_grass;
  options.change = [](TestWorld& world) {
    // The rain of the coming step, on 400 squares.
    const double growth = world.step() / 10 % 2 == 1 ? 0.05 : 0.1;
    return 400 * growth * (1 - world.scalar("it", "rain"));
  };
  EXPECT_THAT(check_environment<Honest>({}, options), IsEmpty());

  options.change = {};
  EXPECT_THAT(check_environment<Honest>({}, options),
              ::testing::ElementsAre(AllOf(HasSubstr("conservation: the total changes by "),
                                           HasSubstr("in step 0, not by 0"))));
}

// ---- parameters of others
// ------------------------------------------------------------------------

/// Turns another instance's tap on and off.
class Tap final : public Environment {
 public:
  struct Parameters {
    double open = 2;
  };
  explicit Tap(const Parameters& p) : p_(p) {}
  void declare(Declare& d) override { d.acts_in(Phase::parameters); }
  void connect(Connections& c) override { flow_ = c.vary("river", "flow"); }
  void act(Phase, World& world) const override {
    world.set_parameter(flow_.id, world.step() % 2 == 0 ? p_.open : 0);
  }

 private:
  Parameters p_;
  Variable flow_;
};

TEST(CheckEnvironment, OffersParametersOfOtherInstances) {
  EnvironmentOptions options;
  options.variables = {{"river", "flow", {.value = 1, .minimum = 0, .maximum = 3}}};
  EXPECT_THAT(check_environment<Tap>({}, options), IsEmpty());
  EXPECT_THAT(check_environment<Tap>({.open = 4}, options),
              ::testing::ElementsAre("a first simulation: step 0: set_parameter: 'river.flow' is "
                                     "out of its range"));
  EXPECT_THAT(check_environment<Tap>({}),
              ::testing::ElementsAre(HasSubstr("no environment has a variable parameter "
                                               "'river.flow'")));
}

}  // namespace
}  // namespace somas::testing
