// The state of a reference life, as plain values. Nothing here is shared with the engine but what
// goes into both: the ecosystem (configuration, trees, ports, plugins) and the SDK.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "somas/sdk/fitness.hpp"
#include "somas/sdk/world.hpp"

#include "core/model/ecosystem.hpp"

namespace somas::reference {

/// A cell's name for life. Ascending names are the canonical order (docs/model.md, section 0).
struct Name {
  std::uint16_t organism = 0;  ///< place of its key among the roster's keys
  std::uint64_t id = 0;

  friend auto operator<=>(const Name&, const Name&) = default;
};

enum class Action : std::uint8_t { none, quiescence, division, specialization, apoptosis };

struct Cell {
  Name name;
  std::uint16_t state = 0;
  double x = 0, y = 0, vx = 0, vy = 0, radius = 0;
  double energy = 0, ambrosia = 0;
  double pressure = 0, stress_xx = 0, stress_xy = 0, stress_yy = 0;
  std::uint64_t parent = 0, born = 0;
  Action action = Action::none;
  std::uint16_t target = 0;     ///< of a specialization
  std::uint32_t remaining = 0;  ///< steps until the action ends
  bool dead = false;
  Id cause = model::no_cause;
  std::vector<double> values{};  ///< by cell value
  std::vector<double> damage{};  ///< by hazard
  std::vector<float> memory{};   ///< of the controller
  std::vector<Name> contacts{};  ///< ascending

  /// Of the present step.
  std::vector<float> inputs{}, outputs{};
  double force_x = 0, force_y = 0;  ///< from outside: of environments

  void kill(Id why) {
    if (dead) return;  // the first cause counts
    dead = true;
    cause = why;
  }
};

/// Concentrations of one morphogen, row-major from the lower left.
struct Field {
  std::int64_t size = 0;  ///< squares along an edge
  double side = 1;
  std::vector<float> squares;

  [[nodiscard]] bool has(std::int64_t column, std::int64_t row) const {
    return column >= 0 && row >= 0 && column < size && row < size;
  }
  [[nodiscard]] float at(std::int64_t column, std::int64_t row) const {
    return has(column, row) ? squares[static_cast<std::size_t>(row * size + column)] : 0.0f;
  }
};

/// A sum that keeps the rounding error of every addition (Neumaier).
struct Sum {
  double sum = 0, error = 0;
  void add(double x);
};

struct Ledger {
  double founder_ambrosia = 0, founder_energy = 0;
  Sum taken, burnt, given, received, lost_efficiency, lost_overflow, lost_death, lost_outside,
      spent, energy_lost;
};

struct Organism {
  std::uint64_t key = 0;
  std::uint32_t roster_index = 0;
  const model::Phenotype* phenotype = nullptr;
  std::uint64_t next_id = 0;
  std::uint32_t live = 0;
  std::vector<Field> fields;
  Ledger ledger;
  Outcome outcome;
  double shares = 0;
  std::vector<std::uint64_t> deaths;  ///< by cause
};

class PlainTable final : public Table {
 public:
  explicit PlainTable(std::size_t width) : columns(width) {}
  [[nodiscard]] std::uint32_t rows() const override { return count; }
  [[nodiscard]] std::span<double> column(Id c) override { return columns.at(c); }
  void resize(std::uint32_t size) override {
    for (auto& values : columns) values.resize(size, 0.0);
    count = size;
  }

  std::uint32_t count = 0;
  std::vector<std::vector<double>> columns;
};

/// A fault put into the reference on purpose, to see that a comparison finds it.
enum class Mistake {
  none,
  no_damper,           ///< of pairs
  forces_descending,   ///< a cell's partners in descending order
  stress_descending,   ///< likewise
  gifts_descending,    ///< a cell's givers in descending order
  demands_descending,  ///< the cells on a square in descending order
  books_by_name,       ///< energy burnt and spent in canonical order
  late_adhesion,       ///< adhesion only between cells that do not overlap
  share_of_all,        ///< scarce squares give equal parts
  own_gift_first,      ///< room is measured after a cell's own gifts
  divisions_first,     ///< before apoptoses, whose gifts then are not halved
  second_cause,        ///< the last cause of death counts
  last_hit,            ///< a segment stops at the last cell that it meets
  spread_first,        ///< before evaporation, which then rounds differently
};

/// What happened so far, to see that a comparison saw it.
struct Events {
  std::uint64_t steps = 0, cell_steps = 0;
  std::uint64_t births = 0, specializations = 0, refused_divisions = 0;
  std::uint64_t gifts = 0, gifts_to_strangers = 0, shrunk_gifts = 0, legacies = 0;
  std::uint64_t scarce_demands = 0, crowded_rooms = 0;
  std::uint64_t coincident_pairs = 0, stranger_touches = 0, stranger_contacts = 0;
  std::uint64_t crawls = 0, forces_from_outside = 0, hits = 0, random_axes = 0;
  std::map<std::string, std::uint64_t> deaths;  ///< by name of the cause

  void add(const Events& other);
};

struct World {
  const model::Ecosystem* ecosystem = nullptr;
  std::uint64_t seed = 0, step = 0, inhabited_steps = 0;
  bool finished = false;
  std::vector<Cell> cells;          ///< by ascending name
  std::vector<Organism> organisms;  ///< by ascending key
  std::vector<std::vector<double>> grids;
  std::vector<PlainTable> tables;
  std::vector<double> scalars, parameters;

  Mistake mistake = Mistake::none;
  Events events;

  [[nodiscard]] const model::Config& config() const { return ecosystem->config(); }
  [[nodiscard]] const model::Schema& schema() const { return ecosystem->schema(); }
  [[nodiscard]] Organism& organism_of(const Cell& cell) { return organisms[cell.name.organism]; }
  [[nodiscard]] const Organism& organism_of(const Cell& cell) const {
    return organisms[cell.name.organism];
  }
  [[nodiscard]] const model::State& state_of(const Cell& cell) const {
    return organism_of(cell).phenotype->tree->states[cell.state];
  }
  [[nodiscard]] const model::OutputChannels& outputs_of(const Cell& cell) const {
    return organism_of(cell).phenotype->ports->out();
  }
  /// The cell of that name, which must be there.
  [[nodiscard]] Cell& find(const Name& name);
  /// Places in `cells` by ascending (organism, state, id): the order in which plugins see cells.
  [[nodiscard]] std::vector<std::size_t> seen_order() const;
  /// In which energy is booked: that order, too.
  [[nodiscard]] std::vector<std::size_t> booking_order() const;
};

/// A controller's output read as a share: clamped to [0, 1], NaN as 0.
[[nodiscard]] double share(float output);

}  // namespace somas::reference
