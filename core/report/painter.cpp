#include "core/report/painter.hpp"

#include <algorithm>
#include <cmath>

#include "core/plugins/suggest.hpp"

namespace somas::report {
namespace {

constexpr int levels = 16;  // of the legend's bar

const std::vector<Zones::Zone> no_zones;

Levels levels_of(const std::vector<Scene>& panels) {
  Levels found;
  for (const Scene& panel : panels) found.add(panel);
  return found;
}

}  // namespace

Painter::Painter(const Picture& picture, PictureFormat format)
    : picture_(picture),
      view_(view_of(picture.panels_, picture.setting_.radius, picture.options_.whole_world)),
      layout_(lay_out()),
      levels_(levels_of(picture.panels_)),
      canvas_(format, picture.options_.width, layout_.height),
      painter_(canvas_, picture.setting_, no_zones, levels_, 0.1 * layout_.font) {}

Painter::Layout Painter::lay_out() const {
  Layout layout;
  const double width = picture_.options_.width;
  const auto count = static_cast<double>(picture_.panels_.size());
  layout.gap = std::max(4.0, width / 160);
  layout.panel = (width - (count + 1) * layout.gap) / count;
  layout.font = std::clamp(layout.panel / 22, 6.0, 30.0);
  layout.line = 1.45 * layout.font;
  std::size_t entries = 0;
  for (const Scene& panel : picture_.panels_) entries = std::max(entries, legend(panel).size());
  const double grid_lines = picture_.setting_.grid != no_id ? 1.2 : 0;
  layout.height = std::ceil(2 * layout.gap + layout.panel +
                            (1.2 + static_cast<double>(entries) + grid_lines) * layout.line);
  return layout;
}

std::vector<Painter::Entry> Painter::legend(const Scene& panel) const {
  std::vector<Entry> entries;
  for (std::size_t s = 0; s < panel.counts.size(); ++s)
    entries.push_back(
        {.fill = colour_of_state(s),
         .words = std::to_string(panel.counts[s]) + " " + picture_.setting_.states[s]});
  entries.push_back({.fill = {1, 1, 1, 1},
                     .rim = true,
                     .words = std::to_string(panel.dividing()) + " of them dividing"});
  for (std::size_t o = 0; o < picture_.setting_.organisms.size(); ++o)
    entries.push_back({.fill = colour_of_organism(o), .words = picture_.setting_.organisms[o]});
  for (std::size_t t = 0; t < panel.tables.size(); ++t)
    entries.push_back(
        {.fill = colour_of_table(t),
         .size = 0.4,
         .words = std::to_string(panel.tables[t].size()) + " " + picture_.setting_.tables[t]});
  return entries;
}

std::string Painter::paint() {
  double left = layout_.gap;
  for (const Scene& panel : picture_.panels_) {
    paint_panel(panel, left);
    left += layout_.panel + layout_.gap;
  }
  if (picture_.setting_.grid != no_id) paint_grid_legend();
  return canvas_.finish();
}

void Painter::paint_panel(const Scene& panel, double left) {
  const Rect square{left, layout_.gap + 1.2 * layout_.line, layout_.panel, layout_.panel};
  canvas_.colour(black);
  canvas_.text(
      left, layout_.gap + layout_.font, layout_.font, layout_.panel,
      "step " + std::to_string(panel.step) + ", " + plugins::plural(panel.cells.size(), "cell"));
  painter_.paint(panel, {}, square, view_);
  if (&panel == &picture_.panels_.front()) painter_.scale_bar(layout_.font);
  canvas_.frame(square, 0.06 * layout_.font, frame_grey);
  paint_legend(panel, left);
}

void Painter::paint_legend(const Scene& panel, double left) {
  const double f = layout_.font, indent = 1.3 * f;
  double y = layout_.gap + 1.2 * layout_.line + layout_.panel + layout_.line;
  for (const Entry& entry : legend(panel)) {
    canvas_.disc(left + 0.5 * f, y - 0.36 * f, 0.4 * f * entry.size);
    canvas_.colour(entry.fill);
    cairo_fill_preserve(canvas_.context());
    canvas_.stroke(entry.rim ? 0.2 * f : 0, black);
    canvas_.colour(black);
    canvas_.text(left + indent, y, f, layout_.panel - indent, entry.words);
    y += layout_.line;
  }
}

// "nutrients.content 0 [bar] 10"
void Painter::paint_grid_legend() {
  const double f = layout_.font, y = layout_.height - layout_.gap - 0.3 * f;
  const double bar = layout_.panel / 3, left = layout_.gap;
  for (int level = 0; level < levels; ++level) {
    canvas_.fill({left + bar * level / levels, y - 0.8 * f, bar / levels, f},
                 grey_ramp(static_cast<double>(level) / (levels - 1)));
  }
  canvas_.frame({left, y - 0.8 * f, bar, f}, 0.06 * f, frame_grey);
  canvas_.colour(black);
  const double words = left + bar + 0.6 * f;
  canvas_.text(
      words, y, f, layout_.panel + layout_.gap - words,
      number(levels_.low) + " to " + number(levels_.high) + " " + picture_.setting_.grid_name);
}

}  // namespace somas::report
