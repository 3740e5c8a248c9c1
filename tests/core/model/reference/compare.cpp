#include "tests/core/model/reference/compare.hpp"

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <type_traits>

namespace somas::reference {

namespace {

template <class T>
bool same(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b) || (std::isnan(a) && std::isnan(b));
  } else {
    return a == b;
  }
}

template <class T>
std::string shown(T value) {
  if constexpr (!std::is_floating_point_v<T>) return std::to_string(value);
  char text[80];
  const int digits = std::numeric_limits<T>::max_digits10;
  const auto number = static_cast<double>(value);
  std::snprintf(text, sizeof text, "%.*g (%a)", digits, number, number);
  return text;
}

/// Looks at pairs of numbers and keeps the first that differ.
class Comparison {
 public:
  explicit Comparison(std::uint64_t step) : step_(step) {}

  [[nodiscard]] bool different() const { return first_.has_value(); }
  [[nodiscard]] const std::optional<Difference>& first() const { return first_; }
  void of(std::string subject) { subject_ = std::move(subject); }

  template <class T, class U>
  void look(const char* what, T engine, U reference) {
    static_assert(std::is_same_v<T, U> || (std::is_integral_v<T> && std::is_integral_v<U>));
    if (different() || same(engine, static_cast<T>(reference))) return;
    first_ = {step_, subject_ + what, shown(engine), shown(static_cast<T>(reference))};
  }
  void look(const char* what, const model::Sum& engine, const Sum& reference) {
    look((std::string(what) + ", the sum").c_str(), engine.sum(), reference.sum);
    look((std::string(what) + ", its error").c_str(), engine.error(), reference.error);
  }
  template <class T>
  void look_at_all(const char* what, std::span<const T> engine, std::span<const T> reference) {
    look((std::string(what) + ", how many").c_str(), engine.size(), reference.size());
    for (std::size_t i = 0; i < engine.size() && !different(); ++i)
      if (!same(engine[i], reference[i]))
        look((std::string(what) + " " + std::to_string(i)).c_str(), engine[i], reference[i]);
  }

 private:
  std::uint64_t step_;
  std::string subject_;
  std::optional<Difference> first_;
};

void compare_cell(const model::WorldState& state, std::uint32_t i, const Cell& cell,
                  Comparison& comparison) {
  const model::CellStore& cells = state.cells;
  comparison.of("cell " + std::to_string(cell.name.id) + " of organism " +
                std::to_string(cell.name.organism) + ": ");
  const auto look = [&](const char* what, auto engine, auto reference) {
    comparison.look(what, engine, reference);
  };
  look("state", cells.state[i], cell.state);
  look("vx", cells.vx[i], cell.vx);
  look("vy", cells.vy[i], cell.vy);
  look("x", cells.x[i], cell.x);
  look("y", cells.y[i], cell.y);
  look("radius", cells.radius[i], cell.radius);
  look("energy", cells.energy[i], cell.energy);
  look("ambrosia", cells.ambrosia[i], cell.ambrosia);
  look("pressure", cells.pressure[i], cell.pressure);
  look("stress_xx", cells.stress_xx[i], cell.stress_xx);
  look("stress_xy", cells.stress_xy[i], cell.stress_xy);
  look("stress_yy", cells.stress_yy[i], cell.stress_yy);
  look("parent", cells.parent[i], cell.parent);
  look("born", cells.born[i], cell.born);
  look("action", static_cast<unsigned>(cells.action[i]), static_cast<unsigned>(cell.action));
  look("target", cells.target[i], cell.target);
  look("remaining", cells.remaining[i], cell.remaining);
  look("dead", cells.dead[i] != 0 ? 1 : 0, cell.dead ? 1 : 0);
  look("cause", cells.cause[i], cell.cause);
  for (std::size_t v = 0; v < cell.values.size(); ++v)
    look("cell value", cells.values[v][i], cell.values[v]);
  for (std::size_t h = 0; h < cell.damage.size(); ++h)
    look("damage", cells.damage[h][i], cell.damage[h]);
  look("memory, rows", cells.memory.channels(), cell.memory.size());
  for (std::uint32_t row = 0; row < cell.memory.size(); ++row)
    look("memory", cells.memory.row(row)[i], cell.memory[row]);

  const std::span<const std::uint32_t> contacts = state.contacts.of(i);
  look("contacts, how many", contacts.size(), cell.contacts.size());
  for (std::size_t k = 0; k < contacts.size() && !comparison.different(); ++k) {
    look("contact's organism", cells.organism[contacts[k]], cell.contacts[k].organism);
    look("contact's id", cells.id[contacts[k]], cell.contacts[k].id);
  }
}

