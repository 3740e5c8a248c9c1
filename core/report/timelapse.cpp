#include "core/report/timelapse.hpp"

#include <algorithm>
#include <cmath>

#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

constexpr double gap = 3, panel_title = 1.35 * label_font;
using Swatch = LegendEntry::Swatch;

// Down to 1, 5, 10 or 50, by size: 104 -> 100, 987 -> 980, 1234 -> 1200.
std::uint64_t rounded_down(std::uint64_t stride) {
  const std::uint64_t unit = stride >= 1000 ? 50 : stride >= 100 ? 10 : stride >= 20 ? 5 : 1;
  return std::max<std::uint64_t>(1, stride / unit * unit);
}

std::string ordinal(std::size_t kind) { return "morphogen " + std::to_string(kind + 1); }

}  // namespace

std::vector<std::uint64_t> even_steps(std::uint64_t life, std::uint32_t count) {
  if (life == 0) return {0};
  const std::uint64_t stride = rounded_down((life - 1) / count);
  std::vector<std::uint64_t> steps;
  for (std::uint64_t step = stride; step < life && steps.size() < count; step += stride)
    steps.push_back(step);
  if (steps.empty()) steps.push_back(0);
  return steps;
}

std::uint32_t default_columns(PanelKind kind, double width_mm) {
  const bool rows = kind == PanelKind::morphogens || kind == PanelKind::grid;
  if (width_mm >= 130) return rows ? 4 : 5;
  return rows ? 3 : 4;
}

Timelapse::Timelapse(TimelapseOptions options, FigureSize size)
    : options_(std::move(options)), size_(size) {
  std::vector<std::uint64_t>& steps = options_.steps;
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  if (options_.columns == 0) {
    options_.columns = default_columns(options_.kind, size_.width_mm);
    if (!steps.empty())
      options_.columns =
          std::min<std::uint32_t>(options_.columns, static_cast<std::uint32_t>(steps.size()));
  }
  if (panel_side(9) < least_panel)
    throw run::UsageError("--columns: " + plugins::plural(options_.columns, "panel") +
                          " side by side leave each less than 14 mm at a width of " +
                          number(size_.width_mm) + " mm");
  const bool of_environment = options_.kind == PanelKind::grid && !options_.grid.empty();
  const bool ground = options_.kind == PanelKind::timelapse || of_environment;
  wants_ = {.grid = ground ? options_.grid : "none",
            .morphogens = shows_morphogens(),
            .organism = options_.organism};
}

bool Timelapse::shows_morphogens() const {
  return options_.kind == PanelKind::morphogens ||
         (options_.kind == PanelKind::grid && options_.grid.empty());
}

void Timelapse::expect(std::uint64_t life, const std::vector<std::uint64_t>& there) {
  if (!options_.steps.empty()) return;
  const bool rows = shows_morphogens();
  std::vector<std::uint64_t>& steps = options_.steps;
  steps = even_steps(life, options_.columns * (rows ? 1 : 2));
  if (there.empty()) return;
  for (std::uint64_t& step : steps) {
    const auto after = std::lower_bound(there.begin(), there.end(), step);
    const bool before = after == there.end() ||
                        (after != there.begin() && step - *std::prev(after) <= *after - step);
    step = before ? *std::prev(after) : *after;
  }
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
}

void Timelapse::begin(Setting setting) {
  if (shows_morphogens() && setting.morphogens == 0)
    throw run::UsageError("this experiment has no morphogens");
  setting_ = std::move(setting);
  described_ = true;
}

bool Timelapse::wanted(std::uint64_t step) const {
  return std::binary_search(options_.steps.begin(), options_.steps.end(), step);
}

void Timelapse::keep(Scene scene) {
  scenes_.push_back(std::move(scene));
  levels_.add(scenes_.back());
}

void Timelapse::observe(const model::Simulation& simulation) {
  if (!described_) begin(setting_of(simulation, wants_));
  zones_.observe(simulation);
  last_step_ = simulation.state().step - 1;
  if (wanted(last_step_)) keep(scene_of(simulation, setting_, wants_));
}

