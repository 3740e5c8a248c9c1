/// @file
/// A world without a model behind it: cells move, eat, divide and die by a script, and environments
/// act on them in the phases of a step, in the host's order and under its rules. All state is the
/// world's, so that it can be saved, restored and compared to the last bit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/testing/declare.hpp"
#include "somas/sdk/testing/failures.hpp"

namespace somas::testing {

/// A cell, as Cells has it.
struct TestCell {
  std::uint64_t id = 0;          ///< unique within its organism
  std::uint16_t organism = 0;    ///< which organism
  std::uint16_t state = 0;       ///< index into its tree
  double x = 0;                  ///< of the centre
  double y = 0;                  ///< of the centre
  double vx = 0;                 ///< velocity along x
  double vy = 0;                 ///< velocity along y
  double radius = 1;             ///< > 0
  double energy = 1;             ///< [0, 1]
  double ambrosia = 0;           ///< [0, capacity]
  double pressure = 0;           ///< [0, 1)
  Id cause = no_id;              ///< of its death at the end of this step; no_id: it lives on
  std::vector<double> values{};  ///< one per declared cell value; missing ones are 0
  std::vector<double> damage{};  ///< absorbed, one per declared hazard; missing ones are 0
};

/// Sixteen cells of two organisms in three states, spread over a disc of radius 12, their ids with
/// gaps, each drifting on a course of its own.
[[nodiscard]] inline std::vector<TestCell> scattered_cells() {
  std::vector<TestCell> cells;
  for (std::uint32_t i = 0; i < 16; ++i) {
    const double share = i / 16.0;
    const math::SinCos place = math::sincos(math::two_pi * 2.618 * share * 6);
    const math::SinCos course = math::sincos(math::two_pi * 0.37 * i);
    TestCell cell{.id = 3 + 5 * std::uint64_t{i} / 2,
                  .organism = static_cast<std::uint16_t>(i % 2),
                  .state = static_cast<std::uint16_t>(i % 3)};
    cell.x = 12 * std::sqrt(share) * place.cos;
    cell.y = 12 * std::sqrt(share) * place.sin;
    cell.vx = 3 * course.cos;
    cell.vy = 3 * course.sin;
    cells.push_back(std::move(cell));
  }
  return cells;
}

/// What becomes of the cells beside what environments do to them. It hangs on the world's seed, the
/// step and the cells' (organism, id) alone.
struct Script {
  /// The cells at the start.
  std::vector<TestCell> founders = scattered_cells();
  /// A cell divides in every so many steps (an empty world gets a newcomer); 0: never.
  std::uint64_t birth_every = 4;
  /// A cell dies in every so many steps; 0: never.
  std::uint64_t death_every = 7;
  /// Of the tree; daughters are of the state after their mother's.
  std::uint16_t states = 3;
  /// Points in a skill by state. Left out: capacity has 10, every other skill its fallback in state
  /// 0 and 1 more in each further state, within its range.
  std::map<std::string, std::vector<double>> skills{};
  /// Cells take up from the declared resources between sensing and moving.
  bool eat = true;
  /// Every ten steps the variable parameters that no instance has in charge change over between
  /// their value and half of it (within their range).
  bool vary_parameters = true;
  /// Storage order: as cells are born, or (not 0) another permutation in every step.
  std::uint64_t shuffle = 0;
};

/// An environment under its name in the experiment.
struct TestActor {
  std::string instance;                      ///< its name in the experiment
  const Environment* environment = nullptr;  ///< must outlive the world
};

/// What one part of the world was in one step, for comparisons: equal parts have equal hashes.
struct Mark {
  std::string part;        ///< "sensor 'food'", "grid 'content'"
  std::uint64_t hash = 0;  ///< of its bytes
  /// Whether part and hash are equal.
  bool operator==(const Mark&) const = default;
};

/// One entry a step, the first for `begin`.
using Trace = std::vector<std::vector<Mark>>;

/// The reference host. `begin` comes once, then any number of `advance`; both throw
/// std::logic_error out of order. What an environment throws passes through; like the host, a step
/// throws std::runtime_error when a sensor or a force is not finite, and, stricter than the host,
/// when a grid is not finite, a grid of a resource is negative, or an environment touches what
/// another instance declares.
class TestWorld final : public World {
 public:
  /// A world at step 0 that has not begun: what was declared, the seed of its chance, what becomes
  /// of the cells, and who acts in it, in this order.
  TestWorld(WorldInfo info, Declared declared, std::uint64_t seed, Script script,
            std::vector<TestActor> actors)
      : info_(info),
        declared_(std::move(declared)),
        script_(std::move(script)),
        actors_(std::move(actors)) {
    state_.seed = seed;
    for (const Declared::GridOf& g : declared_.grids)
      state_.grids.emplace_back(std::size_t{g.spec.columns} * g.spec.rows, g.spec.initial);
    for (const Declared::TableOf& t : declared_.tables)
      state_.tables.emplace_back(t.columns.size());
    for (const Declared::Scalar& s : declared_.scalars) state_.scalars.push_back(s.initial);
    for (const Declared::Parameter& p : declared_.parameters)
      state_.parameters.push_back(p.spec.value);
    place(script_.founders);
  }
  /// The view of the cells points into the world.
  TestWorld(const TestWorld&) = delete;
  TestWorld& operator=(const TestWorld&) = delete;

