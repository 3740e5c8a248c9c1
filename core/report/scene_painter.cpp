#include "core/report/scene_painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace somas::report {
namespace {

constexpr int grid_levels = 16;
constexpr double hatch_distance = 3.2;  // of stripes, in points

/// Restores what was clipped.
class Clip {
 public:
  explicit Clip(cairo_t* context) : context_(context) {
    cairo_save(context_);
    cairo_clip(context_);
  }
  ~Clip() { cairo_restore(context_); }
  Clip(const Clip&) = delete;
  Clip& operator=(const Clip&) = delete;

 private:
  cairo_t* context_;
};

}  // namespace

std::string number(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

double round_length(double most) {
  double power = 1;
  while (power * 10 <= most) power *= 10;
  while (power > most) power /= 10;
  for (const double factor : {5.0, 2.0})
    if (factor * power <= most) return factor * power;
  return power;
}

void Extent::add(const SceneCell& cell) {
  const bool first = left > right;
  left = first ? cell.x - cell.radius : std::min(left, cell.x - cell.radius);
  right = first ? cell.x + cell.radius : std::max(right, cell.x + cell.radius);
  low = first ? cell.y - cell.radius : std::min(low, cell.y - cell.radius);
  high = first ? cell.y + cell.radius : std::max(high, cell.y + cell.radius);
}

View view_of(const Extent& e, double world_radius, bool whole_world) {
  if (whole_world || e.left > e.right) return {0, 0, 1.03 * world_radius};
  const double half = std::max(e.right - e.left, e.high - e.low) / 2;
  return {(e.left + e.right) / 2, (e.low + e.high) / 2, std::max(1.3 * half, half + 4)};
}

View view_of(std::span<const Scene> scenes, double world_radius, bool whole_world) {
  Extent extent;
  for (const Scene& scene : scenes)
    for (const SceneCell& cell : scene.cells) extent.add(cell);
  return view_of(extent, world_radius, whole_world);
}

void Levels::add(const Scene& scene) {
  for (const double content : scene.grid) {
    low = std::min(low, content);
    high = std::max(high, content);
  }
  morphogens.resize(std::max(morphogens.size(), scene.morphogens.size()));
  for (std::size_t kind = 0; kind < scene.morphogens.size(); ++kind)
    for (const float concentration : scene.morphogens[kind])
      morphogens[kind] = std::max(morphogens[kind], static_cast<double>(concentration));
}

void ScenePainter::paint(const Scene& scene, const SceneStyle& style, const Rect& square,
                         const View& view) {
  square_ = square;
  view_ = view;
  scale_ = square.width / (2 * view.half);
  centre_x_ = square.x + square.width / 2;
  centre_y_ = square.y + square.height / 2;
  cairo_t* c = canvas_.context();
  cairo_rectangle(c, square.x, square.y, square.width, square.height);
  const Clip clip(c);
  if (style.ground == Ground::grid) paint_grid(scene);
  if (style.ground == Ground::inks || style.ground == Ground::morphogen)
    paint_morphogens(scene, style);
  paint_zones();
  canvas_.disc(px(0), py(0), setting_.radius * scale_);
  canvas_.stroke(line_, rgb(0x606060));
  paint_outlines();
  paint_cells(scene, style);
  if (style.tables) paint_tables(scene);
}

void ScenePainter::paint_grid(const Scene& scene) const {
  if (scene.grid.empty() || levels_.high <= levels_.low) return;
  canvas_.disc(px(0), py(0), setting_.radius * scale_);
  const Clip clip(canvas_.context());
  // From light to dark, each level over all that is at least as dark: no gaps between squares.
  for (int level = 1; level < grid_levels; ++level) paint_level(scene, level);
}

void ScenePainter::paint_level(const Scene& scene, int level) const {
  const GridSpec& grid = setting_.grid_spec;
  const double least =
      levels_.low + (levels_.high - levels_.low) * (level - 0.5) / (grid_levels - 1);
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    const double* content = scene.grid.data() + static_cast<std::size_t>(row) * grid.columns;
    for (std::uint32_t first = 0; first < grid.columns; ++first) {
      if (content[first] < least) continue;
      // Neighbours of a row become one rectangle.
      std::uint32_t end = first + 1;
      while (end < grid.columns && content[end] >= least) ++end;
      add_square(grid, row, first, end);
      first = end;
    }
  }
  canvas_.fill(grey_ramp(static_cast<double>(level) / (grid_levels - 1)));
}

