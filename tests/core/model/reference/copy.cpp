// Takes over the state of an engine's life.
#include "tests/core/model/reference/compare.hpp"

namespace somas::reference {

namespace {

Sum copy_of(const model::Sum& sum) { return {sum.sum(), sum.error()}; }

Ledger copy_of(const model::Ledger& ledger) {
  return {
      ledger.founder_ambrosia,         ledger.founder_energy,         copy_of(ledger.taken),
      copy_of(ledger.burnt),           copy_of(ledger.given),         copy_of(ledger.received),
      copy_of(ledger.lost_efficiency), copy_of(ledger.lost_overflow), copy_of(ledger.lost_death),
      copy_of(ledger.lost_outside),    copy_of(ledger.spent),         copy_of(ledger.energy_lost)};
}

std::vector<Field> copy_of(const model::MorphogenFields& fields, const model::MorphogenGrid& grid) {
  std::vector<Field> copies;
  for (std::size_t m = 0; m < fields.kinds(); ++m) {
    Field& copy = copies.emplace_back(Field{fields.size(), grid.side, {}});
    for (std::uint32_t row = 0; row < fields.size(); ++row)
      for (std::uint32_t column = 0; column < fields.size(); ++column)
        copy.squares.push_back(fields.value(m, column, row));
  }
  return copies;
}

Organism copy_of(const model::OrganismState& organism, const model::MorphogenGrid& grid) {
  return {.key = organism.key,
          .roster_index = organism.roster_index,
          .phenotype = organism.phenotype,
          .next_id = organism.next_id,
          .live = organism.live,
          .fields = copy_of(organism.fields, grid),
          .ledger = copy_of(organism.ledger),
          .outcome = organism.outcome,
          .shares = organism.shares,
          .deaths = organism.deaths};
}

Cell copy_of(const model::WorldState& state, std::uint32_t i) {
  const model::CellStore& cells = state.cells;
  Cell cell{.name = {cells.organism[i], cells.id[i]},
            .state = cells.state[i],
            .x = cells.x[i],
            .y = cells.y[i],
            .vx = cells.vx[i],
            .vy = cells.vy[i],
            .radius = cells.radius[i],
            .energy = cells.energy[i],
            .ambrosia = cells.ambrosia[i],
            .pressure = cells.pressure[i],
            .stress_xx = cells.stress_xx[i],
            .stress_xy = cells.stress_xy[i],
            .stress_yy = cells.stress_yy[i],
            .parent = cells.parent[i],
            .born = cells.born[i],
            .action = static_cast<Action>(cells.action[i]),
            .target = cells.target[i],
            .remaining = cells.remaining[i],
            .dead = cells.dead[i] != 0,
            .cause = cells.cause[i]};
  for (const std::vector<double>& column : cells.values) cell.values.push_back(column[i]);
  for (const std::vector<double>& column : cells.damage) cell.damage.push_back(column[i]);
  for (std::uint32_t row = 0; row < cells.memory.channels(); ++row)
    cell.memory.push_back(cells.memory.row(row)[i]);
  for (const std::uint32_t j : state.contacts.of(i))
    cell.contacts.push_back({cells.organism[j], cells.id[j]});
  return cell;
}

}  // namespace

World copy_of(const model::Simulation& simulation) {
  const model::WorldState& state = simulation.state();
  World world;
  world.ecosystem = &simulation.ecosystem();
  world.seed = state.seed;
  world.step = state.step;
  world.inhabited_steps = state.inhabited_steps;
  world.finished = state.finished;
  for (const std::uint32_t i : state.cells.order) world.cells.push_back(copy_of(state, i));
  for (const model::OrganismState& organism : state.organisms)
    world.organisms.push_back(copy_of(organism, world.config().morphogens));
  world.grids = state.grids;
  for (const model::TableStore& table : state.tables) {
    PlainTable& copy = world.tables.emplace_back(table.columns());
    copy.resize(table.rows());
    for (Id c = 0; c < table.columns(); ++c)
      copy.columns[c].assign(table.column(c).begin(), table.column(c).end());
  }
  world.scalars = state.scalars;
  world.parameters = state.parameters;
  return world;
}

void Twins::adopt() {
  const Mistake mistake = reference_.mistake;
  const Events events = reference_.events;
  reference_ = copy_of(engine_);
  reference_.mistake = mistake;
  reference_.events = events;
}

}  // namespace somas::reference