  // ---- the life of the world
  // ---------------------------------------------------------------------

  /// Calls `begin` of the actors.
  void begin();
  /// All phases of a step, with births, deaths, meals and motion between them.
  void advance();
  /// One phase of the actors that declared it, for tests of a single rule.
  void act(Phase phase);
  /// Takes the place of all cells.
  void place(std::vector<TestCell> cells);
  /// What `step` says from now on.
  void set_step(std::uint64_t step) { state_.step = step; }
  /// Sets a parameter as its owner's name and its own name say, whoever has it in charge.
  void set_parameter(std::string_view instance, std::string_view name, double value) {
    state_.parameters[id_of(declared_.parameters, instance, name)] = value;
  }

  /// Everything that outlives a step, between steps; `restore` takes it into a world of the same
  /// declarations, which then needs no `begin`. Throws std::runtime_error on bytes of another
  /// world.
  [[nodiscard]] Bytes save() const;
  /// The inverse of `save`.
  void restore(std::span<const std::uint8_t> bytes);

  // ---- looking at it
  // -----------------------------------------------------------------------------

  /// What was declared.
  [[nodiscard]] const Declared& declared() const { return declared_; }
  /// In storage order.
  [[nodiscard]] const std::vector<TestCell>& test_cells() const { return state_.cells; }
  /// A grid by its owner and name; throws std::logic_error for one that is not declared.
  [[nodiscard]] Grid grid(std::string_view instance, std::string_view name) {
    return grid_at(id_of(declared_.grids, instance, name));
  }
  /// A table by its owner and name; throws as `grid` does.
  [[nodiscard]] Table& table(std::string_view instance, std::string_view name) {
    return state_.tables[id_of(declared_.tables, instance, name)];
  }
  /// A scalar by its owner and name; throws as `grid` does.
  [[nodiscard]] double& scalar(std::string_view instance, std::string_view name) {
    return state_.scalars[id_of(declared_.scalars, instance, name)];
  }
  /// What the last Phase::sense filled in, in storage order.
  [[nodiscard]] std::span<const float> sensed(std::string_view instance,
                                              std::string_view name) const {
    return sensors_[id_of(declared_.sensors, instance, name)];
  }
  /// What the last Phase::forces added up to, in storage order.
  [[nodiscard]] std::span<const double> pushed_x() const { return force_x_; }
  /// The same along y.
  [[nodiscard]] std::span<const double> pushed_y() const { return force_y_; }
  /// Units that the cells have taken up so far, of each resource.
  [[nodiscard]] const std::vector<double>& eaten() const { return state_.eaten; }
  /// What was noted in the last step, in the order of happening; cells in order of (organism, id).
  [[nodiscard]] const std::vector<Mark>& marks() const { return marks_; }

  /// Called round every act: before it, and after it (`done`).
  std::function<void(TestWorld& world, Phase phase, bool done)> watch{};
  /// In every Phase::forces the environments are asked twice, once with forces in place already,
  /// and std::runtime_error is thrown unless they add the same to them.
  bool check_forces_add = false;

  // ---- World
  // -------------------------------------------------------------------------------------

