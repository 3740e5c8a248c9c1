#include "core/recording/header.hpp"

#include <string_view>

namespace somas::recording {
namespace {

std::string full_name(const std::string& owner, const std::string& name) {
  return owner + "." + name;
}

Organism organism_of(const model::OrganismState& organism, std::uint32_t first_slot) {
  Organism described{.key = organism.key,
                     .seat = organism.roster_index,
                     .states = {},
                     .outputs = {},
                     .first_slot = first_slot};
  for (const model::State& state : organism.phenotype->tree->states)
    described.states.push_back({.name = state.name,
                                .parent = state.parent == no_state ? none : state.parent,
                                .radius = state.radius,
                                .capacity = state.skill(model::skill_capacity)});
  for (const Port& port : organism.phenotype->ports->layout().outputs)
    described.outputs.emplace_back(port.name);
  return described;
}

/// Every state has the same inputs; their names are told without the state's.
std::vector<std::string> inputs_of(const Layout& layout) {
  std::vector<std::string> names;
  const std::size_t prefix = layout.states[0].name.size() + 1;
  for (const Port& port : layout.inputs)
    if (port.state == 0) names.emplace_back(port.name.substr(prefix));
  return names;
}

Grid grid_of(const std::string& name, const GridSpec& spec) {
  return {.name = name,
          .columns = spec.columns,
          .rows = spec.rows,
          .side = spec.side,
          .left = spec.left,
          .bottom = spec.bottom,
          .resource = {}};
}

Grid morphogen_grid_of(const model::MorphogenGrid& grid) {
  const double low = -0.5 * grid.side * grid.size;
  return {.name = "morphogens",
          .columns = grid.size,
          .rows = grid.size,
          .side = grid.side,
          .left = low,
          .bottom = low,
          .resource = {}};
}

}  // namespace

Header header_of(const model::Ecosystem& ecosystem, const model::WorldState& world) {
  const model::Schema& schema = ecosystem.schema();
  const model::Config& config = ecosystem.config();
  Header header;
  header.seed = world.seed;
  header.radius = config.radius;
  header.max_steps = config.max_steps;
  header.first_step = world.step;
  for (const model::OrganismState& organism : world.organisms)
    header.organisms.push_back(organism_of(organism, header.slots()));
  header.actions = {"none", "quiescence", "division", "specialization", "apoptosis"};
  header.causes = schema.causes;
  for (const model::Hazard& hazard : schema.hazards)
    header.hazards.push_back(schema.causes[hazard.cause]);
  for (const model::CellValue& value : schema.cell_values)
    header.values.push_back(full_name(value.owner, value.name));
  header.inputs = inputs_of(world.organisms[0].phenotype->ports->layout());
  for (std::size_t kind = 0; kind < config.morphogens.kinds.size(); ++kind)
    header.morphogens.push_back("morphogen." + std::to_string(kind));
  header.morphogen_grid = morphogen_grid_of(config.morphogens);
  for (const model::GridDeclaration& grid : schema.grids)
    header.grids.push_back(grid_of(full_name(grid.owner, grid.name), grid.spec));
  for (const model::Resource& resource : schema.resources)
    header.grids[resource.grid].resource = resource.name;
  for (const model::TableDeclaration& table : schema.tables)
    header.tables.push_back({full_name(table.owner, table.name), table.columns});
  for (const model::Outline& outline : schema.outlines) {
    Outline& drawn = header.outlines.emplace_back();
    drawn.name = full_name(outline.owner, outline.name);
    drawn.closed = outline.closed;
    for (const Point& point : outline.points) {
      drawn.x.push_back(point.x);
      drawn.y.push_back(point.y);
    }
  }
  return header;
}

std::vector<std::uint32_t> squares_in_world(const Grid& grid, double radius) {
  std::vector<std::uint32_t> inside;
  for (std::uint32_t square = 0; square < grid.squares(); ++square) {
    const double x = grid.left + (square % grid.columns + 0.5) * grid.side;
    const double y = grid.bottom + (square / grid.columns + 0.5) * grid.side;
    if (x * x + y * y <= radius * radius) inside.push_back(square);
  }
  return inside;
}

}  // namespace somas::recording
