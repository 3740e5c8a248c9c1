// Pictures read back: the pixels of a PNG, the elements of an SVG.
#pragma once

#include <cairo.h>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/report/palette.hpp"

namespace somas::report::test {

/// A PNG read back.
class Pixels {
 public:
  explicit Pixels(std::string bytes) : bytes_(std::move(bytes)) {
    surface_ = cairo_image_surface_create_from_png_stream(
        [](void* self, unsigned char* out, unsigned length) {
          auto& pixels = *static_cast<Pixels*>(self);
          if (pixels.read_ + length > pixels.bytes_.size()) return CAIRO_STATUS_READ_ERROR;
          std::memcpy(out, pixels.bytes_.data() + pixels.read_, length);
          pixels.read_ += length;
          return CAIRO_STATUS_SUCCESS;
        },
        this);
    EXPECT_EQ(cairo_surface_status(surface_), CAIRO_STATUS_SUCCESS);
  }
  ~Pixels() { cairo_surface_destroy(surface_); }
  Pixels(const Pixels&) = delete;
  Pixels& operator=(const Pixels&) = delete;

  [[nodiscard]] int width() const { return cairo_image_surface_get_width(surface_); }
  [[nodiscard]] int height() const { return cairo_image_surface_get_height(surface_); }
  [[nodiscard]] unsigned at(int x, int y) const {
    const unsigned char* row =
        cairo_image_surface_get_data(surface_) + y * cairo_image_surface_get_stride(surface_);
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, row + 4 * x, 4);
    return pixel & 0xFFFFFF;
  }
  [[nodiscard]] int count(unsigned colour) const {
    int found = 0;
    for (int y = 0; y < height(); ++y)
      for (int x = 0; x < width(); ++x) found += at(x, y) == colour ? 1 : 0;
    return found;
  }

 private:
  std::string bytes_;
  std::size_t read_ = 0;
  cairo_surface_t* surface_ = nullptr;
};

/// Shapes of an SVG by cairo that are filled with a colour.
inline int filled(const std::string& svg, const Colour& colour) {
  const auto percent = [](double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4f", 100 * share);
    return std::string(text);
  };
  int found = 0;
  for (std::size_t at = svg.find("fill:rgb("); at != std::string::npos;
       at = svg.find("fill:rgb(", at + 1)) {
    double red = 0, green = 0, blue = 0;
    if (std::sscanf(svg.c_str() + at, "fill:rgb(%lf%%,%lf%%,%lf%%)", &red, &green, &blue) != 3)
      continue;
    found += percent(red / 100) == percent(colour.red) &&
                     percent(green / 100) == percent(colour.green) &&
                     percent(blue / 100) == percent(colour.blue)
                 ? 1
                 : 0;
  }
  return found;
}

/// Its title, which is the caption.
inline std::string title(const std::string& svg) {
  const std::size_t from = svg.find("<title>"), to = svg.find("</title>");
  return from == std::string::npos ? "" : svg.substr(from + 7, to - from - 7);
}

/// All that is written in an SVG of ours, a line a label.
inline std::string written(const std::string& svg) {
  const std::size_t from = svg.find("<desc>"), to = svg.find("</desc>");
  return from == std::string::npos ? "" : svg.substr(from + 6, to - from - 6);
}

}  // namespace somas::report::test
