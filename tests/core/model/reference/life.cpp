#include "tests/core/model/reference/life.hpp"

#include <algorithm>

#include "tests/core/model/reference/fields.hpp"
#include "tests/core/model/reference/phases.hpp"

namespace somas::reference {

namespace {

void update_fields(World& world) {
  act(Phase::parameters, world);
  act(Phase::fields, world);
  const std::vector<model::Morphogen>& kinds = world.config().morphogens.kinds;
  for (Organism& organism : world.organisms) {
    if (organism.live == 0) continue;
    for (std::size_t m = 0; m < kinds.size(); ++m)
      evaporate_and_spread(kinds[m], world.mistake, organism.fields[m]);
  }
}

void sense(World& world) {
  for (Cell& cell : world.cells) {
    const double capacity = world.state_of(cell).skill(model::skill_capacity);
    cell.inputs.clear();
    for (const Field& field : world.organism_of(cell).fields)
      cell.inputs.push_back(sense(field, cell.x, cell.y));
    cell.inputs.push_back(static_cast<float>(cell.pressure));
    cell.inputs.push_back(static_cast<float>(cell.energy));
    cell.inputs.push_back(capacity > 0 ? static_cast<float>(cell.ambrosia / capacity) : 0.0f);
    cell.inputs.resize(cell.inputs.size() + world.schema().sensors.size(), 0.0f);
  }
  act(Phase::sense, world);
}

void deposit(World& world) {
  for (const Cell& cell : world.cells) {
    if (cell.dead) continue;
    std::vector<Field>& fields = world.organism_of(cell).fields;
    const std::vector<std::uint32_t>& channels = world.outputs_of(cell).morphogens;
    for (std::size_t m = 0; m < fields.size(); ++m) {
      const auto production = static_cast<float>(share(cell.outputs[channels[m]]));
      deposit(world.config().morphogens.deposit, cell.x, cell.y, production, fields[m]);
    }
  }
}

void join(std::vector<Cell> newborn, World& world) {
  for (Cell& cell : newborn) world.cells.push_back(std::move(cell));
  std::sort(world.cells.begin(), world.cells.end(),
            [](const Cell& a, const Cell& b) { return a.name < b.name; });
}

void book_death(World& world, const Cell& cell) {
  Organism& organism = world.organism_of(cell);
  ++organism.deaths[cell.cause];
  ++world.events.deaths[world.schema().causes[cell.cause]];
  Sum& lost = cell.cause == model::cause_outside ? organism.ledger.lost_outside
                                                 : organism.ledger.lost_death;
  lost.add(cell.ambrosia);
  organism.ledger.energy_lost.add(cell.energy);
  --organism.live;
  if (organism.live > 0) return;
  organism.outcome.survival = world.step;
  organism.fields = empty_fields(world.config().morphogens);
}

void bury(World& world) {
  const double limit = world.config().radius * world.config().radius;
  for (Cell& cell : world.cells) {
    const bool inside = cell.x * cell.x + cell.y * cell.y <= limit;
    if (!inside) cell.kill(model::cause_outside);
    if (cell.dead) book_death(world, cell);
  }
  std::vector<Cell> survivors;
  for (const Cell& cell : world.cells)
    if (!cell.dead) survivors.push_back(cell);
  world.cells = std::move(survivors);

  std::vector<Name> names;
  for (const Cell& cell : world.cells) names.push_back(cell.name);
  for (Cell& cell : world.cells)
    std::erase_if(cell.contacts, [&](const Name& name) {
      return !std::binary_search(names.begin(), names.end(), name);
    });
}

void finish(World& world) {
  world.finished = true;
  for (Organism& organism : world.organisms) {
    organism.outcome.final_cells = organism.live;
    if (world.inhabited_steps > 0)
      organism.outcome.biomass_share = organism.shares / static_cast<double>(world.inhabited_steps);
    if (organism.live == 0) continue;
    organism.outcome.censored = true;
    organism.outcome.survival = world.step;
  }
}

void end_step(World& world) {
  std::uint32_t living = 0;
  for (Organism& organism : world.organisms) {
    living += organism.live;
    organism.outcome.cell_steps += organism.live;
    organism.outcome.peak_cells = std::max(organism.outcome.peak_cells, organism.live);
  }
  if (living > 0) {
    ++world.inhabited_steps;
    for (Organism& organism : world.organisms)
      organism.shares += static_cast<double>(organism.live) / living;
  }
  const bool stopped = observe(world);
  ++world.step;
  ++world.events.steps;
  world.events.cell_steps += living;
  if (living == 0 || stopped || world.step >= world.config().max_steps) finish(world);
}

}  // namespace

World found(const model::Ecosystem& ecosystem, std::span<const model::RosterEntry> roster,
            std::uint64_t seed) {
  const model::Schema& schema = ecosystem.schema();
  World world;
  world.ecosystem = &ecosystem;
  world.seed = seed;

  std::uint32_t memory_rows = 0;
  for (std::uint32_t r = 0; r < roster.size(); ++r) {
    Organism& organism = world.organisms.emplace_back();
    organism.key = roster[r].key;
    organism.roster_index = r;
    organism.phenotype = roster[r].phenotype;
    organism.next_id = 1;
    organism.live = 1;
    organism.fields = empty_fields(ecosystem.config().morphogens);
    organism.deaths.assign(schema.causes.size(), 0);
    organism.outcome.peak_cells = 1;
    memory_rows = std::max(memory_rows, organism.phenotype->program->memory_per_cell());
  }
  std::sort(world.organisms.begin(), world.organisms.end(),
            [](const Organism& a, const Organism& b) { return a.key < b.key; });

  const model::Metabolism& start = ecosystem.config().metabolism;
  for (std::size_t k = 0; k < world.organisms.size(); ++k) {
    Organism& organism = world.organisms[k];
    const model::State& root = organism.phenotype->tree->states[0];
    Cell& founder = world.cells.emplace_back();
    founder.name = {static_cast<std::uint16_t>(k), 0};
    founder.x = roster[organism.roster_index].x;
    founder.y = roster[organism.roster_index].y;
    founder.radius = root.radius;
    founder.energy = start.founder_energy;
    founder.ambrosia = std::min(start.founder_ambrosia, root.skill(model::skill_capacity));
    founder.values.assign(schema.cell_values.size(), 0.0);
    founder.damage.assign(schema.hazards.size(), 0.0);
    founder.memory.assign(memory_rows, 0.0f);
    organism.ledger.founder_energy = founder.energy;
    organism.ledger.founder_ambrosia = founder.ambrosia;
  }

  for (const model::GridDeclaration& grid : schema.grids)
    world.grids.emplace_back(std::size_t{grid.spec.columns} * grid.spec.rows, grid.spec.initial);
  for (const model::TableDeclaration& table : schema.tables)
    world.tables.emplace_back(table.columns.size());
  for (const model::Scalar& scalar : schema.scalars) world.scalars.push_back(scalar.initial);
  for (const model::VariableParameter& p : schema.parameters)
    world.parameters.push_back(p.spec.value);
  begin_environments(world);
  return world;
}

void step(World& world) {
  update_fields(world);
  sense(world);
  control(world);
  decide(world);
  take_up(world);
  convert(world);
  diffuse(world);
  pay(world);
  std::vector<Cell> newborn = advance(world);
  deposit(world);
  join(std::move(newborn), world);
  move(world);
  act(Phase::stress, world);
  bury(world);
  end_step(world);
}

std::vector<Outcome> outcomes_of(const World& world) {
  std::vector<Outcome> outcomes(world.organisms.size());
  for (const Organism& organism : world.organisms)
    outcomes[organism.roster_index] = organism.outcome;
  return outcomes;
}

}  // namespace somas::reference