  [[nodiscard]] std::uint64_t step() const override { return state_.step; }
  [[nodiscard]] const WorldInfo& info() const override { return info_; }
  [[nodiscard]] const Cells& cells() const override { return view_; }
  [[nodiscard]] std::span<float> sensor(Id sensor) override {
    require(Phase::sense, "sensor");
    require_own(declared_.sensors, sensor, "sensor");
    return sensors_[sensor];
  }
  [[nodiscard]] std::span<const double> skill(Id skill) override {
    if (skill >= declared_.skills.size()) throw std::logic_error("no such skill");
    std::vector<double>& column = skills_[skill];
    column.clear();
    for (const TestCell& cell : state_.cells) column.push_back(points(cell.state, skill));
    return column;
  }
  [[nodiscard]] std::span<double> cell_value(Id value) override {
    require_own(declared_.cell_values, value, "cell value");
    return values_[value];
  }
  [[nodiscard]] double& scalar(Id scalar) override {
    require_own(declared_.scalars, scalar, "scalar");
    return state_.scalars[scalar];
  }
  [[nodiscard]] Grid grid(Id grid) override {
    require_own(declared_.grids, grid, "grid");
    return grid_at(grid);
  }
  [[nodiscard]] Table& table(Id table) override {
    require_own(declared_.tables, table, "table");
    return state_.tables[table];
  }
  [[nodiscard]] std::span<double> force_x() override {
    require(Phase::forces, "force_x");
    return force_x_;
  }
  [[nodiscard]] std::span<double> force_y() override {
    require(Phase::forces, "force_y");
    return force_y_;
  }
  void first_hit(std::span<const Segment> segments, std::span<std::int32_t> cells) override {
    require(Phase::stress, "first_hit");
    if (cells.size() < segments.size())
      throw std::logic_error("first_hit: too few places for hits");
    for (std::size_t i = 0; i < segments.size(); ++i) cells[i] = first_cell(segments[i]);
  }
  void strike(std::uint32_t cell, Id hazard, double energy) override {
    require(Phase::stress, "strike");
    require_own(declared_.hazards, hazard, "hazard");
    if (cell >= state_.cells.size()) throw std::logic_error("strike: no such cell");
    if (!(energy >= 0)) throw std::logic_error("strike: the energy must be a number, at least 0");
    TestCell& struck = state_.cells[cell];
    struck.damage[hazard] += energy;
    const Declared::Hazard& declared = declared_.hazards[hazard];
    if (struck.damage[hazard] > points(struck.state, declared.resistance_skill))
      bury_later(cell, declared.cause);
  }
  void kill(std::uint32_t cell, Id cause) override {
    require(Phase::stress, "kill");
    if (cell >= state_.cells.size()) throw std::logic_error("kill: no such cell");
    if (cause >= declared_.causes.size()) throw std::logic_error("kill: no such cause");
    bury_later(cell, cause);
  }
  [[nodiscard]] Rng rng(Id purpose, std::uint64_t entity) const override {
    if (purpose >= declared_.purposes.size()) throw std::logic_error("no such purpose");
    return stream(declared_.purposes[purpose], entity);
  }
  [[nodiscard]] double parameter(Id parameter) const override {
    if (parameter >= state_.parameters.size()) throw std::logic_error("no such parameter");
    return state_.parameters[parameter];
  }
  void set_parameter(Id parameter, double value) override;

 private:
  /// A declared table's rows.
  class Rows final : public Table {
   public:
    explicit Rows(std::size_t columns = 0) : columns_(columns) {}
    [[nodiscard]] std::uint32_t rows() const override { return rows_; }
    [[nodiscard]] std::span<double> column(Id column) override { return columns_.at(column); }
    void resize(std::uint32_t rows) override {
      // Elsewhere in memory each time, as in a host whose spans become invalid.
      for (std::vector<double>& column : columns_) {
        std::vector<double> moved(rows);
        std::copy_n(column.begin(), std::min(rows, rows_), moved.begin());
        column = std::move(moved);
      }
      rows_ = rows;
    }
    void write(detail::ByteWriter& out) const {
      out.value(rows_);
      for (const std::vector<double>& column : columns_) out.list(column);
    }
    void read(detail::ByteReader& in) {
      in.value(rows_);
      for (std::vector<double>& column : columns_) in.list(column);
    }
    [[nodiscard]] const std::vector<std::vector<double>>& columns() const { return columns_; }

   private:
    std::uint32_t rows_ = 0;
    std::vector<std::vector<double>> columns_;
  };

