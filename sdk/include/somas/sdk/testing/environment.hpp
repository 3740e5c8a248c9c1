/// @file
/// The conformance check of environments.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/testing/declare.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/world.hpp"

namespace somas::testing {

/// How check_environment looks at an environment.
struct EnvironmentOptions {
  /// What the environment is told of the experiment.
  WorldInfo info{.radius = 60, .max_steps = 3000, .substeps = 3, .time_step = 1.0 / 30};
  std::uint64_t steps = 40;     ///< of every simulation; long enough for all that may happen
  std::string instance = "it";  ///< its name in the experiment
  Script script{};              ///< what the cells do meanwhile
  std::uint64_t seed = 1;       ///< of all worlds

  /// Variable parameters of other instances, for an environment that takes them in charge.
  struct OfOthers {
    std::string instance;  ///< who declares it
    std::string name;      ///< its key in the experiment
    VariableSpec spec;     ///< its value and range
  };
  /// Declared before the environment connects.
  std::vector<OfOthers> variables{};

  /// What the environment conserves, or changes by a known amount. In every step the sum of the
  /// changes that its acts make to `total` must be what `change` gave at the start of the step
  /// (none: 0), up to `tolerance` of the total, or of 1 for smaller totals. What cells take up
  /// between the acts does not count. Use TestWorld::grid(instance, name) and the like.
  std::function<double(TestWorld& world)> total{};
  /// See `total`.
  std::function<double(TestWorld& world)> change{};
  double tolerance = 1e-9;  ///< of `total`, relative
};

/// A new instance of the class that is checked, with its parameters.
using MakeEnvironment = std::function<std::unique_ptr<Environment>()>;

/// An environment that has declared and connected, and any number of worlds for it.
class EnvironmentStage {
 public:
  /// Takes the environment and lets it declare and connect; what it throws passes through.
  EnvironmentStage(std::unique_ptr<Environment> environment, const EnvironmentOptions& options)
      : options_(options), environment_(std::move(environment)) {
    declare_others();
    TestDeclare declare(declared_, options_.info, options_.instance);
    environment_->declare(declare);
    TestConnections connections(declared_, options_.instance);
    environment_->connect(connections);
  }

  /// The environment; lives as long as this.
  [[nodiscard]] const Environment& environment() const { return *environment_; }
  /// What it declared, and what others did.
  [[nodiscard]] const Declared& declared() const { return declared_; }
  /// A world that has not begun. It refers to the environment, so this must outlive it.
  [[nodiscard]] std::unique_ptr<TestWorld> world(std::uint64_t seed) const {
    return world(seed, options_.script);
  }
  /// The same with a script of its own.
  [[nodiscard]] std::unique_ptr<TestWorld> world(std::uint64_t seed, const Script& script) const {
    return std::make_unique<TestWorld>(
        options_.info, declared_, seed, script,
        std::vector<TestActor>{{options_.instance, environment_.get()}});
  }

 private:
  /// One of everything comes first under another name, so that no handle is 0 by accident.
  void declare_others() {
    TestDeclare other(declared_, options_.info, "other_instance");
    static_cast<void>(other.sensor("other_instance.sensor"));
    static_cast<void>(other.cell_value("value", OnDivision::copy));
    static_cast<void>(other.scalar("scalar", 1));
    static_cast<void>(other.grid("grid", {.columns = 2, .rows = 2}));
    constexpr std::string_view columns[] = {"x"};
    static_cast<void>(other.table("table", columns));
    const Id skill = other.skill("other_instance.resistance", {});
    static_cast<void>(other.hazard("other_instance.hazard", skill));
    static_cast<void>(other.purpose("purpose"));
    static_cast<void>(other.parameter("parameter", {.value = 1}));
    for (const EnvironmentOptions::OfOthers& v : options_.variables)
      static_cast<void>(
          TestDeclare(declared_, options_.info, v.instance).parameter(v.name, v.spec));
  }

  EnvironmentOptions options_;
  std::unique_ptr<Environment> environment_;
  Declared declared_;
};

namespace detail {

/// Takes a world through one step; what goes wrong names the step.
inline void advance(TestWorld& world, Trace& trace) {
  const std::string place = "step " + std::to_string(world.step()) + ": ";
  try {
    world.advance();
  } catch (const std::exception& error) {
    throw std::runtime_error(place + error.what());
  }
  trace.push_back(world.marks());
}

inline void begin(TestWorld& world, Trace& trace) {
  world.begin();
  trace.push_back(world.marks());
}

/// Takes a world that has not begun through its whole life.
inline Trace live(TestWorld& world, std::uint64_t steps) {
  Trace trace;
  begin(world, trace);
  while (world.step() < steps) advance(world, trace);
  return trace;
}

/// Throws, naming the first difference, unless `other` is how `expected` ends.
inline void require_same(const Trace& expected, const Trace& other) {
  const std::size_t skipped = expected.size() - other.size();
  for (std::size_t i = 0; i < other.size(); ++i) {
    const std::vector<Mark>&first = expected[skipped + i], &second = other[i];
    const std::size_t entry = skipped + i;
    const std::string when = entry == 0 ? "after begin" : "in step " + std::to_string(entry - 1);
    for (std::size_t m = 0; m < std::min(first.size(), second.size()); ++m)
      if (first[m] != second[m]) throw std::runtime_error(first[m].part + " differs " + when);
    if (first.size() != second.size()) throw std::runtime_error("something differs " + when);
  }
}

/// The single checks of an environment; each throws what it finds.
class EnvironmentCheck {
 public:
  EnvironmentCheck(MakeEnvironment make, EnvironmentOptions options)
      : make_(std::move(make)), options_(std::move(options)) {}

