// Shared by the tests of the model: toy plugin classes, and a bench on which cells are placed by
// hand. Nothing here computes what a test expects; the oracles stand in the tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/model/ecosystem.hpp"
#include "core/model/simulation.hpp"

namespace somas::model::test {

// ---- plugin classes -----------------------------------------------------------------------------

/// A state as a test writes it; skills that are not named take their fallback.
struct StateDef {
  std::string name = "root";
  std::uint16_t parent = no_state;
  double mass = 1, radius = 1, stiffness = 10, adhesion = 3, adhesion_range = 1.2;
  std::map<std::string, double> skills = {};
  std::uint64_t key = 0;
  double motility = 0;
  std::uint32_t motility_signal = 0;
  std::vector<double> adhesion_with = {};
  double quiescence_threshold = 0, division_threshold = 0, specialization_threshold = 0,
         apoptosis_threshold = 0;
};

/// Genes that nobody looks into.
class NoGenes final : public Heritable {
 public:
  void random(const Layout&, Rng&, Genes& genes) const override { genes.clear(); }
  void conform(const Layout&, Rng&, Genes&) const override {}
  void mutate(const Layout&, Rng&, Genes&) const override {}
  void cross(const Layout&, GenesView first, GenesView, Rng&, Genes& child) const override {
    child.assign(first.begin(), first.end());
  }
  [[nodiscard]] double distance(GenesView, GenesView) const override { return 0; }
  void to_json(GenesView, JsonWriter&) const override {}
  void from_json(const JsonReader&, Genes&) const override {}
  void check(const Layout&, GenesView) const override {}
};

/// Emits the given states.
class FixedTree : public Specialization {
 public:
  explicit FixedTree(std::vector<StateDef> states) : states_(std::move(states)) {}

  void grow(GenesView, std::span<const SkillInfo> skills, TreeSink& tree) const override {
    emit(states_, skills, tree);
  }

  static void emit(const std::vector<StateDef>& states, std::span<const SkillInfo> skills,
                   TreeSink& tree) {
    for (const StateDef& def : states) {
      std::vector<double> points;
      for (const SkillInfo& skill : skills) {
        const auto given = def.skills.find(std::string(skill.name));
        points.push_back(given == def.skills.end() ? skill.spec.fallback : given->second);
      }
      tree.add({.name = def.name,
                .key = def.key,
                .parent = def.parent,
                .mass = def.mass,
                .radius = def.radius,
                .stiffness = def.stiffness,
                .adhesion = def.adhesion,
                .adhesion_range = def.adhesion_range,
                .skills = points,
                .motility = def.motility,
                .motility_signal = def.motility_signal,
                .adhesion_with = def.adhesion_with,
                .quiescence_threshold = def.quiescence_threshold,
                .division_threshold = def.division_threshold,
                .specialization_threshold = def.specialization_threshold,
                .apoptosis_threshold = def.apoptosis_threshold});
    }
  }

 private:
  std::vector<StateDef> states_;
};

/// A tree that evolves: the first gene says how many of the given states there are.
class CountedTree final : public Specialization {
 public:
  explicit CountedTree(std::vector<StateDef> states) : states_(std::move(states)) {}
  [[nodiscard]] const Heritable* heritable() const override { return &genes_; }
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override {
    const std::vector<StateDef> some(states_.begin(), states_.begin() + genes[0]);
    FixedTree::emit(some, skills, tree);
  }

 private:
  std::vector<StateDef> states_;
  NoGenes genes_;
};

/// One cell's turn at the controller.
struct Lane {
  const Batch& batch;
  const Layout& layout;
  std::uint32_t lane;
  std::uint64_t step, id;