  /// What outlives a step.
  struct State {
    std::uint64_t seed = 0;
    std::uint64_t step = 0;
    std::uint64_t next_id = 1;
    std::uint64_t begun = 0;
    std::vector<TestCell> cells;
    std::vector<double> scalars, parameters, eaten;
    std::vector<std::vector<double>> grids;
    std::vector<Rows> tables;
  };

  // ---- rules
  // -------------------------------------------------------------------------------------

  void require(Phase phase, const char* call) const {
    static constexpr const char* names[] = {"act(fields)", "act(sense)", "act(forces)",
                                            "act(stress)", "act(parameters)"};
    if (phase_ != phase)
      throw std::logic_error(std::string(call) + " belongs in " +
                             names[static_cast<std::size_t>(phase)]);
  }
  template <class T>
  void require_own(const std::vector<T>& list, Id id, const char* what) const {
    if (id >= list.size()) throw std::logic_error(std::string("no such ") + what);
    if (!acting_.empty() && list[id].owner != acting_)
      throw std::logic_error(std::string("the ") + what + " '" + list[id].name +
                             "' belongs to the instance '" + list[id].owner + "'");
  }
  template <class T>
  static std::size_t id_of(const std::vector<T>& list, std::string_view owner,
                           std::string_view name) {
    for (std::size_t id = 0; id < list.size(); ++id)
      if (list[id].owner == owner && list[id].name == name) return id;
    throw std::logic_error("nobody declares '" + std::string(owner) + "." + std::string(name) +
                           "'");
  }
  Grid grid_at(std::size_t id) { return {state_.grids[id], declared_.grids[id].spec}; }
  void bury_later(std::uint32_t cell, Id cause) {
    if (state_.cells[cell].cause == no_id) state_.cells[cell].cause = cause;
    dead_[cell] = 1;
  }
  [[nodiscard]] Rng stream(std::string_view purpose, std::uint64_t entity) const {
    return {state_.seed, ~std::uint64_t{0}, state_.step, stable_key(purpose), entity};
  }
  /// A number in [0, 1) for the script.
  [[nodiscard]] double chance(std::string_view what, const TestCell& cell) const {
    return stream(what, stable_key("cell") + 65537 * cell.id + cell.organism).uniform();
  }
  [[nodiscard]] double points(std::uint16_t state, Id skill) const;
  /// Places of the cells in order of (organism, id).
  [[nodiscard]] std::vector<std::uint32_t> ranked() const;
  [[nodiscard]] std::int32_t first_cell(const Segment& segment) const;

  // ---- parts of a step
  // ---------------------------------------------------------------------------

  void refresh();
  void collect();
  void shuffle();
  void vary_parameters();
  void divide();
  void scripted_death();
  void eat();
  void eat(std::size_t resource);
  void move();
  void add_forces();
  void bury();
  void check_grids(const char* when) const;

  // ---- marks
  // -------------------------------------------------------------------------------------

  void mark(std::string part, const detail::Hash& hash) {
    marks_.push_back({std::move(part), hash.value()});
  }
  template <class T>
  void mark_cells(std::string part, const T& of_cell) {
    detail::Hash hash;
    for (const std::uint32_t i : ranked()) hash.add(of_cell(i));
    mark(std::move(part), hash);
  }
  void mark_sensors();
  void mark_state();

  WorldInfo info_;
  Declared declared_;
  Script script_;
  std::vector<TestActor> actors_;
  State state_;
  std::optional<Phase> phase_;
  std::string acting_;
  std::vector<Mark> marks_;