// Squares [first, end) of a row.
void ScenePainter::add_square(const GridSpec& grid, std::uint32_t row, std::uint32_t first,
                              std::uint32_t end, double overlap) const {
  cairo_rectangle(canvas_.context(), px(grid.left + first * grid.side),
                  py(grid.bottom + (row + 1) * grid.side),
                  (end - first) * grid.side * scale_ + overlap, grid.side * scale_ + overlap);
}

double ScenePainter::share(std::size_t kind, double concentration) const {
  const double most = kind < levels_.morphogens.size() ? levels_.morphogens[kind] : 0;
  return most > 0 ? concentration / most : 0;
}

void ScenePainter::paint_morphogens(const Scene& scene, const SceneStyle& style) const {
  const GridSpec& grid = setting_.morphogen_spec;
  const auto at = [&](std::size_t kind, std::size_t square) {
    return kind < scene.morphogens.size() ? share(kind, scene.morphogens[kind][square]) : 0;
  };
  for (std::uint32_t row = 0; row < grid.rows; ++row)
    for (std::uint32_t column = 0; column < grid.columns; ++column) {
      if (outside(grid.left + (column + 0.5) * grid.side, grid.bottom + (row + 0.5) * grid.side,
                  grid.side))
        continue;
      const std::size_t square = static_cast<std::size_t>(row) * grid.columns + column;
      const Colour colour = style.ground == Ground::inks
                                ? inks(at(0, square), at(1, square), at(2, square))
                                : morphogen_ramp(style.morphogen, at(style.morphogen, square));
      // A little wider than it is: no seams between neighbours.
      add_square(grid, row, column, column + 1, 0.3);
      canvas_.fill(colour);
    }
}

void ScenePainter::paint_zones() const {
  cairo_t* c = canvas_.context();
  for (const Zones::Zone& zone : zones_) {
    if (zone.everywhere) continue;
    for (std::uint32_t row = 0; row < zone.spec.rows; ++row) {
      const std::uint8_t* squares =
          zone.squares.data() + static_cast<std::size_t>(row) * zone.spec.columns;
      for (std::uint32_t first = 0; first < zone.spec.columns; ++first) {
        if (squares[first] == 0) continue;
        std::uint32_t end = first + 1;
        while (end < zone.spec.columns && squares[end] != 0) ++end;
        add_square(zone.spec, row, first, end);
        first = end;
      }
    }
    const Clip clip(c);
    // Diagonals all over the picture; the clip leaves those of the zone.
    for (double x = square_.x - square_.height; x < square_.right(); x += hatch_distance) {
      cairo_move_to(c, x, square_.bottom());
      cairo_line_to(c, x + square_.height, square_.y);
    }
    canvas_.stroke(0.5 * line_, rgb(0x8C8C8C));
  }
}

// Closed ones are solid; open ones are lines.
void ScenePainter::paint_outlines() const {
  cairo_t* c = canvas_.context();
  for (const recording::Outline& outline : setting_.outlines) {
    cairo_new_path(c);
    for (std::size_t i = 0; i < outline.x.size(); ++i)
      cairo_line_to(c, px(outline.x[i]), py(outline.y[i]));
    if (outline.closed) {
      cairo_close_path(c);
      canvas_.colour({0.45, 0.45, 0.45, 0.6});
      cairo_fill_preserve(c);
    }
    canvas_.stroke(1.5 * line_, rgb(0x303030));
  }
}

bool ScenePainter::outside(double x, double y, double radius) const {
  return std::abs(x - view_.x) > view_.half + radius || std::abs(y - view_.y) > view_.half + radius;
}