  [[nodiscard]] std::uint16_t state() const { return batch.state; }
  [[nodiscard]] std::uint16_t organism() const { return batch.organism; }
  [[nodiscard]] float& memory(std::uint32_t row) const { return batch.memory.channel(row)[lane]; }
  /// The input "<own state>/<name>".
  [[nodiscard]] float in(std::string_view name) const {
    for (const Port& port : layout.inputs)
      if (port.state == batch.state && port.name.size() > name.size() &&
          port.name.ends_with(name) && port.name[port.name.size() - name.size() - 1] == '/')
        return batch.in.channel(port.channel)[lane];
    throw std::logic_error("no input " + std::string(name));
  }
  void out(std::string_view name, float value) const {
    for (const Port& port : layout.outputs)
      if (port.name == name) {
        batch.out.channel(port.channel)[lane] = value;
        return;
      }
    throw std::logic_error("no output " + std::string(name));
  }
};

/// Sets outputs of a lane; all are 0 before.
using Script = std::function<void(const Lane&)>;

/// What a script may know beyond its batch.
struct Stage {
  const Simulation* simulation = nullptr;
};

class ScriptedProgram final : public Program {
 public:
  ScriptedProgram(const Layout& layout, Script script, std::uint32_t memory_rows,
                  std::shared_ptr<const Stage> stage)
      : layout_(layout),
        script_(std::move(script)),
        memory_rows_(memory_rows),
        stage_(std::move(stage)) {}

  [[nodiscard]] std::uint32_t memory_per_cell() const override { return memory_rows_; }
  void step(const Batch& batch) const override {
    for (std::uint32_t c = 0; c < batch.out.channels; ++c)
      for (float& value : batch.out.channel(c)) value = 0;
    if (!script_) return;
    const WorldState& world = stage_->simulation->state();
    const std::uint32_t first = first_of(batch, world.cells);
    for (std::uint32_t lane = 0; lane < batch.count; ++lane)
      script_({batch, layout_, lane, world.step, world.cells.id[first + lane]});
  }

 private:
  /// Storage index of the first lane; only a script with memory can tell where a batch was cut.
  /// Memory of another world than the stage's is of a batch that was not.
  [[nodiscard]] std::uint32_t first_of(const Batch& batch, const CellStore& cells) const {
    const float* row = cells.memory.row(0);
    const std::less<const float*> before;
    if (memory_rows_ > 0 && !before(batch.memory.data, row) &&
        before(batch.memory.data, row + cells.size()))
      return static_cast<std::uint32_t>(batch.memory.data - row);
    std::uint32_t first = 0;
    for (std::uint32_t i = cells.size(); i-- > 0;)
      if (cells.organism[i] == batch.organism && cells.state[i] == batch.state) first = i;
    return first;
  }

  Layout layout_;
  Script script_;
  std::uint32_t memory_rows_;
  std::shared_ptr<const Stage> stage_;
};

class ScriptedController final : public Controller {
 public:
  ScriptedController(Script script, std::uint32_t memory_rows, std::shared_ptr<const Stage> stage)
      : script_(std::move(script)), memory_rows_(memory_rows), stage_(std::move(stage)) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView, const Layout& layout) const override {
    return std::make_unique<ScriptedProgram>(layout, script_, memory_rows_, stage_);
  }

 private:
  Script script_;
  std::uint32_t memory_rows_;
  std::shared_ptr<const Stage> stage_;
  NoGenes genes_;
};

/// An environment made of functions.
class ToyEnvironment final : public Environment {
 public:
  std::function<void(Declare&)> on_declare;
  std::function<void(Connections&)> on_connect;
  std::function<void(World&)> on_begin;
  std::function<void(Phase, World&)> on_act;

  void declare(Declare& declare) override {
    if (on_declare) on_declare(declare);
  }
  void connect(Connections& connections) override {
    if (on_connect) on_connect(connections);
  }
  void begin(World& world) const override {
    if (on_begin) on_begin(world);
  }
  void act(Phase phase, World& world) const override {
    if (on_act) on_act(phase, world);
  }
};

class ToyFitness final : public Fitness {
 public:
  explicit ToyFitness(std::function<bool(World&)> observe) : observe_(std::move(observe)) {}
  [[nodiscard]] std::string_view objective() const override { return "survival"; }
  [[nodiscard]] bool observe(World& world) const override { return observe_ && observe_(world); }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    return static_cast<double>(outcome.survival);
  }

 private:
  std::function<bool(World&)> observe_;
};

// ---- ready-made environments
// ---------------------------------------------------------------------

/// Handles that a toy environment got when it declared.
struct Handles {
  Id grid = no_id, resource = no_id, hazard = no_id, cause = no_id, value = no_id, table = no_id,
     purpose = no_id, scalar = no_id, sensor = no_id;
};

