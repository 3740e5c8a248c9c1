#include "core/report/scene.hpp"

#include <algorithm>

#include "core/plugins/suggest.hpp"
#include "core/recording/header.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

GridSpec spec_of(const recording::Grid& grid) {
  return {.columns = grid.columns,
          .rows = grid.rows,
          .side = grid.side,
          .left = grid.left,
          .bottom = grid.bottom};
}

void choose_grid(const recording::Header& header, const std::string& wanted, Setting& setting) {
  if (wanted == "none") return;
  std::vector<std::string> names;
  for (const recording::Grid& grid : header.grids) names.push_back(grid.name);
  const auto found = wanted.empty() ? names.begin() : std::find(names.begin(), names.end(), wanted);
  if (found == names.end()) {
    if (wanted.empty()) return;
    throw run::UsageError("there is no grid '" + wanted + "'; grids: " + plugins::join(names) +
                          plugins::did_you_mean(wanted, names));
  }
  setting.grid = static_cast<Id>(found - names.begin());
  setting.grid_name = *found;
  setting.grid_spec = spec_of(header.grids[setting.grid]);
}

// Tables without both coordinates have no place in a picture.
void find_positions(const recording::Header& header, Setting& setting) {
  for (Id id = 0; id < header.tables.size(); ++id) {
    const std::vector<std::string>& columns = header.tables[id].columns;
    const auto x = std::find(columns.begin(), columns.end(), "x");
    const auto y = std::find(columns.begin(), columns.end(), "y");
    if (x == columns.end() || y == columns.end()) continue;
    setting.position_columns.push_back({.table = id,
                                        .x = static_cast<Id>(x - columns.begin()),
                                        .y = static_cast<Id>(y - columns.begin())});
    setting.tables.push_back(header.tables[id].name);
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

/// The fields of the model, as they stood in a frame.
model::MorphogenFields fields_of(const recording::Header& header,
                                 const std::vector<std::vector<float>>& concentrations) {
  const std::uint32_t size = header.morphogen_grid.columns;
  model::MorphogenGrid grid;
  grid.size = size;
  grid.side = header.morphogen_grid.side;
  grid.kinds.resize(concentrations.size());
  model::MorphogenFields fields(grid);
  for (std::size_t kind = 0; kind < concentrations.size(); ++kind)
    for (std::uint32_t square = 0; square < concentrations[kind].size(); ++square)
      if (const float content = concentrations[kind][square]; content != 0)
        fields.set(kind, square % size, square / size, content);
  return fields;
}

void take_morphogens(const recording::Header& header, const recording::Frame& frame,
                     const SceneWants& wants, Scene& scene) {
  for (std::size_t o = 0; o < header.organisms.size(); ++o)
    if (header.organisms[o].seat == wants.organism) scene.morphogens = frame.morphogens[o];
  scene.sensed.resize(scene.morphogens.size());
  std::vector<model::MorphogenFields> fields;
  for (const auto& concentrations : frame.morphogens)
    fields.push_back(fields_of(header, concentrations));
  const recording::Cells& cells = frame.cells;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const model::MorphogenFields& own = fields[cells.organism[i]];
    const model::Footprint print = own.footprint(cells.x[i], cells.y[i]);
    for (std::size_t kind = 0; kind < scene.sensed.size(); ++kind)
      scene.sensed[kind].push_back(own.sense(kind, print));
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

Setting setting_of(const recording::Header& header, const SceneWants& wants) {
  Setting setting;
  choose_grid(header, wants.grid, setting);
  find_positions(header, setting);
  // Organisms with other trees may share the world: a name is a state.
  std::vector<std::string>& states = setting.states;
  for (const recording::Organism& organism : header.organisms)
    for (const recording::State& state : organism.states)
      if (std::find(states.begin(), states.end(), state.name) == states.end())
        states.push_back(state.name);
  if (header.organisms.size() > 1)
    for (std::size_t o = 0; o < header.organisms.size(); ++o)
      setting.organisms.push_back(
          "organism " + std::to_string(o + 1) +
          (header.organisms[o].seat == wants.organism ? " (the champion)" : ""));
  setting.outlines = header.outlines;
  setting.radius = header.radius;
  setting.morphogens = header.morphogens.size();
  setting.morphogen_spec = spec_of(header.morphogen_grid);
  return setting;
}

Setting setting_of(const model::Simulation& simulation, const SceneWants& wants) {
  return setting_of(recording::header_of(simulation.ecosystem(), simulation.state()), wants);
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
                           .organism = cells.organism[i],
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

Scene scene_of(const recording::Header& header, const recording::Frame& frame,
               const Setting& setting, const SceneWants& wants) {
  const recording::Cells& cells = frame.cells;
  Scene scene;
  scene.step = frame.step;
  scene.counts.assign(setting.states.size(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string& name = header.organisms[cells.organism[i]].states[cells.state[i]].name;
    const auto named = std::find(setting.states.begin(), setting.states.end(), name);
    const auto state = static_cast<std::uint16_t>(named - setting.states.begin());
    ++scene.counts[state];
    scene.cells.push_back({.x = cells.x[i],
                           .y = cells.y[i],
                           .radius = cells.radius[i],
                           .energy = cells.energy[i],
                           .state = state,
                           .organism = cells.organism[i],
                           .dividing = header.actions[cells.action[i]] == "division"});
  }
  for (const Setting::PositionColumns& columns : setting.position_columns) {
    const recording::TableRows& table = frame.tables[columns.table];
    std::vector<Point>& points = scene.tables.emplace_back();
    for (std::size_t row = 0; row < table.columns[columns.x].size(); ++row)
      points.push_back({table.columns[columns.x][row], table.columns[columns.y][row]});
  }
  if (!frame.has_fields) return scene;
  if (setting.grid != no_id)
    scene.grid.assign(frame.grids[setting.grid].begin(), frame.grids[setting.grid].end());
  if (wants.morphogens) take_morphogens(header, frame, wants, scene);
  return scene;
}

void Zones::begin(const recording::Header& header) {
  begun_ = true;
  for (std::size_t g = 0; g < header.grids.size(); ++g) {
    if (header.grids[g].resource.empty()) continue;
    zones_.push_back({.resource = header.grids[g].resource,
                      .spec = spec_of(header.grids[g]),
                      .squares = std::vector<std::uint8_t>(header.grids[g].squares(), 0)});
    grids_.push_back(g);
  }
}

template <class Contents>
void Zones::look(const Contents& grids, double radius) {
  for (std::size_t z = 0; z < zones_.size(); ++z) {
    Zone& zone = zones_[z];
    if (zone.everywhere) continue;
    const auto& content = grids[grids_[z]];
    for (std::size_t i = 0; i < content.size(); ++i)
      if (content[i] > 0) zone.squares[i] = 1;
    zone.everywhere = everywhere(zone, radius);
  }
}

void Zones::observe(const model::Simulation& simulation) {
  if (!begun_) begin(recording::header_of(simulation.ecosystem(), simulation.state()));
  look(simulation.state().grids, simulation.ecosystem().config().radius);
}

void Zones::observe(const recording::Header& header, const recording::Frame& frame) {
  if (!begun_) begin(header);
  if (frame.has_fields) look(frame.grids, header.radius);
}

}  // namespace somas::report
