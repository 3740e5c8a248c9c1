// Puts the panels of a picture, their titles and legends on a canvas.
#pragma once

#include <string>
#include <vector>

#include "core/report/canvas.hpp"
#include "core/report/picture.hpp"

namespace somas::report {

class Painter {
 public:
  Painter(const Picture& picture, PictureFormat format);
  [[nodiscard]] std::string paint();

 private:
  /// A line of a legend: a disc of a colour, perhaps with a rim, and words.
  struct Entry {
    Colour fill;
    double size = 1;  ///< of the disc, by the height of a letter
    bool rim = false;
    std::string words;
  };
  /// The square of the world that every panel shows.
  struct View {
    double x = 0, y = 0, half = 1;
  };
  /// Lengths on the canvas.
  struct Layout {
    double gap = 0, panel = 0, font = 0, line = 0, height = 0;
  };

  [[nodiscard]] View choose_view() const;
  [[nodiscard]] Layout lay_out() const;
  [[nodiscard]] std::vector<Entry> legend(const Panel& panel) const;
  void find_levels();

  void paint_panel(const Panel& panel, double left);
  void paint_grid(const Panel& panel);
  void paint_level(const Panel& panel, int level);
  void paint_world();
  void paint_outlines();
  void paint_cells(const Panel& panel);
  void paint_tables(const Panel& panel);
  void paint_scale_bar(double left);
  void paint_legend(const Panel& panel, double left);
  void paint_grid_legend();
  void stroke(double width, const Colour& colour);

  // World to canvas, in the panel that is being painted.
  [[nodiscard]] double px(double x) const { return centre_x_ + (x - view_.x) * scale_; }
  [[nodiscard]] double py(double y) const { return centre_y_ - (y - view_.y) * scale_; }

  const Picture& picture_;
  View view_;
  Layout layout_;
  double scale_ = 1, centre_x_ = 0, centre_y_ = 0;
  double low_ = 0, high_ = 0;  ///< content of the grid at both ends of its scale
  Canvas canvas_;
};

}  // namespace somas::report