/// Shares a square grid of `squares` x `squares` (edges through the origin) under the resource
/// `name`, produced by the skill "production"; `regeneration` is added a step up to `initial`.
inline NamedEnvironment resource_grid(std::string name, double initial, double regeneration = 0,
                                      double side = 2, std::uint32_t squares = 64,
                                      std::string skill = "production",
                                      std::shared_ptr<Handles> handles = nullptr) {
  auto toy = std::make_shared<ToyEnvironment>();
  if (!handles) handles = std::make_shared<Handles>();
  const double low = -0.5 * side * squares;
  toy->on_declare = [=](Declare& d) {
    const Id production = d.skill(skill, {});
    handles->grid = d.grid("content", {.columns = squares,
                                       .rows = squares,
                                       .side = side,
                                       .left = low,
                                       .bottom = low,
                                       .initial = initial});
    handles->resource = d.resource(name, handles->grid, production);
    if (regeneration > 0) d.acts_in(Phase::fields);
  };
  toy->on_act = [=](Phase, World& world) {
    for (double& content : world.grid(handles->grid).values)
      content = std::min(initial, content + regeneration);
  };
  return {name, toy};
}

/// Declares the hazard `name` against the skill "resistance" and strikes as `strikes` says.
inline NamedEnvironment hazard(std::string name, std::shared_ptr<Handles> handles,
                               std::function<void(World&)> strikes) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [=](Declare& d) {
    handles->hazard = d.hazard(name, d.skill("resistance", {}));
    handles->cause = d.cause(name + "_kill");
    d.acts_in(Phase::stress);
  };
  toy->on_act = [=](Phase, World& world) { strikes(world); };
  return {name, toy};
}

/// Calls `act` in `phase` of every step.
inline NamedEnvironment acting(std::string name, Phase phase, std::function<void(World&)> act,
                               std::function<void(Declare&)> declare = {}) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [=](Declare& d) {
    d.acts_in(phase);
    if (declare) declare(d);
  };
  toy->on_act = [=](Phase, World& world) { act(world); };
  return {std::move(name), toy};
}

// ---- the bench ----------------------------------------------------------------------------------

struct Founder {
  std::uint64_t key = 1;
  double x = 0, y = 0;
};

/// A cell as a test places it.
struct Placed {
  std::uint64_t id = 0;
  double x = 0, y = 0, vx = 0, vy = 0;
  std::uint16_t state = 0;
  double energy = 1, ambrosia = 0;
  std::uint16_t organism = 0;
};

/// Set the fields, `start`, then place cells or step.
class Bench {
 public:
  Config config;
  std::vector<StateDef> states = {StateDef{}};
  std::vector<NamedEnvironment> environments;
  Script script;
  std::uint32_t memory_rows = 0;
  std::function<bool(World&)> observe;
  std::shared_ptr<Controller> controller;  ///< instead of the scripted one
  std::vector<Founder> founders = {Founder{}};
  std::uint64_t seed = 1;

  Bench() { config.warm_up_steps = 0; }

  /// Living costs nothing.
  void free_living() {
    Metabolism& m = config.metabolism;
    m.quiescence_cost = m.division_cost = m.apoptosis_cost = m.specialization_cost = 0;
  }
  /// Cells touch without force, so that they stay where they are put.
  void forceless() {
    for (StateDef& state : states) state.stiffness = state.adhesion = 0;
  }

