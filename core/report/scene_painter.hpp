// Draws a scene into a square of a canvas.
//
// From below: what the ground shows (a grid's content inside the world, or morphogens), stripes
// where a resource ever was, the world's circle, outlines of environments, cells at their true
// radius (dividing ones have a black rim; where several organisms share the world, each has an
// outline of its own colour), and the rows of tables with columns x and y (particles).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/report/canvas.hpp"
#include "core/report/scene.hpp"

namespace somas::report {

/// What the colour of a cell says.
enum class CellColour { state, energy, inks, morphogen, none };
/// What is drawn below the cells.
enum class Ground { none, grid, inks, morphogen };

struct SceneStyle {
  CellColour cells = CellColour::state;
  Ground ground = Ground::grid;
  std::size_t morphogen = 0;  ///< the kind of CellColour::morphogen and Ground::morphogen
  bool tables = true;
};

/// The square of the world that is shown.
struct View {
  double x = 0, y = 0, half = 1;
};
/// The world, or what holds the cells of all scenes and a margin.
[[nodiscard]] View view_of(std::span<const Scene> scenes, double world_radius, bool whole_world);
/// The same of what holds all cells: `left` > `right` if there are none.
struct Extent {
  double left = 1, right = -1, low = 1, high = -1;
  void add(const SceneCell& cell);
};
[[nodiscard]] View view_of(const Extent& extent, double world_radius, bool whole_world);

/// Both ends of the scales of colour, the same for all scenes of a picture. They begin at 0 unless
/// there is less.
struct Levels {
  double low = 0, high = 0;        ///< of the grid
  std::vector<double> morphogens;  ///< greatest concentration, by kind
  void add(const Scene& scene);
};

/// "0.5", "1e+06".
[[nodiscard]] std::string number(double value, int digits = 4);
/// The largest of 1, 2, 5, 10, ... (times a power of ten) that is not above `most`.
[[nodiscard]] double round_length(double most);

class ScenePainter {
 public:
  /// All must outlive the painter. `line`: the unit of widths of lines, a tenth of a letter's size.
  ScenePainter(const Canvas& canvas, const Setting& setting, const std::vector<Zones::Zone>& zones,
               const Levels& levels, double line)
      : canvas_(canvas), setting_(setting), zones_(zones), levels_(levels), line_(line) {}

  void paint(const Scene& scene, const SceneStyle& style, const Rect& square, const View& view);
  /// A bar of a round length in the lower left corner of the square painted last.
  void scale_bar(double font) const;

 private:
  void paint_grid(const Scene& scene) const;
  void paint_level(const Scene& scene, int level) const;
  void paint_morphogens(const Scene& scene, const SceneStyle& style) const;
  void paint_zones() const;
  void paint_outlines() const;
  void paint_cells(const Scene& scene, const SceneStyle& style) const;
  void paint_cell(const Scene& scene, std::size_t cell, const SceneStyle& style) const;
  void surround_organism(const Scene& scene, std::size_t first) const;
  void paint_tables(const Scene& scene) const;
  [[nodiscard]] Colour colour_of(const Scene& scene, std::size_t cell,
                                 const SceneStyle& style) const;
  [[nodiscard]] double share(std::size_t kind, double concentration) const;
  [[nodiscard]] bool outside(double x, double y, double radius) const;
  void add_square(const GridSpec& grid, std::uint32_t row, std::uint32_t first, std::uint32_t end,
                  double overlap = 0) const;

  // World to canvas, in the square that is being painted.
  [[nodiscard]] double px(double x) const { return centre_x_ + (x - view_.x) * scale_; }
  [[nodiscard]] double py(double y) const { return centre_y_ - (y - view_.y) * scale_; }

  const Canvas& canvas_;
  const Setting& setting_;
  const std::vector<Zones::Zone>& zones_;
  const Levels& levels_;
  double line_;
  Rect square_;
  View view_;
  double scale_ = 1, centre_x_ = 0, centre_y_ = 0;
};

}  // namespace somas::report