  // The cells as environments see them, renewed before every act.
  Cells view_;
  std::vector<double> x_, y_, vx_, vy_, radius_, energy_, ambrosia_, pressure_;
  std::vector<std::uint64_t> id_;
  std::vector<std::uint16_t> states_, organisms_;
  std::vector<std::uint8_t> dead_;
  std::vector<std::vector<double>> values_, skills_;
  std::vector<std::vector<float>> sensors_;
  std::vector<double> force_x_, force_y_;
};

// ---- the life of the world
// -----------------------------------------------------------------------

inline void TestWorld::begin() {
  if (state_.begun != 0) throw std::logic_error("begin comes once a world");
  state_.begun = 1;
  marks_.clear();
  if (script_.shuffle != 0) shuffle();
  refresh();
  for (const TestActor& actor : actors_) {
    acting_ = actor.instance;
    actor.environment->begin(*this);
  }
  acting_.clear();
  collect();
  check_grids("begin");
  mark_state();
}

inline void TestWorld::advance() {
  if (state_.begun == 0) throw std::logic_error("begin comes before the first step");
  marks_.clear();
  if (script_.shuffle != 0) shuffle();
  if (script_.vary_parameters) vary_parameters();
  act(Phase::parameters);
  act(Phase::fields);
  check_grids("act(fields)");
  act(Phase::sense);
  mark_sensors();
  if (script_.eat) eat();
  divide();
  move();
  scripted_death();
  act(Phase::stress);
  check_grids("act(stress)");
  mark_state();
  bury();
  ++state_.step;
}

inline void TestWorld::act(Phase phase) {
  refresh();
  if (phase == Phase::sense)
    for (std::vector<float>& sensor : sensors_) std::fill(sensor.begin(), sensor.end(), 0.0f);
  for (const TestActor& actor : actors_) {
    if (!declared_.acts(actor.instance, phase)) continue;
    if (watch) watch(*this, phase, false);
    phase_ = phase;
    acting_ = actor.instance;
    actor.environment->act(phase, *this);
    phase_.reset();
    acting_.clear();
    if (watch) watch(*this, phase, true);
  }
  collect();
}

inline void TestWorld::place(std::vector<TestCell> cells) {
  state_.cells = std::move(cells);
  for (TestCell& cell : state_.cells) {
    cell.values.resize(declared_.cell_values.size());
    cell.damage.resize(declared_.hazards.size());
    state_.next_id = std::max(state_.next_id, cell.id + 1);
  }
  state_.eaten.resize(declared_.resources.size());
  refresh();
}

inline void TestWorld::set_parameter(Id parameter, double value) {
  require(Phase::parameters, "set_parameter");
  if (parameter >= declared_.parameters.size()) throw std::logic_error("no such parameter");
  const Declared::Parameter& p = declared_.parameters[parameter];
  const std::string name = "set_parameter: '" + p.owner + "." + p.name + "' is ";
  if (p.in_charge != acting_) throw std::logic_error(name + "not in its charge");
  if (!(value >= p.spec.minimum && value <= p.spec.maximum))
    throw std::logic_error(name + "out of its range");
  state_.parameters[parameter] = value;
}

inline Bytes TestWorld::save() const {
  detail::ByteWriter out;
  for (const std::uint64_t number : {state_.seed, state_.step, state_.next_id, state_.begun})
    out.value(number);
  out.value(static_cast<std::uint64_t>(state_.cells.size()));
  for (const TestCell& c : state_.cells) {
    out.value(c.id), out.value(c.organism), out.value(c.state), out.value(c.cause);
    for (const double v : {c.x, c.y, c.vx, c.vy, c.radius, c.energy, c.ambrosia, c.pressure})
      out.value(v);
    out.list(c.values);
    out.list(c.damage);
  }
  for (const std::vector<double>* list : {&state_.scalars, &state_.parameters, &state_.eaten})
    out.list(*list);
  for (const std::vector<double>& grid : state_.grids) out.list(grid);
  for (const Rows& table : state_.tables) table.write(out);
  return out.bytes();
}

inline void TestWorld::restore(std::span<const std::uint8_t> bytes) {
  detail::ByteReader in(bytes);
  State fresh = state_;
  for (std::uint64_t* number : {&fresh.seed, &fresh.step, &fresh.next_id, &fresh.begun})
    in.value(*number);
  std::uint64_t count = 0;
  in.value(count);
  fresh.cells.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    TestCell& c = fresh.cells.emplace_back();
    in.value(c.id), in.value(c.organism), in.value(c.state), in.value(c.cause);
    for (double* v : {&c.x, &c.y, &c.vx, &c.vy, &c.radius, &c.energy, &c.ambrosia, &c.pressure})
      in.value(*v);
    in.list(c.values);
    in.list(c.damage);
  }
  for (std::vector<double>* list : {&fresh.scalars, &fresh.parameters, &fresh.eaten})
    in.list(*list);
  for (std::vector<double>& grid : fresh.grids) {
    const std::size_t squares = grid.size();
    in.list(grid);
    if (grid.size() != squares) throw std::runtime_error("the saved bytes are of another world");
  }
  for (Rows& table : fresh.tables) table.read(in);
  if (!in.at_end() || fresh.scalars.size() != state_.scalars.size() ||
      fresh.parameters.size() != state_.parameters.size())
    throw std::runtime_error("the saved bytes are of another world");
  state_ = std::move(fresh);
  refresh();
}

