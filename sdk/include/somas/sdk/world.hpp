/// @file
/// What environments and fitnesses see of a simulation: declarations before it, and the world while
/// it runs. All state (grids, tables, values, damage) belongs to the host: it is copied, saved,
/// hashed and recorded from the declaration alone, so a plugin keeps parameters and handles only.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/math.hpp"
#include "somas/sdk/rng.hpp"
#include "somas/sdk/types.hpp"

namespace somas {

/// When an environment acts within a step (model, section 0).
enum class Phase : std::uint32_t {
  fields = 0,      ///< phase 1: change grids and scalars
  sense = 1,       ///< phase 2: fill the sensors
  forces = 2,      ///< phase 8, every substep: add to force_x, force_y
  stress = 3,      ///< phase 9: move tables, strike and kill cells
  parameters = 4,  ///< before phase 1: set what other environments let vary
};

/// Facts of the experiment that are fixed before the first step.
struct WorldInfo {
  double radius;            ///< of the disc round (0, 0); cells beyond it are removed
  std::uint64_t max_steps;  ///< where the simulation is stopped, if it has not ended
  std::uint32_t substeps;   ///< of the mechanics, a step
  double time_step;         ///< of one substep
};

/// A skill of specialization states (model, section 5), given in points by the tree.
struct SkillSpec {
  double fallback = 0;                                       ///< for states that do not name it
  double minimum = 0;                                        ///< least points
  double maximum = std::numeric_limits<double>::infinity();  ///< most points
  double cost = 1;  ///< budget points per unit, for trees with a budget
};

/// A grid of squares, row-major from the lower left (index = row * columns + column).
struct GridSpec {
  std::uint32_t columns = 0;  ///< squares along x, > 0
  std::uint32_t rows = 0;     ///< squares along y, > 0
  double side = 1;            ///< of one square
  double left = 0;            ///< x of the grid's left edge
  double bottom = 0;          ///< y of the grid's lower edge
  double initial = 0;         ///< content of every square at the start
};

/// What a cell value becomes at division.
enum class OnDivision : std::uint32_t {
  copy = 0,   ///< both daughters have the mother's
  halve = 1,  ///< both have half of it
  zero = 2    ///< the mother keeps hers, the daughter has 0
};

/// A parameter that an instance lets others change while the world runs.
struct VariableSpec {
  double value = 0;                                           ///< as the experiment gives it
  double minimum = -std::numeric_limits<double>::infinity();  ///< least that it may be set to
  double maximum = std::numeric_limits<double>::infinity();   ///< most that it may be set to
};

/// The handle of another instance's variable parameter.
struct Variable {
  Id id = no_id;      ///< for World::set_parameter
  VariableSpec spec;  ///< as its owner declares it
};

/// In the plane of the world.
struct Point {
  double x = 0;  ///< to the right
  double y = 0;  ///< upwards
};

/// Host-implemented; handed to `Environment::declare` and `Fitness::declare`, once, before anything
/// runs. Names of grids, tables, scalars, cell values and purposes are the instance's own; skills,
/// sensors, resources and causes are known to the whole experiment. Repeating a skill with the same
/// spec gives the same handle; any other repetition throws std::runtime_error, as does a spec that
/// cannot be: let it pass. Names are copied.
class Declare : public Extensible {
 public:
  /// Facts of the experiment.
  [[nodiscard]] virtual const WorldInfo& world() const = 0;
  /// The name that the YAML gives this instance.
  [[nodiscard]] virtual std::string_view instance() const = 0;
  /// Asks for a call of `act` in this phase of every step; undeclared phases cost nothing.
  virtual void acts_in(Phase phase) = 0;
  /// Something that states of the tree are good at; World::skill tells each cell's points.
  virtual Id skill(std::string_view name, const SkillSpec& spec) = 0;
  /// A controller input of every state; the environment fills it in Phase::sense.
  virtual Id sensor(std::string_view name) = 0;
  /// A column of the cells, 0 for the founder; `rule` says what daughters get.
  virtual Id cell_value(std::string_view name, OnDivision rule) = 0;
  /// One number of the world, `initial` at the start.
  virtual Id scalar(std::string_view name, double initial) = 0;
  /// Squares that hold a number each, such as the content of a nutrient.
  virtual Id grid(std::string_view name, const GridSpec& spec) = 0;
  /// Rows of moving things (particles), empty at the start; column handles are 0, 1, ... in the
  /// order of `columns`, their names.
  virtual Id table(std::string_view name, std::span<const std::string_view> columns) = 0;
  /// Something cells absorb until it exceeds `resistance_skill`; the name is the cause of death.
  virtual Id hazard(std::string_view name, Id resistance_skill) = 0;
  /// A cause of death for `World::kill`.
  virtual Id cause(std::string_view name) = 0;
  /// Something cells take up from `grid` into ambrosia, at most `production_skill` units a step.
  /// Adds a controller output "uptake.<name>".
  virtual Id resource(std::string_view name, Id grid, Id production_skill) = 0;
  /// A family of random streams, see `World::rng`.
  virtual Id purpose(std::string_view name) = 0;
  /// A parameter of this instance that may vary in time; `name` is its key in the experiment. Where
  /// it is used, read World::parameter instead of the value given.
  virtual Id parameter(std::string_view name, const VariableSpec& spec) = 0;
  /// Something that stands still, for pictures only: a line through the points, or, if `closed`,
  /// the polygon that they bound.
  virtual void outline(std::string_view name, std::span<const Point> points, bool closed) = 0;
};

/// Host-implemented; handed to `Environment::connect`, once, when all instances have declared.
class Connections : public Extensible {
 public:
  /// Takes charge of another instance's variable parameter: only this instance sets it. Throws
  /// std::runtime_error, naming what there is, for one that no instance declares or that another
  /// instance has in charge. `instance` is the other's name in the experiment, `parameter` its key.
  virtual Variable vary(std::string_view instance, std::string_view parameter) = 0;
};

/// Read-only columns of the cells, structure of arrays, `count` long. The order of cells is the
/// host's and changes when cells are born, specialize or die; `id` is a cell's name for life.
struct Cells {
  std::uint32_t count = 0;                  ///< of cells: the length of each column
  std::span<const double> x;                ///< of the centre
  std::span<const double> y;                ///< of the centre
  std::span<const double> vx;               ///< velocity along x
  std::span<const double> vy;               ///< velocity along y
  std::span<const double> radius;           ///< founder: 1
  std::span<const double> energy;           ///< [0, 1]
  std::span<const double> ambrosia;         ///< [0, capacity]
  std::span<const double> pressure;         ///< [0, 1), after the last mechanics
  std::span<const std::uint64_t> id;        ///< unique within an organism
  std::span<const std::uint16_t> state;     ///< index into the organism's tree
  std::span<const std::uint16_t> organism;  ///< place of its key in the roster's order of keys
  std::span<const std::uint8_t> dead;       ///< 1: dies at the end of this step
};

/// A declared grid while the world runs.
struct Grid {
  std::span<double> values;  ///< one a square, row-major; valid during the call
  GridSpec spec;             ///< as declared

