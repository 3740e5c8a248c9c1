#include "core/report/picture.hpp"

#include <algorithm>

#include "core/plugins/suggest.hpp"
#include "core/report/painter.hpp"
#include "core/run/errors.hpp"

namespace somas::report {

PictureFormat picture_format(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension == ".svg") return PictureFormat::svg;
  if (extension == ".pdf") return PictureFormat::pdf;
  if (extension == ".png") return PictureFormat::png;
  throw run::UsageError(file.string() + ": the name of a picture ends in .svg, .pdf or .png");
}

std::uint32_t Panel::dividing() const {
  return static_cast<std::uint32_t>(
      std::count_if(cells.begin(), cells.end(), [](const Disc& cell) { return cell.dividing; }));
}

Picture::Picture(PictureOptions options) : options_(std::move(options)) {
  std::vector<std::uint64_t>& steps = options_.steps;
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  if (steps.empty()) throw run::UsageError("a picture needs at least one step");
  if (options_.width / steps.size() < least_panel_width)
    throw run::UsageError("a picture of " + plugins::plural(steps.size(), "step") +
                          " needs a width of at least " +
                          std::to_string(steps.size() * least_panel_width));
}

void Picture::observe(const model::Simulation& simulation) {
  if (!described_) describe(simulation);
  last_step_ = simulation.state().step - 1;
  if (std::binary_search(options_.steps.begin(), options_.steps.end(), last_step_))
    panels_.push_back(capture(simulation.state()));
}

void Picture::describe(const model::Simulation& simulation) {
  const model::Schema& schema = simulation.ecosystem().schema();
  choose_grid(schema);
  // Organisms with other trees may share the world: a name is a state.
  for (const model::OrganismState& organism : simulation.state().organisms)
    for (const model::State& state : organism.phenotype->tree->states)
      if (std::find(states_.begin(), states_.end(), state.name) == states_.end())
        states_.push_back(state.name);
  for (Id id = 0; id < schema.tables.size(); ++id) {
    const std::vector<std::string>& columns = schema.tables[id].columns;
    const auto x = std::find(columns.begin(), columns.end(), "x");
    const auto y = std::find(columns.begin(), columns.end(), "y");
    if (x == columns.end() || y == columns.end()) continue;
    position_columns_.push_back({.table = id,
                                 .x = static_cast<Id>(x - columns.begin()),
                                 .y = static_cast<Id>(y - columns.begin())});
    tables_.push_back(schema.tables[id].owner + "." + schema.tables[id].name);
  }
  outlines_ = schema.outlines;
  radius_ = simulation.ecosystem().config().radius;
  described_ = true;
}

void Picture::choose_grid(const model::Schema& schema) {
  if (options_.grid == "none") return;
  std::vector<std::string> names;
  for (const model::GridDeclaration& grid : schema.grids)
    names.push_back(grid.owner + "." + grid.name);
  const auto found =
      options_.grid.empty() ? names.begin() : std::find(names.begin(), names.end(), options_.grid);
  if (found == names.end()) {
    if (options_.grid.empty()) return;
    throw run::UsageError("there is no grid '" + options_.grid + "'; grids: " +
                          plugins::join(names) + plugins::did_you_mean(options_.grid, names));
  }
  grid_ = static_cast<Id>(found - names.begin());
  grid_name_ = *found;
  grid_spec_ = schema.grids[grid_].spec;
}

Panel Picture::capture(const model::WorldState& world) const {
  Panel panel;
  panel.step = world.step - 1;
  panel.counts.assign(states_.size(), 0);
  const model::CellStore& cells = world.cells;
  for (const std::uint32_t i : cells.order) {
    const auto named = std::find(states_.begin(), states_.end(), world.state_of(i).name);
    const auto state = static_cast<std::uint16_t>(named - states_.begin());
    ++panel.counts[state];
    panel.cells.push_back({.x = cells.x[i],
                           .y = cells.y[i],
                           .radius = cells.radius[i],
                           .state = state,
                           .dividing = cells.action[i] == model::Action::division});
  }
  for (const PositionColumns& columns : position_columns_) {
    const model::TableStore& table = world.tables[columns.table];
    std::vector<Point>& points = panel.tables.emplace_back();
    for (std::uint32_t row = 0; row < table.rows(); ++row)
      points.push_back({table.column(columns.x)[row], table.column(columns.y)[row]});
  }
  if (grid_ != no_id) panel.grid = world.grids[grid_];
  return panel;
}

void Picture::check_complete() const {
  if (!described_) throw run::UsageError("--steps: no step was simulated");
  if (options_.steps.back() > last_step_)
    throw run::UsageError("--steps: step " + std::to_string(options_.steps.back()) +
                          " is beyond the life; its last step is " + std::to_string(last_step_));
  if (panels_.size() != options_.steps.size())
    throw run::UsageError("--steps: step " + std::to_string(options_.steps.front()) +
                          " comes before the step at which the replay begins");
}

std::string Picture::render(PictureFormat format) const {
  check_complete();
  return Painter(*this, format).paint();
}

}  // namespace somas::report