void compare_cells(const model::WorldState& state, const World& world, Comparison& comparison) {
  const model::CellStore& cells = state.cells;
  comparison.of("cells: ");
  comparison.look("how many", std::size_t{cells.size()}, world.cells.size());
  for (std::size_t k = 0; k < world.cells.size() && !comparison.different(); ++k) {
    const std::uint32_t i = cells.order[k];
    comparison.of("cell at place " + std::to_string(k) + ": ");
    comparison.look("organism", cells.organism[i], world.cells[k].name.organism);
    comparison.look("id", cells.id[i], world.cells[k].name.id);
    compare_cell(state, i, world.cells[k], comparison);
  }
  if (comparison.different()) return;
  const std::vector<std::size_t> seen = world.seen_order();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    comparison.of("cell in storage at " + std::to_string(i) + ": ");
    comparison.look("organism", cells.organism[i], world.cells[seen[i]].name.organism);
    comparison.look("id", cells.id[i], world.cells[seen[i]].name.id);
  }
}

void compare_outcomes(const Outcome& engine, const Outcome& reference, Comparison& comparison) {
  comparison.look("survival", engine.survival, reference.survival);
  comparison.look("censored", engine.censored ? 1 : 0, reference.censored ? 1 : 0);
  comparison.look("divisions", engine.divisions, reference.divisions);
  comparison.look("specializations", engine.specializations, reference.specializations);
  comparison.look("refused divisions", engine.refused_divisions, reference.refused_divisions);
  comparison.look("final cells", engine.final_cells, reference.final_cells);
  comparison.look("peak cells", engine.peak_cells, reference.peak_cells);
  comparison.look("cell steps", engine.cell_steps, reference.cell_steps);
  comparison.look("biomass share", engine.biomass_share, reference.biomass_share);
}

void compare_ledgers(const model::Ledger& engine, const Ledger& reference, Comparison& comparison) {
  comparison.look("founder's ambrosia", engine.founder_ambrosia, reference.founder_ambrosia);
  comparison.look("founder's energy", engine.founder_energy, reference.founder_energy);
  comparison.look("taken", engine.taken, reference.taken);
  comparison.look("burnt", engine.burnt, reference.burnt);
  comparison.look("given", engine.given, reference.given);
  comparison.look("received", engine.received, reference.received);
  comparison.look("lost by efficiency", engine.lost_efficiency, reference.lost_efficiency);
  comparison.look("lost above capacity", engine.lost_overflow, reference.lost_overflow);
  comparison.look("lost by death", engine.lost_death, reference.lost_death);
  comparison.look("lost outside", engine.lost_outside, reference.lost_outside);
  comparison.look("spent", engine.spent, reference.spent);
  comparison.look("energy lost", engine.energy_lost, reference.energy_lost);
}

void compare_fields(const model::MorphogenFields& engine, const std::vector<Field>& reference,
                    Comparison& comparison) {
  comparison.look("morphogens", engine.kinds(), reference.size());
  for (std::size_t m = 0; m < reference.size(); ++m)
    for (std::uint32_t row = 0; row < engine.size(); ++row)
      for (std::uint32_t column = 0; column < engine.size() && !comparison.different(); ++column)
        if (!same(engine.value(m, column, row), reference[m].at(column, row)))
          comparison.look(("morphogen " + std::to_string(m) + " at column " +
                           std::to_string(column) + ", row " + std::to_string(row))
                              .c_str(),
                          engine.value(m, column, row), reference[m].at(column, row));
}