Colour ScenePainter::colour_of(const Scene& scene, std::size_t cell,
                               const SceneStyle& style) const {
  const auto sensed = [&](std::size_t kind) {
    return kind < scene.sensed.size() ? share(kind, scene.sensed[kind][cell]) : 0;
  };
  switch (style.cells) {
    case CellColour::energy:
      return green_ramp(scene.cells[cell].energy);
    case CellColour::inks:
      return inks(sensed(0), sensed(1), sensed(2));
    case CellColour::morphogen:
      return morphogen_ramp(style.morphogen, sensed(style.morphogen));
    default:
      return colour_of_state(scene.cells[cell].state);
  }
}

void ScenePainter::paint_cells(const Scene& scene, const SceneStyle& style) const {
  for (std::size_t i = 0; i < scene.cells.size(); ++i) {
    const bool first = i == 0 || scene.cells[i].organism != scene.cells[i - 1].organism;
    if (first && !setting_.organisms.empty() && style.cells != CellColour::none)
      surround_organism(scene, i);
    paint_cell(scene, i, style);
  }
}

// A little more than all its cells, which are drawn over it: what is seen of it is an outline.
void ScenePainter::surround_organism(const Scene& scene, std::size_t first) const {
  const std::uint16_t organism = scene.cells[first].organism;
  const double width = std::max(0.25 * scale_, 1.5 * line_);
  for (std::size_t i = first; i < scene.cells.size() && scene.cells[i].organism == organism; ++i)
    canvas_.disc(px(scene.cells[i].x), py(scene.cells[i].y),
                 scene.cells[i].radius * scale_ + width);
  canvas_.fill(colour_of_organism(organism));
}

void ScenePainter::paint_cell(const Scene& scene, std::size_t i, const SceneStyle& style) const {
  const SceneCell& cell = scene.cells[i];
  const double radius = cell.radius * scale_;
  if (style.cells == CellColour::none) {
    // Light round dark: seen on any ground.
    canvas_.disc(px(cell.x), py(cell.y), radius);
    canvas_.stroke(1.4 * line_, {1, 1, 1, 0.6});
    canvas_.disc(px(cell.x), py(cell.y), radius);
    canvas_.stroke(0.6 * line_,
                   setting_.organisms.empty() ? black : colour_of_organism(cell.organism));
    return;
  }
  const Colour colour = colour_of(scene, i, style);
  const bool by_state = style.cells == CellColour::state;
  const bool thick = by_state && cell.dividing;
  // The rim lies inside, so that the disc keeps its true radius.
  const double rim = (thick ? 0.3 : 0.1) * radius;
  canvas_.disc(px(cell.x), py(cell.y), radius);
  canvas_.fill(colour);
  canvas_.disc(px(cell.x), py(cell.y), radius - rim / 2);
  canvas_.stroke(rim, thick ? black : by_state ? darker(colour, 0.6) : rgb(0x505050));
}

void ScenePainter::paint_tables(const Scene& scene) const {
  for (std::size_t t = 0; t < scene.tables.size(); ++t) {
    const double radius = 0.25 * scale_ + 0.2 * line_;
    for (const Point& point : scene.tables[t])
      if (!outside(point.x, point.y, 1)) canvas_.disc(px(point.x), py(point.y), radius);
    canvas_.fill(colour_of_table(t));
  }
}

void ScenePainter::scale_bar(double font) const {
  const double length = round_length(view_.half / 2), f = font;
  const double x = square_.x + f, y = square_.bottom() - f;
  const std::string words = number(length) + (length == 1 ? " unit" : " units");
  const double room = std::max(length * scale_, canvas_.width_of(f, words));
  canvas_.fill({x - 0.5 * f, y - 1.8 * f, room + f, 2.3 * f}, {1, 1, 1, 0.85});
  canvas_.line(x, y, x + length * scale_, y, 0.2 * f, black);
  canvas_.colour(black);
  canvas_.label(x, y - 0.5 * f, f, words);
}

}  // namespace somas::report