// ---- cells -------------------------------------------------------------------------------------

inline double TestWorld::points(std::uint16_t state, Id skill) const {
  const Declared::Skill& s = declared_.skills[skill];
  if (const auto given = script_.skills.find(s.name); given != script_.skills.end())
    return given->second.at(state);
  const double wish = s.name == "capacity" ? 10.0 : s.spec.fallback + state;
  return std::clamp(wish, s.spec.minimum, s.spec.maximum);
}

inline std::vector<std::uint32_t> TestWorld::ranked() const {
  std::vector<std::uint32_t> order(state_.cells.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const TestCell &first = state_.cells[a], &second = state_.cells[b];
    return std::pair(first.organism, first.id) < std::pair(second.organism, second.id);
  });
  return order;
}

/// Copies the cells into the columns that environments see.
inline void TestWorld::refresh() {
  const std::vector<TestCell>& cells = state_.cells;
  const auto column = [&](auto& to, auto TestCell::*member) {
    to.clear();
    for (const TestCell& cell : cells) to.push_back(cell.*member);
  };
  column(x_, &TestCell::x), column(y_, &TestCell::y);
  column(vx_, &TestCell::vx), column(vy_, &TestCell::vy);
  column(radius_, &TestCell::radius), column(energy_, &TestCell::energy);
  column(ambrosia_, &TestCell::ambrosia), column(pressure_, &TestCell::pressure);
  column(id_, &TestCell::id), column(states_, &TestCell::state);
  column(organisms_, &TestCell::organism);
  dead_.clear();
  for (const TestCell& cell : cells) dead_.push_back(cell.cause == no_id ? 0 : 1);
  values_.assign(declared_.cell_values.size(), {});
  for (std::size_t v = 0; v < values_.size(); ++v)
    for (const TestCell& cell : cells) values_[v].push_back(cell.values[v]);
  skills_.resize(declared_.skills.size());
  sensors_.resize(declared_.sensors.size());
  for (std::vector<float>& sensor : sensors_) sensor.resize(cells.size());
  force_x_.resize(cells.size());
  force_y_.resize(cells.size());
  view_ = {.count = static_cast<std::uint32_t>(cells.size()),
           .x = x_,
           .y = y_,
           .vx = vx_,
           .vy = vy_,
           .radius = radius_,
           .energy = energy_,
           .ambrosia = ambrosia_,
           .pressure = pressure_,
           .id = id_,
           .state = states_,
           .organism = organisms_,
           .dead = dead_};
}

/// Takes back what environments may write of the cells.
inline void TestWorld::collect() {
  for (std::size_t v = 0; v < values_.size(); ++v)
    for (std::size_t i = 0; i < state_.cells.size(); ++i) state_.cells[i].values[v] = values_[v][i];
}

inline void TestWorld::shuffle() {
  Rng rng(script_.shuffle, 0, state_.step, stable_key("shuffle"), 0);
  for (std::size_t i = state_.cells.size(); i > 1; --i)
    std::swap(state_.cells[i - 1], state_.cells[rng.below(i)]);
}

inline void TestWorld::vary_parameters() {
  const bool half = state_.step / 10 % 2 == 1;
  for (std::size_t i = 0; i < state_.parameters.size(); ++i) {
    const Declared::Parameter& p = declared_.parameters[i];
    if (p.in_charge.empty())
      state_.parameters[i] =
          std::clamp(half ? p.spec.value / 2 : p.spec.value, p.spec.minimum, p.spec.maximum);
  }
}

inline void TestWorld::divide() {
  if (script_.birth_every == 0 || state_.step % script_.birth_every != 0) return;
  TestCell child{.id = 0, .x = 1, .y = 2, .vx = -1};
  child.values.resize(declared_.cell_values.size());
  if (!state_.cells.empty()) {
    const std::vector<std::uint32_t> order = ranked();
    TestCell& parent = state_.cells[order[state_.step / script_.birth_every % order.size()]];
    for (std::size_t v = 0; v < parent.values.size(); ++v)
      if (declared_.cell_values[v].rule == OnDivision::halve) parent.values[v] /= 2;
    child = parent;
    for (std::size_t v = 0; v < child.values.size(); ++v)
      if (declared_.cell_values[v].rule == OnDivision::zero) child.values[v] = 0;
    child.x += 0.5;
    child.vy = -child.vy;
    child.state = static_cast<std::uint16_t>((child.state + 1) % script_.states);
  }
  child.id = state_.next_id++;
  child.damage.assign(declared_.hazards.size(), 0.0);
  state_.cells.push_back(std::move(child));
}