void compare_organisms(const model::WorldState& state, const World& world, Comparison& comparison) {
  comparison.of("organisms: ");
  comparison.look("how many", state.organisms.size(), world.organisms.size());
  for (std::size_t k = 0; k < world.organisms.size() && !comparison.different(); ++k) {
    const model::OrganismState& engine = state.organisms[k];
    const Organism& reference = world.organisms[k];
    comparison.of("organism " + std::to_string(k) + ": ");
    comparison.look("key", engine.key, reference.key);
    comparison.look("place in the roster", engine.roster_index, reference.roster_index);
    comparison.look("next id", engine.next_id, reference.next_id);
    comparison.look("live", engine.live, reference.live);
    comparison.look("shares", engine.shares, reference.shares);
    comparison.look_at_all<std::uint64_t>("deaths by cause", engine.deaths, reference.deaths);
    compare_outcomes(engine.outcome, reference.outcome, comparison);
    compare_ledgers(engine.ledger, reference.ledger, comparison);
    compare_fields(engine.fields, reference.fields, comparison);
  }
}

void compare_surroundings(const model::WorldState& state, const World& world,
                          Comparison& comparison) {
  const model::Schema& schema = world.schema();
  for (std::size_t g = 0; g < world.grids.size(); ++g) {
    comparison.of("grid " + schema.grids[g].owner + "." + schema.grids[g].name + ": ");
    comparison.look_at_all<double>("square", state.grids[g], world.grids[g]);
  }
  for (std::size_t t = 0; t < world.tables.size(); ++t) {
    comparison.of("table " + schema.tables[t].owner + "." + schema.tables[t].name + ": ");
    for (Id c = 0; c < world.tables[t].columns.size(); ++c)
      comparison.look_at_all<double>((schema.tables[t].columns[c] + " of row").c_str(),
                                     state.tables[t].column(c), world.tables[t].columns[c]);
  }
  comparison.of("world: ");
  comparison.look_at_all<double>("scalar", state.scalars, world.scalars);
  comparison.look_at_all<double>("parameter", state.parameters, world.parameters);
  comparison.look("seed", state.seed, world.seed);
  comparison.look("step", state.step, world.step);
  comparison.look("inhabited steps", state.inhabited_steps, world.inhabited_steps);
  comparison.look("finished", state.finished ? 1 : 0, world.finished ? 1 : 0);
}

}  // namespace

std::string Difference::text() const {
  return "after step " + std::to_string(step) + ", " + what + ": engine " + engine +
         ", reference " + reference;
}

std::optional<Difference> compare(const model::Simulation& simulation, const World& world) {
  const model::WorldState& state = simulation.state();
  Comparison comparison(state.step == 0 ? 0 : state.step - 1);
  compare_cells(state, world, comparison);
  compare_organisms(state, world, comparison);
  compare_surroundings(state, world, comparison);
  if (comparison.different()) return comparison.first();
  comparison.of("world: ");
  comparison.look("hash", simulation.hash(), hash_of(world));
  const std::vector<Outcome> engine = simulation.outcomes(), reference = outcomes_of(world);
  for (std::size_t r = 0; r < reference.size(); ++r) {
    comparison.of("place " + std::to_string(r) + " of the roster: ");
    compare_outcomes(engine[r], reference[r], comparison);
  }
  return comparison.first();
}

Twins::Twins(const model::Ecosystem& ecosystem, std::span<const model::RosterEntry> roster,
             std::uint64_t seed)
    : engine_(ecosystem, roster, seed), reference_(found(ecosystem, roster, seed)) {}

std::optional<Difference> Twins::step() {
  // The reference first: scripted controllers of tests look at the engine's world.
  reference::step(reference_);
  engine_.step();
  return compare(engine_, reference_);
}

std::optional<Difference> Twins::run(std::uint64_t steps) {
  for (std::uint64_t s = 0; s < steps && !engine_.finished(); ++s)
    if (auto difference = step()) return difference;
  return {};
}

std::optional<Difference> compare_lives(const model::Ecosystem& ecosystem,
                                        std::span<const model::RosterEntry> roster,
                                        std::uint64_t seed, std::uint64_t steps, Events* events) {
  Twins twins(ecosystem, roster, seed);
  std::optional<Difference> difference = compare(twins.engine(), twins.reference());
  if (!difference) difference = twins.run(steps);
  if (events != nullptr) events->add(twins.reference().events);
  return difference;
}

}  // namespace somas::reference