  /// Index of the square that holds (x, y) (lower and left edges belong to it), or -1 outside;
  /// without branches so that loops over lanes vectorise.
  [[nodiscard]] std::int64_t index_of(double x, double y) const {
    const double column = std::floor((x - spec.left) / spec.side);
    const double row = std::floor((y - spec.bottom) / spec.side);
    const bool inside = (column >= 0) & (column < spec.columns) & (row >= 0) & (row < spec.rows);
    const double index = inside ? row * spec.columns + column : -1.0;
    constexpr auto zero = std::bit_cast<std::int64_t>(math::detail::magic);
    return std::bit_cast<std::int64_t>(index + math::detail::magic) - zero;
  }
  /// x of the centre of a square.
  [[nodiscard]] double centre_x(std::size_t index) const {
    const std::size_t column = index % spec.columns;
    return spec.left + (static_cast<double>(column) + 0.5) * spec.side;
  }
  /// y of the centre of a square.
  [[nodiscard]] double centre_y(std::size_t index) const {
    const std::size_t row = index / spec.columns;
    return spec.bottom + (static_cast<double>(row) + 0.5) * spec.side;
  }
};

/// A declared table while the world runs. Spans become invalid at `resize`.
class Table : public Extensible {
 public:
  /// How many things there are.
  [[nodiscard]] virtual std::uint32_t rows() const = 0;
  /// One value a row; `column` is its place in the declaration.
  [[nodiscard]] virtual std::span<double> column(Id column) = 0;
  /// New rows are zero; rows beyond the new size are dropped.
  virtual void resize(std::uint32_t rows) = 0;
};

/// The straight path of a thing during one step, from (x0, y0) to (x1, y1).
struct Segment {
  double x0;  ///< of the start
  double y0;  ///< of the start
  double x1;  ///< of the end
  double y1;  ///< of the end
};

/// The running world; host-implemented, valid during the call. Calls marked with a phase throw
/// std::logic_error elsewhere. An Id that was never declared is a programmer's error.
class World : public Extensible {
 public:
  /// The step under way, from 0.
  [[nodiscard]] virtual std::uint64_t step() const = 0;
  /// Facts of the experiment.
  [[nodiscard]] virtual const WorldInfo& info() const = 0;
  /// The cells as they are now.
  [[nodiscard]] virtual const Cells& cells() const = 0;
  /// One value a cell, to be filled in Phase::sense; inputs are best kept within [0, 1].
  [[nodiscard]] virtual std::span<float> sensor(Id sensor) = 0;
  /// Every cell's points in a skill, by its state. Valid until the phase ends.
  [[nodiscard]] virtual std::span<const double> skill(Id skill) = 0;
  /// A declared column of the cells, to read and write.
  [[nodiscard]] virtual std::span<double> cell_value(Id value) = 0;
  /// A declared number, to read and write.
  [[nodiscard]] virtual double& scalar(Id scalar) = 0;
  /// A declared grid, to read and write.
  [[nodiscard]] virtual Grid grid(Id grid) = 0;
  /// A declared table, to read and write.
  [[nodiscard]] virtual Table& table(Id table) = 0;
  /// Phase::forces: accumulators, one a cell; environments add to them.
  [[nodiscard]] virtual std::span<double> force_x() = 0;
  /// The same along y.
  [[nodiscard]] virtual std::span<double> force_y() = 0;
  /// For each segment the index of the first cell whose disc it meets (a start inside a disc counts
  /// as met at once; equal distances: the lowest id), or -1. `cells` has room for as many as there
  /// are segments. Phase::stress.
  virtual void first_hit(std::span<const Segment> segments, std::span<std::int32_t> cells) = 0;
  /// The cell absorbs `energy`; it dies when all it absorbed of the hazard exceeds its resistance.
  /// Cells that die this step absorb until the step ends. Phase::stress.
  virtual void strike(std::uint32_t cell, Id hazard, double energy) = 0;
  /// The cell dies at the end of the step, unless it is dying already. Phase::stress.
  virtual void kill(std::uint32_t cell, Id cause) = 0;
  /// The stream of (evaluation seed, this step, purpose, entity). `purpose` was declared; `entity`
  /// is what chance falls on: a cell's id, a row, 0.
  [[nodiscard]] virtual Rng rng(Id purpose, std::uint64_t entity) const = 0;
  /// What a variable parameter is now: as the experiment gives it, until somebody sets it.
  [[nodiscard]] virtual double parameter(Id parameter) const = 0;
  /// Sets a parameter that this instance has in charge, until it is set again. Throws
  /// std::logic_error outside its range. Phase::parameters.
  virtual void set_parameter(Id parameter, double value) = 0;
};

}  // namespace somas
