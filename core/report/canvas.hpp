// A cairo surface in memory, and the file that it becomes.
#pragma once

#include <cairo.h>
#include <string>
#include <string_view>
#include <vector>

#include "core/report/palette.hpp"

namespace somas::report {

enum class PictureFormat { svg, pdf, png };

/// Which part of a line of text lies at the given x.
enum class Anchor { left, middle, right };

/// The shape of a point.
enum class Marker { disc, ring, square, triangle, diamond };

struct Rect {
  double x = 0, y = 0, width = 0, height = 0;  ///< from the upper left corner
  [[nodiscard]] double right() const { return x + width; }
  [[nodiscard]] double bottom() const { return y + height; }
};

/// Lengths are points in SVG and PDF, from the upper left corner; in a PNG `scale` pixels make one
/// of them. The same calls give the same bytes: no dates, no counters of the process.
class Canvas {
 public:
  /// Throws std::runtime_error with cairo's reason.
  Canvas(PictureFormat format, double width, double height, double scale = 1);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  [[nodiscard]] cairo_t* context() const { return context_; }
  void colour(const Colour& colour) const;
  void disc(double x, double y, double radius) const;
  /// One line from (x, y) on, the baseline; made smaller if it is wider than `room`.
  void text(double x, double y, double size, double room, const std::string& text) const;
  /// One line whose baseline is at y; returns its width.
  double label(double x, double y, double size, const std::string& text,
               Anchor anchor = Anchor::left) const;
  /// The same, read from below to above; the middle of the line is at (x, y).
  void upright_label(double x, double y, double size, const std::string& text) const;
  [[nodiscard]] double width_of(double size, const std::string& text) const;
  /// Words broken into lines that are no wider than `room`.
  [[nodiscard]] std::vector<std::string> wrapped(double size, double room,
                                                 const std::string& text) const;
  /// A point of `size` across.
  void marker(double x, double y, Marker shape, double size, const Colour& colour) const;
  void line(double x0, double y0, double x1, double y1, double width, const Colour& colour) const;
  void fill(const Rect& rect, const Colour& colour) const;
  void frame(const Rect& rect, double width, const Colour& colour) const;
  /// Stroke or fill of the current path, which is gone afterwards; a width of 0 draws nothing.
  void stroke(double width, const Colour& colour) const;
  void fill(const Colour& colour) const;

  /// Says in the file what it shows, for search and for screen readers: in SVG as title, with all
  /// that is written in the picture as desc; in PDF as title; in PNG nothing.
  void title(const std::string& title) { title_ = title; }
  /// Pixels of a PNG so far, row by row, 4 bytes each: blue, green, red, nothing. Valid until more
  /// is drawn.
  [[nodiscard]] std::string_view pixels() const;
  /// The file's bytes; nothing can be drawn afterwards. Throws std::runtime_error.
  [[nodiscard]] std::string finish();

 private:
  void check(cairo_status_t status) const;

  PictureFormat format_;
  std::string title_;
  mutable std::vector<std::string> written_;  ///< all labels, for desc
  std::string bytes_;
  cairo_surface_t* surface_ = nullptr;
  cairo_t* context_ = nullptr;
};

}  // namespace somas::report