void Timelapse::observe(const recording::Header& header, const recording::Frame& frame) {
  if (!described_) begin(setting_of(header, wants_));
  zones_.observe(header, frame);
  last_step_ = frame.step;
  if (!wanted(last_step_)) return;
  if (!frame.has_fields && (setting_.grid != no_id || wants_.morphogens))
    throw run::UsageError("--steps: the frame of step " + std::to_string(frame.step) +
                          " has neither grids nor morphogens; frames at steps divisible by " +
                          std::to_string(header.fields_every) + " have them" +
                          (wants_.morphogens ? "" : ", and --grid none draws cells only"));
  keep(scene_of(header, frame, setting_, wants_));
}

void Timelapse::check_complete() const {
  if (!described_) throw run::UsageError("--steps: no step was simulated");
  if (options_.steps.back() > last_step_)
    throw run::UsageError("--steps: step " + std::to_string(options_.steps.back()) +
                          " is beyond the life; its last step is " + std::to_string(last_step_));
}

std::vector<Timelapse::Row> Timelapse::rows() const {
  if (options_.kind == PanelKind::timelapse) return {{{}, ""}};
  if (options_.kind == PanelKind::energy)
    return {{{.cells = CellColour::energy, .ground = Ground::none}, ""}};
  if (!shows_morphogens())
    return {{{.cells = CellColour::none, .ground = Ground::grid, .tables = false}, ""}};
  const bool sensed = options_.kind == PanelKind::morphogens;
  const auto style = [&](CellColour colour, Ground ground, std::size_t kind) {
    return SceneStyle{.cells = sensed ? colour : CellColour::none,
                      .ground = sensed ? Ground::none : ground,
                      .morphogen = kind,
                      .tables = false};
  };
  std::vector<Row> rows;
  if (setting_.morphogens > 1 && setting_.morphogens <= 3)
    rows.push_back({style(CellColour::inks, Ground::inks, 0), "together"});
  for (std::size_t kind = 0; kind < setting_.morphogens; ++kind)
    rows.push_back({style(CellColour::morphogen, Ground::morphogen, kind), ordinal(kind)});
  return rows;
}

double Timelapse::panel_side(double left) const {
  const double columns = options_.columns;
  return (size_.width() - 6 - left - (columns - 1) * gap) / columns;
}

std::string Timelapse::title() const {
  switch (options_.kind) {
    case PanelKind::energy:
      return "Energy of cells over time.";
    case PanelKind::morphogens:
      return "Concentrations of morphogens as cells sense them.";
    case PanelKind::grid:
      return shows_morphogens() ? "Morphogens on their grid, cells as circles."
                                : "Content of " + setting_.grid_name + ", cells as circles.";
    default:
      return "Development of an organism.";
  }
}

std::string Timelapse::render(const Subject& subject) const {
  check_complete();
  const std::size_t count = scenes_.size(), columns = options_.columns;
  const std::size_t blocks = (count + columns - 1) / columns, per_block = rows().size();
  const double side = panel_side(left_margin());
  const auto lines = static_cast<double>(blocks * per_block);
  Frame frame{.title = title(), .caption = caption_of(subject), .legend = legend()};
  frame.body = static_cast<double>(blocks) * panel_title + lines * (side + gap);
  frame.paint = [this](const Canvas& canvas, const Rect& body) { paint(canvas, body); };
  return draw(frame, size_);
}

void Timelapse::paint(const Canvas& canvas, const Rect& body) const {
  const std::vector<Row> styles = rows();
  const View view = view_of(scenes_, setting_.radius, options_.whole_world);
  const double left = left_margin(), side = panel_side(left);
  ScenePainter painter(canvas, setting_, zones_.zones(), levels_, 0.1 * label_font);
  double y = body.y;
  for (std::size_t first = 0; first < scenes_.size(); first += options_.columns) {
    const std::size_t end = std::min<std::size_t>(scenes_.size(), first + options_.columns);
    for (std::size_t i = first; i < end; ++i) {
      canvas.colour(black);
      canvas.label(body.x + left + static_cast<double>(i - first) * (side + gap), y + label_font,
                   label_font, "step " + grouped(scenes_[i].step));
    }
    y += panel_title;
    for (const Row& row : styles) {
      canvas.colour(black);
      if (left > 0) canvas.upright_label(body.x + label_font, y + side / 2, label_font, row.label);
      for (std::size_t i = first; i < end; ++i) {
        const Rect square{body.x + left + static_cast<double>(i - first) * (side + gap), y, side,
                          side};
        painter.paint(scenes_[i], row.style, square, view);
        canvas.frame(square, 0.5, frame_grey);
      }
      y += side + gap;
    }
  }
}