inline void TestWorld::scripted_death() {
  if (script_.death_every == 0 || state_.cells.empty()) return;
  if (state_.step % script_.death_every != script_.death_every - 1) return;
  const std::vector<std::uint32_t> order = ranked();
  TestCell& cell = state_.cells[order[(3 * state_.step) % order.size()]];
  if (cell.cause == no_id) cell.cause = 0;
}

/// The cells' energy and pressure, and what they take up of each resource in turn.
inline void TestWorld::eat() {
  for (TestCell& cell : state_.cells) {
    const double burnt = std::min(cell.ambrosia, 0.3);
    cell.ambrosia -= burnt;
    cell.energy = std::clamp(cell.energy + burnt / 10 - 0.01, 0.0, 1.0);
    cell.pressure = 0.9 * chance("pressure", cell);
  }
  for (std::size_t r = 0; r < declared_.resources.size(); ++r) eat(r);
}

/// Squares that are asked for more than they hold give everything, in proportion.
inline void TestWorld::eat(std::size_t resource) {
  const Declared::Resource& r = declared_.resources[resource];
  const Id capacity = 0;  // the model's first skill
  const Grid grid = grid_at(r.grid);
  std::map<std::int64_t, double> asked;
  std::vector<double> demand(state_.cells.size());
  const std::vector<std::uint32_t> order = ranked();
  for (const std::uint32_t i : order) {
    const TestCell& cell = state_.cells[i];
    const double room = std::max(0.0, points(cell.state, capacity) - cell.ambrosia);
    demand[i] = std::min(room, chance(r.name, cell) * points(cell.state, r.production_skill));
    asked[grid.index_of(cell.x, cell.y)] += demand[i];
  }
  const std::vector<double> content(grid.values.begin(), grid.values.end());
  for (const std::uint32_t i : order) {
    TestCell& cell = state_.cells[i];
    const std::int64_t square = grid.index_of(cell.x, cell.y);
    if (square < 0 || demand[i] == 0) continue;
    const auto at = static_cast<std::size_t>(square);
    const double share = std::min(1.0, content[at] / asked[square]);
    const double meal = std::min(grid.values[at], share * demand[i]);
    grid.values[at] -= meal;
    cell.ambrosia += meal;
    state_.eaten[resource] += meal;
  }
}

inline void TestWorld::move() {
  for (std::uint32_t substep = 0; substep < info_.substeps; ++substep) {
    add_forces();
    const std::string where = " in substep " + std::to_string(substep);
    mark_cells("force_x" + where, [&](std::uint32_t i) { return force_x_[i]; });
    mark_cells("force_y" + where, [&](std::uint32_t i) { return force_y_[i]; });
    for (std::size_t i = 0; i < state_.cells.size(); ++i) {
      TestCell& cell = state_.cells[i];
      if (!std::isfinite(force_x_[i]) || !std::isfinite(force_y_[i]))
        throw std::runtime_error("a force is not a finite number");
      cell.vx += force_x_[i] * info_.time_step;
      cell.vy += force_y_[i] * info_.time_step;
      cell.x += cell.vx * info_.time_step;
      cell.y += cell.vy * info_.time_step;
    }
  }
}

inline void TestWorld::add_forces() {
  const std::size_t count = state_.cells.size();
  // A power of two, so that forces in place take little from the precision of the sum.
  constexpr double in_place = 1024;
  std::vector<double> with_x, with_y;
  if (check_forces_add) {
    const State before = state_;
    force_x_.assign(count, in_place), force_y_.assign(count, -in_place);
    act(Phase::forces);
    with_x = force_x_, with_y = force_y_;
    state_ = before;
  }
  force_x_.assign(count, 0.0), force_y_.assign(count, 0.0);
  act(Phase::forces);
  for (std::size_t i = 0; i < with_x.size(); ++i) {
    const auto added = [&](double with, double base, double force) {
      return std::abs(with - base - force) <= 1e-9 * (in_place + std::abs(force));
    };
    if (!added(with_x[i], in_place, force_x_[i]) || !added(with_y[i], -in_place, force_y_[i]))
      throw std::runtime_error("forces that are in place already are not added to");
  }
}

