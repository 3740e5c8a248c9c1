// A small chart: two linear axes with ticks, curves, bands, stacked areas, bars.
//
// Why not a library: Debian packages no plotting library for C++, and gnuplot would be one more
// program that must be there when a figure is made, with bytes that change from version to version.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/report/canvas.hpp"

namespace somas::report {

/// Of curves that must not differ in their colours alone; points, 0: unbroken.
inline constexpr std::array<double, 4> dashes = {0, 4, 1.5, 7};

struct Axis {
  double low = 0, high = 1;
  std::string label;   ///< with the unit in brackets
  bool whole = false;  ///< ticks at whole numbers only
};

/// Positions of about `count` ticks at 1, 2 or 5 times a power of ten, all within the axis.
[[nodiscard]] std::vector<double> ticks_of(const Axis& axis, int count);
/// The next tick at or above: a pleasant end for an axis that starts at 0.
[[nodiscard]] double round_end(double most);

class Chart {
 public:
  /// `area` holds the plot and its labels. `left`: room for the labels of the y axis, so that
  /// charts below each other line up; `with_x`: the x axis has labels.
  Chart(const Canvas& canvas, const Rect& area, Axis x, Axis y, double left, bool with_x = true);

  /// Room that the labels of a y axis need.
  [[nodiscard]] static double left_margin(const Canvas& canvas, const Axis& y);
  static constexpr double bottom_margin = 20, top_margin = 4;

  /// Axes, ticks and labels: call last, since they go over everything.
  void axes() const;

  void line(std::span<const double> x, std::span<const double> y, const Colour& colour,
            double width = 1.1, double dash = 0) const;
  void band(std::span<const double> x, std::span<const double> low, std::span<const double> high,
            const Colour& colour) const;
  /// From x0 to x1 over the full height.
  void shade(double x0, double x1, const Colour& colour) const;
  void bar(double x0, double x1, double low, double high, const Colour& colour) const;
  void vertical(double x, const Colour& colour, double dash = 0) const;
  void marker(double x, double y, Marker shape, double size, const Colour& colour) const;

  [[nodiscard]] double px(double x) const;
  [[nodiscard]] double py(double y) const;
  [[nodiscard]] const Rect& plot() const { return plot_; }

 private:
  void trace(std::span<const double> x, std::span<const double> y) const;

  const Canvas& canvas_;
  Rect plot_;
  Axis x_, y_;
  double left_;
  bool with_x_;
};

}  // namespace somas::report