  void wire() {
    ecosystem_ = std::make_unique<Ecosystem>(
        config, environments, std::make_shared<FixedTree>(states),
        controller ? controller : std::make_shared<ScriptedController>(script, memory_rows, stage_),
        std::make_shared<ToyFitness>(observe));
  }
  Simulation& start() {
    wire();
    phenotypes_.clear();
    std::vector<RosterEntry> roster;
    for (std::size_t i = 0; i < founders.size(); ++i)
      phenotypes_.push_back(ecosystem_->express({}));
    for (std::size_t i = 0; i < founders.size(); ++i)
      roster.push_back({&phenotypes_[i], founders[i].key, founders[i].x, founders[i].y});
    simulation_ = std::make_unique<Simulation>(*ecosystem_, roster, seed);
    stage_->simulation = simulation_.get();
    return *simulation_;
  }
  /// Starts with these cells instead of the founders.
  Simulation& start_with(const std::vector<Placed>& cells) {
    start();
    replace(cells);
    return *simulation_;
  }
  /// Removes every cell and places these.
  void replace(const std::vector<Placed>& placed) {
    WorldState& world = simulation_->mutable_state();
    const std::uint32_t rows = world.cells.memory.channels();
    world.cells.each_column([](auto& column) { column.clear(); });
    world.cells.ranges.clear();
    for (const Placed& p : placed) {
      const std::uint32_t i = world.cells.append(rows);
      world.cells.id[i] = p.id;
      world.cells.organism[i] = p.organism;
      world.cells.state[i] = p.state;
      world.cells.x[i] = p.x, world.cells.y[i] = p.y;
      world.cells.vx[i] = p.vx, world.cells.vy[i] = p.vy;
      world.cells.energy[i] = p.energy;
      world.cells.ambrosia[i] = p.ambrosia;
      world.cells.radius[i] = states[p.state].radius;
      OrganismState& organism = world.organisms[p.organism];
      organism.next_id = std::max(organism.next_id, p.id + 1);
    }
    simulation_->restructured();
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) simulation_->step();
  }

  [[nodiscard]] Ecosystem& ecosystem() { return *ecosystem_; }
  [[nodiscard]] Simulation& simulation() { return *simulation_; }
  [[nodiscard]] const Phenotype& phenotype(std::size_t i) const { return phenotypes_[i]; }
  [[nodiscard]] WorldState& world() { return simulation_->mutable_state(); }
  [[nodiscard]] CellStore& cells() { return simulation_->mutable_state().cells; }
  [[nodiscard]] const Ledger& ledger(std::size_t organism = 0) {
    return simulation_->state().organisms[organism].ledger;
  }
  /// Deaths of an organism by cause.
  [[nodiscard]] std::uint64_t deaths(std::string_view cause, std::size_t organism = 0) {
    const auto& causes = ecosystem_->schema().causes;
    for (std::size_t i = 0; i < causes.size(); ++i)
      if (causes[i] == cause) return simulation_->state().organisms[organism].deaths[i];
    throw std::logic_error("no such cause");
  }
  [[nodiscard]] bool alive(std::uint64_t id, std::uint16_t organism = 0) {
    return find(id, organism) != gone;
  }
  /// Storage index of a cell.
  [[nodiscard]] std::uint32_t at(std::uint64_t id, std::uint16_t organism = 0) {
    const std::uint32_t i = find(id, organism);
    if (i == gone) throw std::logic_error("no cell " + std::to_string(id));
    return i;
  }

 private:
  [[nodiscard]] std::uint32_t find(std::uint64_t id, std::uint16_t organism) {
    const CellStore& c = cells();
    for (std::uint32_t i = 0; i < c.size(); ++i)
      if (c.id[i] == id && c.organism[i] == organism) return i;
    return gone;
  }

  std::shared_ptr<Stage> stage_ = std::make_shared<Stage>();
  std::unique_ptr<Ecosystem> ecosystem_;
  std::vector<Phenotype> phenotypes_;
  std::unique_ptr<Simulation> simulation_;
};

/// Uniform numbers of the tests' own, apart from the generator under test.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  template <class T>
  void shuffle(std::vector<T>& items) {
    std::shuffle(items.begin(), items.end(), engine_);
  }

 private:
  std::mt19937_64 engine_;
};

