#include "core/report/scene.hpp"

#include <algorithm>

#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

void choose_grid(const model::Schema& schema, const std::string& wanted, Setting& setting) {
  if (wanted == "none") return;
  std::vector<std::string> names;
  for (const model::GridDeclaration& grid : schema.grids)
    names.push_back(grid.owner + "." + grid.name);
  const auto found = wanted.empty() ? names.begin() : std::find(names.begin(), names.end(), wanted);
  if (found == names.end()) {
    if (wanted.empty()) return;
    throw run::UsageError("there is no grid '" + wanted + "'; grids: " + plugins::join(names) +
                          plugins::did_you_mean(wanted, names));
  }
  setting.grid = static_cast<Id>(found - names.begin());
  setting.grid_name = *found;
  setting.grid_spec = schema.grids[setting.grid].spec;
}

// Tables without both coordinates have no place in a picture.
void find_positions(const model::Schema& schema, Setting& setting) {
  for (Id id = 0; id < schema.tables.size(); ++id) {
    const std::vector<std::string>& columns = schema.tables[id].columns;
    const auto x = std::find(columns.begin(), columns.end(), "x");
    const auto y = std::find(columns.begin(), columns.end(), "y");
    if (x == columns.end() || y == columns.end()) continue;
    setting.position_columns.push_back({.table = id,
                                        .x = static_cast<Id>(x - columns.begin()),
                                        .y = static_cast<Id>(y - columns.begin())});
    setting.tables.push_back(schema.tables[id].owner + "." + schema.tables[id].name);
  }
}

const model::OrganismState& organism_at(const model::WorldState& world, std::size_t place) {
  return *std::find_if(world.organisms.begin(), world.organisms.end(),
                       [place](const auto& organism) { return organism.roster_index == place; });
}

// Each cell senses the morphogens of its own organism.
void take_morphogens(const model::WorldState& world, const SceneWants& wants, Scene& scene) {
  const model::MorphogenFields& own = organism_at(world, wants.organism).fields;
  const model::CellStore& cells = world.cells;
  for (std::size_t kind = 0; kind < own.kinds(); ++kind) {
    std::vector<float>& sensed = scene.sensed.emplace_back();
    for (const std::uint32_t i : cells.order) {
      const model::MorphogenFields& fields = world.organisms[cells.organism[i]].fields;
      sensed.push_back(fields.sense(kind, fields.footprint(cells.x[i], cells.y[i])));
    }
    std::vector<float>& grid = scene.morphogens.emplace_back();
    for (std::uint32_t row = 0; row < own.size(); ++row)
      for (std::uint32_t column = 0; column < own.size(); ++column)
        grid.push_back(own.value(kind, column, row));
  }
}

bool everywhere(const Zones::Zone& zone, double radius) {
  const GridSpec& grid = zone.spec;
  const bool covers = grid.left <= -radius && grid.bottom <= -radius &&
                      grid.left + grid.columns * grid.side >= radius &&
                      grid.bottom + grid.rows * grid.side >= radius;
  if (!covers) return false;
  for (std::uint32_t row = 0; row < grid.rows; ++row)
    for (std::uint32_t column = 0; column < grid.columns; ++column) {
      const double x = grid.left + (column + 0.5) * grid.side,
                   y = grid.bottom + (row + 0.5) * grid.side;
      const std::size_t square = static_cast<std::size_t>(row) * grid.columns + column;
      if (x * x + y * y < radius * radius && zone.squares[square] == 0) return false;
    }
  return true;
}

}  // namespace

std::uint32_t Scene::dividing() const {
  return static_cast<std::uint32_t>(
      std::count_if(cells.begin(), cells.end(), [](const SceneCell& c) { return c.dividing; }));
}

Setting setting_of(const model::Simulation& simulation, const SceneWants& wants) {
  const model::Schema& schema = simulation.ecosystem().schema();
  Setting setting;
  choose_grid(schema, wants.grid, setting);
  find_positions(schema, setting);
  // Organisms with other trees may share the world: a name is a state.
  std::vector<std::string>& states = setting.states;
  for (const model::OrganismState& organism : simulation.state().organisms)
    for (const model::State& state : organism.phenotype->tree->states)
      if (std::find(states.begin(), states.end(), state.name) == states.end())
        states.push_back(state.name);
  setting.outlines = schema.outlines;
  const model::Config& config = simulation.ecosystem().config();
  setting.radius = config.radius;
  setting.morphogens = config.morphogens.kinds.size();
  const double half = 0.5 * config.morphogens.size * config.morphogens.side;
  setting.morphogen_spec = {.columns = config.morphogens.size,
                            .rows = config.morphogens.size,
                            .side = config.morphogens.side,
                            .left = -half,
                            .bottom = -half};
  return setting;
}

Scene scene_of(const model::Simulation& simulation, const Setting& setting,
               const SceneWants& wants) {
  const model::WorldState& world = simulation.state();
  const model::CellStore& cells = world.cells;
  Scene scene;
  scene.step = world.step - 1;
  scene.counts.assign(setting.states.size(), 0);
  for (const std::uint32_t i : cells.order) {
    const auto named =
        std::find(setting.states.begin(), setting.states.end(), world.state_of(i).name);
    const auto state = static_cast<std::uint16_t>(named - setting.states.begin());
    ++scene.counts[state];
    scene.cells.push_back({.x = cells.x[i],
                           .y = cells.y[i],
                           .radius = cells.radius[i],
                           .energy = cells.energy[i],
                           .state = state,
                           .dividing = cells.action[i] == model::Action::division});
  }
  for (const Setting::PositionColumns& columns : setting.position_columns) {
    const model::TableStore& table = world.tables[columns.table];
    std::vector<Point>& points = scene.tables.emplace_back();
    for (std::uint32_t row = 0; row < table.rows(); ++row)
      points.push_back({table.column(columns.x)[row], table.column(columns.y)[row]});
  }
  if (setting.grid != no_id) scene.grid = world.grids[setting.grid];
  if (wants.morphogens) take_morphogens(world, wants, scene);
  return scene;
}

void Zones::observe(const model::Simulation& simulation) {
  const model::Schema& schema = simulation.ecosystem().schema();
  if (!begun_)
    for (const model::Resource& resource : schema.resources)
      zones_.push_back({.resource = resource.name,
                        .spec = schema.grids[resource.grid].spec,
                        .squares = std::vector<std::uint8_t>(
                            simulation.state().grids[resource.grid].size(), 0)});
  begun_ = true;
  const double radius = simulation.ecosystem().config().radius;
  for (std::size_t z = 0; z < zones_.size(); ++z) {
    Zone& zone = zones_[z];
    if (zone.everywhere) continue;
    const std::vector<double>& content = simulation.state().grids[schema.resources[z].grid];
    for (std::size_t i = 0; i < content.size(); ++i)
      if (content[i] > 0) zone.squares[i] = 1;
    zone.everywhere = everywhere(zone, radius);
  }
}

}  // namespace somas::report
