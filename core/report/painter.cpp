#include "core/report/painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "somas/sdk/math.hpp"

#include "core/plugins/suggest.hpp"

namespace somas::report {
namespace {

constexpr Colour black{0.1, 0.1, 0.1, 1};
constexpr int levels = 16;  // of the heat map

constexpr Colour rgb(unsigned code) {
  return {(code >> 16 & 255) / 255.0, (code >> 8 & 255) / 255.0, (code & 255) / 255.0, 1};
}

// Okabe and Ito 2008, without black (rims and letters) and vermillion (the first table).
constexpr std::array<Colour, 6> state_colours = {rgb(0xE69F00), rgb(0x0072B2), rgb(0x009E73),
                                                 rgb(0xCC79A7), rgb(0x56B4E9), rgb(0xF0E442)};
constexpr std::array<Colour, 3> table_colours = {rgb(0xD55E00), rgb(0x000000), rgb(0x7F3F98)};

Colour darker(const Colour& c, double share) {
  return {c.red * share, c.green * share, c.blue * share, 1};
}

Colour colour_of_state(std::size_t state) {
  Colour colour = state_colours[state % state_colours.size()];
  for (std::size_t round = state / state_colours.size(); round > 0; --round)
    colour = darker(colour, 0.6);
  return colour;
}

const Colour& colour_of_table(std::size_t table) {
  return table_colours[table % table_colours.size()];
}

// Grey of CIE lightness 100 (level 0) to 84: equal steps look equal, and cells stand out.
Colour colour_of_level(int level) {
  const double f = (100.0 - 16.0 * level / (levels - 1) + 16) / 116;
  const double linear = f * f * f;
  const double grey = 1.055 * math::exp(math::log(linear) / 2.4) - 0.055;
  return {grey, grey, grey, 1};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

// The largest of 1, 2, 5, 10, ... that is not above `most`.
double round_length(double most) {
  double power = 1;
  while (power * 10 <= most) power *= 10;
  while (power > most) power /= 10;
  for (const double factor : {5.0, 2.0})
    if (factor * power <= most) return factor * power;
  return power;
}

}  // namespace

Painter::Painter(const Picture& picture, PictureFormat format)
    : picture_(picture),
      view_(choose_view()),
      layout_(lay_out()),
      scale_(layout_.panel / (2 * view_.half)),
      canvas_(format, picture.options_.width, layout_.height) {
  find_levels();
}

Painter::View Painter::choose_view() const {
  const double world = 1.03 * picture_.radius_;
  double left = world, right = -world, low = world, high = -world;
  for (const Panel& panel : picture_.panels_)
    for (const Disc& cell : panel.cells) {
      left = std::min(left, cell.x - cell.radius);
      right = std::max(right, cell.x + cell.radius);
      low = std::min(low, cell.y - cell.radius);
      high = std::max(high, cell.y + cell.radius);
    }
  if (picture_.options_.whole_world || left > right) return {0, 0, world};
  const double half = std::max(right - left, high - low) / 2;
  return {(left + right) / 2, (low + high) / 2, std::max(1.3 * half, half + 4)};
}

Painter::Layout Painter::lay_out() const {
  Layout layout;
  const double width = picture_.options_.width;
  const auto count = static_cast<double>(picture_.panels_.size());
  layout.gap = std::max(4.0, width / 160);
  layout.panel = (width - (count + 1) * layout.gap) / count;
  layout.font = std::clamp(layout.panel / 22, 6.0, 30.0);
  layout.line = 1.45 * layout.font;
  std::size_t entries = 0;
  for (const Panel& panel : picture_.panels_) entries = std::max(entries, legend(panel).size());
  const double grid_lines = picture_.grid_ != no_id ? 1.2 : 0;
  layout.height = std::ceil(2 * layout.gap + layout.panel +
                            (1.2 + static_cast<double>(entries) + grid_lines) * layout.line);
  return layout;
}

std::vector<Painter::Entry> Painter::legend(const Panel& panel) const {
  std::vector<Entry> entries;
  for (std::size_t s = 0; s < panel.counts.size(); ++s)
    entries.push_back({.fill = colour_of_state(s),
                       .words = std::to_string(panel.counts[s]) + " " + picture_.states_[s]});
  entries.push_back({.fill = {1, 1, 1, 1},
                     .rim = true,
                     .words = std::to_string(panel.dividing()) + " of them dividing"});
  for (std::size_t t = 0; t < panel.tables.size(); ++t)
    entries.push_back(
        {.fill = colour_of_table(t),
         .size = 0.4,
         .words = std::to_string(panel.tables[t].size()) + " " + picture_.tables_[t]});
  return entries;
}

// The same scale in all panels; it begins at 0 unless there is less.
void Painter::find_levels() {
  for (const Panel& panel : picture_.panels_)
    for (const double content : panel.grid) {
      low_ = std::min(low_, content);
      high_ = std::max(high_, content);
    }
}

std::string Painter::paint() {
  double left = layout_.gap;
  for (const Panel& panel : picture_.panels_) {
    paint_panel(panel, left);
    left += layout_.panel + layout_.gap;
  }
  if (picture_.grid_ != no_id) paint_grid_legend();
  return canvas_.finish();
}

void Painter::paint_panel(const Panel& panel, double left) {
  cairo_t* c = canvas_.context();
  const double top = layout_.gap + 1.2 * layout_.line;
  centre_x_ = left + layout_.panel / 2;
  centre_y_ = top + layout_.panel / 2;
  canvas_.colour(black);
  canvas_.text(
      left, layout_.gap + layout_.font, layout_.font, layout_.panel,
      "step " + std::to_string(panel.step) + ", " + plugins::plural(panel.cells.size(), "cell"));

  cairo_save(c);
  cairo_rectangle(c, left, top, layout_.panel, layout_.panel);
  cairo_clip(c);
  paint_grid(panel);
  paint_world();
  paint_outlines();
  paint_cells(panel);
  paint_tables(panel);
  if (&panel == &picture_.panels_.front()) paint_scale_bar(left);
  cairo_restore(c);

  cairo_rectangle(c, left, top, layout_.panel, layout_.panel);
  stroke(0.06 * layout_.font, rgb(0x808080));
  paint_legend(panel, left);
}

void Painter::paint_grid(const Panel& panel) {
  if (panel.grid.empty() || high_ <= low_) return;
  cairo_t* c = canvas_.context();
  cairo_save(c);
  canvas_.disc(px(0), py(0), picture_.radius_ * scale_);
  cairo_clip(c);
  // From light to dark, each level over all that is at least as dark: no gaps between squares.
  for (int level = 1; level < levels; ++level) paint_level(panel, level);
  cairo_restore(c);
}

void Painter::paint_level(const Panel& panel, int level) {
  cairo_t* c = canvas_.context();
  const GridSpec& grid = picture_.grid_spec_;
  const double least = low_ + (high_ - low_) * (level - 0.5) / (levels - 1);
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    const double* content = panel.grid.data() + static_cast<std::size_t>(row) * grid.columns;
    for (std::uint32_t first = 0; first < grid.columns; ++first) {
      if (content[first] < least) continue;
      // Neighbours of a row become one rectangle.
      std::uint32_t end = first + 1;
      while (end < grid.columns && content[end] >= least) ++end;
      cairo_rectangle(c, px(grid.left + first * grid.side), py(grid.bottom + (row + 1) * grid.side),
                      (end - first) * grid.side * scale_, grid.side * scale_);
      first = end;
    }
  }
  canvas_.colour(colour_of_level(level));
  cairo_fill(c);
}

void Painter::paint_world() {
  canvas_.disc(px(0), py(0), picture_.radius_ * scale_);
  stroke(0.1 * layout_.font, rgb(0x606060));
}

void Painter::paint_outlines() {
  cairo_t* c = canvas_.context();
  for (const model::Outline& outline : picture_.outlines_) {
    cairo_new_path(c);
    for (const Point& point : outline.points) cairo_line_to(c, px(point.x), py(point.y));
    if (outline.closed) {
      cairo_close_path(c);
      canvas_.colour({0.45, 0.45, 0.45, 0.6});
      cairo_fill_preserve(c);
    }
    stroke(0.15 * layout_.font, rgb(0x303030));
  }
}

void Painter::paint_cells(const Panel& panel) {
  cairo_t* c = canvas_.context();
  for (const Disc& cell : panel.cells) {
    const Colour colour = colour_of_state(cell.state);
    const double radius = cell.radius * scale_;
    // The rim lies inside, so that the disc keeps its true radius.
    const double rim = (cell.dividing ? 0.3 : 0.1) * radius;
    canvas_.disc(px(cell.x), py(cell.y), radius);
    canvas_.colour(colour);
    cairo_fill(c);
    canvas_.disc(px(cell.x), py(cell.y), radius - rim / 2);
    stroke(rim, cell.dividing ? black : darker(colour, 0.6));
  }
}

void Painter::paint_tables(const Panel& panel) {
  for (std::size_t t = 0; t < panel.tables.size(); ++t) {
    for (const Point& point : panel.tables[t])
      canvas_.disc(px(point.x), py(point.y), 0.25 * scale_ + 0.02 * layout_.font);
    canvas_.colour(colour_of_table(t));
    cairo_fill(canvas_.context());
  }
}

void Painter::paint_scale_bar(double left) {
  cairo_t* c = canvas_.context();
  const double length = round_length(view_.half / 2), f = layout_.font;
  const double x = left + f, y = centre_y_ + layout_.panel / 2 - f;
  const double room = std::max(length * scale_, 4 * f);
  cairo_rectangle(c, x - 0.5 * f, y - 1.8 * f, room + f, 2.3 * f);
  canvas_.colour({1, 1, 1, 0.85});
  cairo_fill(c);
  cairo_move_to(c, x, y);
  cairo_line_to(c, x + length * scale_, y);
  stroke(0.2 * f, black);
  canvas_.colour(black);
  canvas_.text(x, y - 0.5 * f, f, room, number(length) + (length == 1 ? " unit" : " units"));
}

void Painter::paint_legend(const Panel& panel, double left) {
  const double f = layout_.font, indent = 1.3 * f;
  double y = layout_.gap + 1.2 * layout_.line + layout_.panel + layout_.line;
  for (const Entry& entry : legend(panel)) {
    canvas_.disc(left + 0.5 * f, y - 0.36 * f, 0.4 * f * entry.size);
    canvas_.colour(entry.fill);
    cairo_fill_preserve(canvas_.context());
    stroke(entry.rim ? 0.2 * f : 0, black);
    canvas_.colour(black);
    canvas_.text(left + indent, y, f, layout_.panel - indent, entry.words);
    y += layout_.line;
  }
}

// "nutrients.content 0 [bar] 10"
void Painter::paint_grid_legend() {
  cairo_t* c = canvas_.context();
  const double f = layout_.font, y = layout_.height - layout_.gap - 0.3 * f;
  const double bar = layout_.panel / 3, left = layout_.gap;
  for (int level = 0; level < levels; ++level) {
    cairo_rectangle(c, left + bar * level / levels, y - 0.8 * f, bar / levels, f);
    canvas_.colour(colour_of_level(level));
    cairo_fill(c);
  }
  cairo_rectangle(c, left, y - 0.8 * f, bar, f);
  stroke(0.06 * f, rgb(0x808080));
  canvas_.colour(black);
  const double words = left + bar + 0.6 * f;
  canvas_.text(words, y, f, layout_.panel + layout_.gap - words,
               number(low_) + " to " + number(high_) + " " + picture_.grid_name_);
}

void Painter::stroke(double width, const Colour& colour) {
  cairo_t* c = canvas_.context();
  canvas_.colour(colour);
  cairo_set_line_width(c, width);
  if (width > 0)
    cairo_stroke(c);
  else
    cairo_new_path(c);
}

}  // namespace somas::report