  /// The checks, which keep `it`.
  [[nodiscard]] static Checks list(const std::shared_ptr<EnvironmentCheck>& it);

 private:
  [[nodiscard]] EnvironmentStage stage() const { return {make_(), options_}; }
  [[nodiscard]] Trace alone(std::uint64_t seed) const {
    const EnvironmentStage fresh = stage();
    return live(*fresh.world(seed), options_.steps);
  }

  /// What all later lives are compared with, lived when it is first asked for.
  void live_first();
  void declares_the_same_twice() const;
  void again() const { require_same(expected_, alone(options_.seed)); }
  void adds_to_forces() const;
  void one_instance_twice() const;
  void interleaved(const EnvironmentStage& first, const EnvironmentStage& second) const;
  void on_several_threads() const;
  void restored(std::uint64_t step) const;
  void shuffled() const;
  void conserves() const;

  MakeEnvironment make_;
  EnvironmentOptions options_;
  Trace expected_{};  ///< of a fresh instance in a fresh world
  Trace other_{};     ///< the same of another seed
};

inline Checks EnvironmentCheck::list(const std::shared_ptr<EnvironmentCheck>& it) {
  const std::string same = "a second instance, the same seed",
                    serially = "a second simulation of one instance",
                    in_turns = "two instances in turns",
                    shared = "one instance serving two worlds in turns";
  Checks checks;
  checks.push_back({.law = "declare",
                    .name = "declare",
                    .remedy = "declare from the parameters and Declare::world() alone, each name "
                              "once",
                    .body = [it] { it->declares_the_same_twice(); },
                    .first = true});
  checks.push_back({.law = "a first simulation",
                    .name = "a first simulation",
                    .remedy = "write finite numbers, what you declared, in the phases that "
                              "world.hpp names; what an environment throws ends a run",
                    .body = [it] { it->live_first(); },
                    .first = true});
  const auto add = [&](const std::string& law, const std::string& name, const char* remedy,
                       auto body, std::vector<std::string> needs) {
    checks.push_back({.law = law,
                      .name = name,
                      .remedy = remedy,
                      .body = [it, body] { it->live_first(), body(*it); },
                      .needs = std::move(needs)});
  };
  const char* in_the_world =
      "keep what changes in grids, tables, scalars and cell values of the World, and no mutable "
      "members, statics or thread_locals";
  add(same, same, "take chance from World::rng alone; no statics, no clock, no addresses",
      [](const EnvironmentCheck& c) { c.again(); }, {});
  add(serially, serially, in_the_world, [](const EnvironmentCheck& c) { c.one_instance_twice(); },
      {same});
  add(in_turns, in_turns, in_the_world,
      [](const EnvironmentCheck& c) { c.interleaved(c.stage(), c.stage()); }, {same, serially});
  add(shared, shared, in_the_world,
      [](const EnvironmentCheck& c) {
        const EnvironmentStage both = c.stage();
        c.interleaved(both, both);
      },
      {same, serially, in_turns});
  add("one instance on several threads", "one instance on several threads",
      "begin and act are called from several threads at once: write to the World only",
      [](const EnvironmentCheck& c) { c.on_several_threads(); },
      {same, serially, in_turns, shared});
  for (const std::uint64_t quarter : {1, 2, 3}) {
    const std::uint64_t step = it->options_.steps * quarter / 4;
    add("saved in mid-life",
        "saved before step " + std::to_string(step) + ", restored to a new instance", in_the_world,
        [step](const EnvironmentCheck& c) { c.restored(step); },
        {same, serially, in_turns, shared});
  }
  add("another storage order of the cells", "another storage order of the cells",
      "cells are stored in any order: tell them apart by (organism, id), and sum over them in that "
      "order",
      [](const EnvironmentCheck& c) { c.shuffled(); }, {same});
  add("act(forces)", "act(forces)", "add to force_x and force_y (+=): others push, too",
      [](const EnvironmentCheck& c) { c.adds_to_forces(); }, {});
  if (it->options_.total)
    add("conservation", "conservation", "see where act makes or loses some of the total",
        [](const EnvironmentCheck& c) { c.conserves(); }, {});
  return checks;
}

inline void EnvironmentCheck::live_first() {
  if (!expected_.empty() && !other_.empty()) return;
  expected_ = alone(options_.seed);
  other_ = alone(options_.seed + 1);
}

inline void EnvironmentCheck::declares_the_same_twice() const {
  const std::vector<std::string> first = stage().declared().lines();
  const std::vector<std::string> second = stage().declared().lines();
  for (std::size_t i = 0; i < std::max(first.size(), second.size()); ++i) {
    const std::string a = i < first.size() ? first[i] : "nothing";
    const std::string b = i < second.size() ? second[i] : "nothing";
    if (a != b) throw std::runtime_error("a second instance declares '" + b + "', not '" + a + "'");
  }
}

inline void EnvironmentCheck::adds_to_forces() const {
  const EnvironmentStage fresh = stage();
  const auto world = fresh.world(options_.seed);
  world->check_forces_add = true;
  static_cast<void>(live(*world, options_.steps));
}

inline void EnvironmentCheck::one_instance_twice() const {
  const EnvironmentStage one = stage();
  static_cast<void>(live(*one.world(options_.seed + 1), options_.steps));
  require_same(expected_, live(*one.world(options_.seed), options_.steps));
}

inline void EnvironmentCheck::interleaved(const EnvironmentStage& first,
                                          const EnvironmentStage& second) const {
  const auto a = first.world(options_.seed), b = second.world(options_.seed + 1);
  Trace of_a, of_b;
  begin(*a, of_a);
  begin(*b, of_b);
  while (a->step() < options_.steps) {
    advance(*a, of_a);
    advance(*b, of_b);
  }
  require_same(expected_, of_a);
  require_same(other_, of_b);
}

inline void EnvironmentCheck::on_several_threads() const {
  const EnvironmentStage one = stage();
  std::vector<Trace> traces(4);
  on_threads(traces.size(), [&](std::size_t i) {
    traces[i] = live(*one.world(options_.seed + i % 2), options_.steps);
  });
  for (std::size_t i = 0; i < traces.size(); ++i)
    require_same(i % 2 == 0 ? expected_ : other_, traces[i]);
}

/// The second half of the life is another instance's, on another thread.
inline void EnvironmentCheck::restored(std::uint64_t step) const {
  Bytes saved;
  {
    const EnvironmentStage before = stage();
    const auto world = before.world(options_.seed);
    static_cast<void>(live(*world, step));
    saved = world->save();
  }
  Trace rest;
  on_threads(1, [&](std::size_t) {
    const EnvironmentStage after = stage();
    const auto world = after.world(options_.seed + 1);
    world->restore(saved);
    while (world->step() < options_.steps) advance(*world, rest);
  });
  require_same(expected_, rest);
}

inline void EnvironmentCheck::shuffled() const {
  for (const std::uint64_t order : {1, 2}) {
    const EnvironmentStage fresh = stage();
    Script script = options_.script;
    script.shuffle = order;
    require_same(expected_, live(*fresh.world(options_.seed, script), options_.steps));
  }
}

inline void EnvironmentCheck::conserves() const {
  const EnvironmentStage fresh = stage();
  const auto world = fresh.world(options_.seed);
  double before = 0, changed = 0;
  world->watch = [&](TestWorld& w, Phase, bool done) {
    const double now = options_.total(w);
    if (done)
      changed += now - before;
    else
      before = now;
  };
  Trace trace;
  begin(*world, trace);
  while (world->step() < options_.steps) {
    const std::string step = std::to_string(world->step());
    const double due = options_.change ? options_.change(*world) : 0;
    changed = 0;
    advance(*world, trace);
    const double limit = options_.tolerance * std::max(1.0, std::abs(before));
    if (!(std::abs(changed - due) <= limit))
      throw std::runtime_error("the total changes by " + text_of(changed) + " in step " + step +
                               ", not by " + text_of(due));
  }
}

}  // namespace detail

/// The checks of check_environment, one by one.
[[nodiscard]] inline Checks environment_checks(const MakeEnvironment& make,
                                               const EnvironmentOptions& options = {}) {
  return detail::EnvironmentCheck::list(std::make_shared<detail::EnvironmentCheck>(make, options));
}

/// Whether environments made by `make` keep the contract of environment.hpp and world.hpp. Each
/// failure names the check and the first difference. What is checked:
///
/// - two instances of the same parameters declare the same;
/// - sensors and forces are finite, grids are finite, and not negative if cells take up from them;
/// - only what this instance declares is touched, and in the phases where it may be; forces are
///   added to those of others;
/// - a simulation hangs on its seed alone: whatever the instance did before, whatever other
///   instances do meanwhile, serving other worlds in turns or from several threads;
/// - all state is the world's: one saved, restored and handed to a new instance lives on the same;
/// - the storage order of the cells changes nothing, by (organism, id), to the last bit;
/// - `options.total` changes as `options.change` says.
[[nodiscard]] inline Failures check_environment(const MakeEnvironment& make,
                                                const EnvironmentOptions& options = {}) {
  return detail::run(environment_checks(make, options));
}

/// The same for a plugin class and its parameters: check_environment<Breeze>({.strength = 2}).
template <class E>
[[nodiscard]] Failures check_environment(
    const typename E::Parameters& parameters = typename E::Parameters(),
    const EnvironmentOptions& options = {}) {
  return check_environment([&] { return std::make_unique<E>(parameters); }, options);
}

}  // namespace somas::testing
