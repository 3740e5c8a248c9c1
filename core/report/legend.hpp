// Keys of a figure: swatches and words, filled into lines of a given width.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/report/canvas.hpp"

namespace somas::report {

struct LegendEntry {
  enum class Swatch {
    disc,    ///< a cell
    rim,     ///< a cell with a thick rim
    ring,    ///< a cell's outline
    dot,     ///< a particle
    box,     ///< an area
    hatch,   ///< a striped area
    line,    ///< a curve
    marker,  ///< a point of a curve
    length,  ///< a bar as long as its words say
    ramp,    ///< a scale of colours between two numbers
  };
  Swatch swatch = Swatch::disc;
  Colour colour{};
  std::string words;
  std::function<Colour(double)> ramp = {};  ///< colour at 0 to 1
  std::string low = {}, high = {};          ///< at the ends of the ramp
  Marker marker = Marker::disc;
  double length = 0;  ///< of the bar, in points
  double dash = 0;    ///< of the line, in points; 0: unbroken
};

class Legend {
 public:
  Legend(std::vector<LegendEntry> entries, double font)
      : entries_(std::move(entries)), font_(font) {}

  /// How high it is when filled into `width`.
  [[nodiscard]] double height(const Canvas& canvas, double width) const;
  /// Draws it with its upper left corner at (x, y); returns its height.
  double paint(const Canvas& canvas, double x, double y, double width) const;

 private:
  [[nodiscard]] double width_of(const Canvas& canvas, const LegendEntry& entry) const;
  [[nodiscard]] double swatch_width(const Canvas& canvas, const LegendEntry& entry) const;
  void paint_entry(const Canvas& canvas, const LegendEntry& entry, double x, double y) const;
  double fill(const Canvas& canvas, double x, double y, double width, bool drawn) const;

  std::vector<LegendEntry> entries_;
  double font_;
};

}  // namespace somas::report
