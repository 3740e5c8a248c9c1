// A cairo surface in memory, and the file that it becomes.
#pragma once

#include <cairo.h>
#include <string>
#include <string_view>

#include "core/report/picture.hpp"

namespace somas::report {

/// Colour channels in [0, 1].
struct Colour {
  double red = 0, green = 0, blue = 0, alpha = 1;
};

/// Lengths are pixels in a PNG and points in SVG and PDF, from the upper left corner. The same
/// calls give the same bytes: no dates, no counters of the process.
class Canvas {
 public:
  /// Throws std::runtime_error with cairo's reason.
  Canvas(PictureFormat format, double width, double height);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  [[nodiscard]] cairo_t* context() const { return context_; }
  void colour(const Colour& colour) const;
  void disc(double x, double y, double radius) const;
  /// One line from (x, y) on, the baseline; made smaller if it is wider than `room`.
  void text(double x, double y, double size, double room, const std::string& text) const;
  /// The file's bytes; nothing can be drawn afterwards. Throws std::runtime_error.
  [[nodiscard]] std::string finish();

 private:
  void check(cairo_status_t status) const;

  PictureFormat format_;
  std::string bytes_;
  cairo_surface_t* surface_ = nullptr;
  cairo_t* context_ = nullptr;
};

}  // namespace somas::report