/// A number in [0, 1) from what it is for.
inline float noise(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  std::uint64_t z = a * 0x9E3779B97F4A7C15ull + b * 0xBF58476D1CE4E5B9ull + c + 1;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

/// A world in which everything happens: two states, all actions, growing nutrients, random strikes,
/// and a wind that gathers cells in the middle and sweeps those near the edge out. Organisms behave
/// by id and step alone.
struct Busy {
  std::shared_ptr<Handles> food = std::make_shared<Handles>();
  std::shared_ptr<Handles> fire = std::make_shared<Handles>();
  static constexpr double radius = 7.5;                           ///< of the world
  std::shared_ptr<double> regrown = std::make_shared<double>(0);  ///< nutrients added so far

  void set_up(Bench& bench) const {
    bench.config.radius = radius;
    bench.config.max_cells = 60;
    bench.config.cycle.division_steps = 6;
    bench.config.cycle.division_energy = 0.4;
    bench.config.cycle.division_pressure = 0.9;
    bench.config.metabolism.division_cost = 0.06;
    bench.memory_rows = 2;
    bench.states = {
        {.name = "root",
         .skills = {{"capacity", 10}, {"production", 3}, {"diffusion", 0.5}, {"resistance", 1}}},
        {.name = "leaf",
         .parent = 0,
         .mass = 1.3,
         .radius = 0.9,
         .adhesion = 4,
         .skills = {{"capacity", 0.6}, {"diffusion", 0.8}, {"resistance", 3}}}};
    bench.script = [](const Lane& lane) {
      lane.memory(0) += 1;
      lane.memory(1) = 0.5f * lane.memory(1) + lane.in("energy");
      const auto draw = [&](std::uint64_t channel) { return noise(lane.id, lane.step, channel); };
      lane.out("quiescence", 0.8f * draw(0));
      lane.out("division", 2.0f * draw(1));
      lane.out("specialize.leaf", 0.85f * draw(2));
      lane.out("apoptosis", 0.7f * draw(3));
      for (int kind = 0; kind < 3; ++kind)
        lane.out(kind == 0   ? "morphogen.0"
                 : kind == 1 ? "morphogen.1"
                             : "morphogen.2",
                 draw(10 + static_cast<std::uint64_t>(kind)));
      lane.out("conversion", 0.5f * draw(4));
      lane.out("diffusion", draw(5));
      lane.out("uptake.food", draw(6));
    };
    auto growing = std::make_shared<ToyEnvironment>();
    growing->on_declare = [food = food](Declare& d) {
      const Id production = d.skill("production", {});
      food->grid =
          d.grid("content",
                 {.columns = 64, .rows = 64, .side = 2, .left = -64, .bottom = -64, .initial = 2});
      food->resource = d.resource("food", food->grid, production);
      food->scalar = d.scalar("season", 1);
      food->sensor = d.sensor("content");
      d.acts_in(Phase::fields);
      d.acts_in(Phase::sense);
    };
    growing->on_act = [food = food, regrown = regrown](Phase phase, World& w) {
      const Grid grid = w.grid(food->grid);
      if (phase == Phase::sense) {
        const std::span<float> sensor = w.sensor(food->sensor);
        for (std::uint32_t i = 0; i < w.cells().count; ++i) {
          const std::int64_t square = grid.index_of(w.cells().x[i], w.cells().y[i]);
          sensor[i] = square < 0
                          ? 0.0f
                          : static_cast<float>(grid.values[static_cast<std::size_t>(square)] / 2);
        }
        return;
      }
      double& season = w.scalar(food->scalar);
      season = 0.9 * season + 0.1 * static_cast<double>(w.step() % 7) / 6;
      for (double& content : grid.values) {
        const double more = std::min(0.8 * season, 2 - content);
        content += more;
        *regrown += more;
      }
    };
    auto fiery = std::make_shared<ToyEnvironment>();
    fiery->on_declare = [fire = fire](Declare& d) {
      const std::array<std::string_view, 2> columns{"cell", "energy"};
      fire->hazard = d.hazard("fire", d.skill("resistance", {}));
      fire->cause = d.cause("bolt");
      fire->purpose = d.purpose("strikes");
      fire->value = d.cell_value("wounds", OnDivision::halve);
      fire->table = d.table("sparks", columns);
      d.acts_in(Phase::stress);
      d.acts_in(Phase::forces);
    };
    fiery->on_act = [fire = fire](Phase phase, World& w) {
      const Cells& cells = w.cells();
      if (phase == Phase::forces) {
        for (std::uint32_t i = 0; i < cells.count; ++i) {
          const bool near = std::hypot(cells.x[i], cells.y[i]) < 0.7 * radius;
          w.force_x()[i] += (near ? -0.5 : 0.3) * cells.x[i];
          w.force_y()[i] += (near ? -0.5 : 0.3) * cells.y[i];
        }
        return;
      }
      Table& sparks = w.table(fire->table);
      sparks.resize(0);
      for (std::uint32_t i = 0; i < cells.count; ++i) {
        Rng rng = w.rng(fire->purpose, cells.id[i]);
        if (rng.chance(0.02)) {
          const double energy = rng.uniform(0, 1);
          w.strike(i, fire->hazard, energy);
          w.cell_value(fire->value)[i] += 1;
          sparks.resize(sparks.rows() + 1);
          sparks.column(0).back() = static_cast<double>(cells.id[i]);
          sparks.column(1).back() = energy;
        }
        if (rng.chance(0.002)) w.kill(i, fire->cause);
      }
    };
    bench.environments = {{"growing", growing}, {"fiery", fiery}};
  }
};

}  // namespace somas::model::test