inline void TestWorld::bury() {
  for (TestCell& cell : state_.cells)
    if (!(cell.x * cell.x + cell.y * cell.y <= info_.radius * info_.radius)) cell.cause = 2;
  std::erase_if(state_.cells, [](const TestCell& cell) { return cell.cause != no_id; });
  refresh();
}

inline std::int32_t TestWorld::first_cell(const Segment& s) const {
  std::int32_t best = -1;
  double least = 2;
  for (const std::uint32_t i : ranked()) {
    const double ox = s.x0 - x_[i], oy = s.y0 - y_[i];
    const double dx = s.x1 - s.x0, dy = s.y1 - s.y0;
    const double outside = ox * ox + oy * oy - radius_[i] * radius_[i];
    const double towards = ox * dx + oy * dy, square = dx * dx + dy * dy;
    double share = 0;
    if (outside > 0) {
      const double discriminant = towards * towards - square * outside;
      if (towards >= 0 || discriminant < 0) continue;
      share = (-towards - std::sqrt(discriminant)) / square;
    }
    // Equal distances: the lower rank came first.
    if (share > 1 || share >= least) continue;
    best = static_cast<std::int32_t>(i);
    least = share;
  }
  return best;
}

// ---- checks and marks
// ----------------------------------------------------------------------------

inline void TestWorld::check_grids(const char* when) const {
  for (std::size_t g = 0; g < state_.grids.size(); ++g) {
    const bool resource = std::any_of(declared_.resources.begin(), declared_.resources.end(),
                                      [&](const Declared::Resource& r) { return r.grid == g; });
    for (const double value : state_.grids[g]) {
      const std::string grid = "after " + std::string(when) + " the grid '" +
                               declared_.grids[g].name + "' holds " + detail::text_of(value);
      if (!std::isfinite(value)) throw std::runtime_error(grid);
      if (resource && value < 0) throw std::runtime_error(grid + ", yet cells take up from it");
    }
  }
}

inline void TestWorld::mark_sensors() {
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    const std::string name = "sensor '" + declared_.sensors[s].name + "'";
    for (const float value : sensors_[s])
      if (!std::isfinite(value)) throw std::runtime_error("the " + name + " is no finite number");
    mark_cells(name, [&](std::uint32_t i) { return sensors_[s][i]; });
  }
}

inline void TestWorld::mark_state() {
  for (std::size_t g = 0; g < state_.grids.size(); ++g) {
    detail::Hash hash;
    for (const double value : state_.grids[g]) hash.add(value);
    mark("grid '" + declared_.grids[g].name + "'", hash);
  }
  for (std::size_t t = 0; t < state_.tables.size(); ++t) {
    detail::Hash hash;
    hash.add(state_.tables[t].rows());
    for (const std::vector<double>& column : state_.tables[t].columns())
      for (const double value : column) hash.add(value);
    mark("table '" + declared_.tables[t].name + "'", hash);
  }
  const auto mark_numbers = [&](const std::vector<double>& numbers, const auto& declared,
                                const char* what) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      detail::Hash hash;
      hash.add(numbers[i]);
      mark(std::string(what) + " '" + declared[i].name + "'", hash);
    }
  };
  mark_numbers(state_.scalars, declared_.scalars, "scalar");
  mark_numbers(state_.parameters, declared_.parameters, "parameter");
  const std::vector<TestCell>& cells = state_.cells;
  for (std::size_t v = 0; v < declared_.cell_values.size(); ++v)
    mark_cells("cell value '" + declared_.cell_values[v].name + "'",
               [&](std::uint32_t i) { return cells[i].values[v]; });
  for (std::size_t h = 0; h < declared_.hazards.size(); ++h)
    mark_cells("damage by '" + declared_.hazards[h].name + "'",
               [&](std::uint32_t i) { return cells[i].damage[h]; });
  mark_cells("deaths", [&](std::uint32_t i) { return cells[i].cause; });
  mark_cells("ids of cells", [&](std::uint32_t i) { return cells[i].id; });
  mark_cells("x of cells", [&](std::uint32_t i) { return cells[i].x; });
  mark_cells("y of cells", [&](std::uint32_t i) { return cells[i].y; });
}

}  // namespace somas::testing