std::vector<LegendEntry> Timelapse::legend() const {
  // Below the panels the bar hides nothing.
  const View view = view_of(scenes_, setting_.radius, options_.whole_world);
  const double scale = panel_side(left_margin()) / (2 * view.half),
               length = round_length(view.half / 2);
  std::vector<LegendEntry> entries{{.swatch = Swatch::length,
                                    .words = number(length) + (length == 1 ? " unit" : " units"),
                                    .length = length * scale}};
  if (shows_morphogens())
    add_morphogen_entries(entries);
  else
    add_cell_entries(entries);
  for (std::size_t o = 0; o < setting_.organisms.size(); ++o)
    entries.push_back(
        {.swatch = Swatch::rim, .colour = colour_of_organism(o), .words = setting_.organisms[o]});
  add_ground_entries(entries);
  return entries;
}

void Timelapse::add_cell_entries(std::vector<LegendEntry>& entries) const {
  if (options_.kind == PanelKind::energy)
    entries.push_back(
        {.swatch = Swatch::ramp, .words = "energy", .ramp = green_ramp, .low = "0", .high = "1"});
  if (options_.kind == PanelKind::timelapse) {
    for (std::size_t s = 0; s < setting_.states.size(); ++s)
      entries.push_back({.colour = colour_of_state(s), .words = setting_.states[s]});
    entries.push_back({.swatch = Swatch::rim, .colour = black, .words = "dividing"});
  }
  if (options_.kind == PanelKind::grid) {
    if (setting_.organisms.empty())
      entries.push_back({.swatch = Swatch::ring, .colour = black, .words = "cell"});
    return;
  }
  for (std::size_t t = 0; t < setting_.tables.size(); ++t)
    entries.push_back(
        {.swatch = Swatch::dot, .colour = colour_of_table(t), .words = setting_.tables[t]});
}

void Timelapse::add_morphogen_entries(std::vector<LegendEntry>& entries) const {
  const bool inked = rows().size() > setting_.morphogens;
  for (std::size_t kind = 0; inked && kind < setting_.morphogens; ++kind)
    entries.push_back({.swatch = Swatch::box,
                       .colour = inks(kind == 0, kind == 1, kind == 2),
                       .words = ordinal(kind)});
  for (std::size_t kind = 0; kind < setting_.morphogens; ++kind)
    entries.push_back({.swatch = Swatch::ramp,
                       .words = ordinal(kind) + (levels_.morphogens[kind] > 0 ? "" : " (none)"),
                       .ramp = [kind](double t) { return morphogen_ramp(kind, t); },
                       .low = "0",
                       .high = number(levels_.morphogens[kind], 3)});
}

void Timelapse::add_ground_entries(std::vector<LegendEntry>& entries) const {
  if (setting_.grid != no_id)
    entries.push_back({.swatch = Swatch::ramp,
                       .words = setting_.grid_name,
                       .ramp = grey_ramp,
                       .low = number(levels_.low),
                       .high = number(levels_.high)});
  for (const Zones::Zone& zone : zones_.zones())
    if (!zone.everywhere)
      entries.push_back({.swatch = Swatch::hatch, .words = "zone of " + zone.resource});
  for (const recording::Outline& outline : setting_.outlines) {
    const std::string& words = outline.name;
    const auto known = [&](const LegendEntry& entry) { return entry.words == words; };
    if (std::any_of(entries.begin(), entries.end(), known)) continue;
    if (outline.closed)
      entries.push_back({.swatch = Swatch::box, .colour = rgb(0xABABAB), .words = words});
    else
      entries.push_back({.swatch = Swatch::line, .colour = rgb(0x303030), .words = words});
  }
}

}  // namespace somas::report
