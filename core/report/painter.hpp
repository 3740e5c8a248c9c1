// Puts the panels of a picture, their titles and legends on a canvas.
#pragma once

#include <string>
#include <vector>

#include "core/report/canvas.hpp"
#include "core/report/picture.hpp"
#include "core/report/scene_painter.hpp"

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
  /// Lengths on the canvas.
  struct Layout {
    double gap = 0, panel = 0, font = 0, line = 0, height = 0;
  };

  [[nodiscard]] Layout lay_out() const;
  [[nodiscard]] std::vector<Entry> legend(const Scene& panel) const;

  void paint_panel(const Scene& panel, double left);
  void paint_legend(const Scene& panel, double left);
  void paint_grid_legend();

  const Picture& picture_;
  View view_;
  Layout layout_;
  Levels levels_;
  Canvas canvas_;
  ScenePainter painter_;
};

}  // namespace somas::report
