#include "core/report/canvas.hpp"

#include <stdexcept>
#include <utility>

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include "somas/sdk/math.hpp"

namespace somas::report {
namespace {

// An exception must not pass through cairo, which is C.
cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) noexcept {
  try {
    static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
  } catch (const std::exception&) {
    return CAIRO_STATUS_NO_MEMORY;
  }
}

cairo_surface_t* surface_of(PictureFormat format, double width, double height, std::string& bytes) {
  if (format == PictureFormat::svg)
    return cairo_svg_surface_create_for_stream(append, &bytes, width, height);
  if (format == PictureFormat::png)
    return cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width),
                                      static_cast<int>(height));
  cairo_surface_t* pdf = cairo_pdf_surface_create_for_stream(append, &bytes, width, height);
  // Else cairo writes the time of day.
  cairo_pdf_surface_set_metadata(pdf, CAIRO_PDF_METADATA_CREATE_DATE, "1970-01-01T00:00:00Z");
  return pdf;
}

// The id of the outermost group is a counter of all surfaces of the process; nothing refers to it.
void forget_surface_number(std::string& svg) {
  const std::string_view before = "<g id=\"surface";
  const std::size_t at = svg.find(before);
  if (at == std::string::npos) return;
  const std::size_t number = at + before.size();
  svg.erase(number, svg.find('"', number) - number);
}

// Letters of the same shape and width everywhere, whatever the desktop prefers.
void choose_font(cairo_t* context) {
  cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(context, options);
  cairo_font_options_destroy(options);
}

}  // namespace

Canvas::Canvas(PictureFormat format, double width, double height)
    : format_(format),
      surface_(surface_of(format, width, height, bytes_)),
      context_(cairo_create(surface_)) {
  try {
    check(cairo_status(context_));
  } catch (...) {
    cairo_destroy(context_);
    cairo_surface_destroy(surface_);
    throw;
  }
  choose_font(context_);
  colour({1, 1, 1, 1});
  cairo_paint(context_);
}

Canvas::~Canvas() {
  cairo_destroy(context_);
  cairo_surface_destroy(surface_);
}

void Canvas::colour(const Colour& c) const {
  cairo_set_source_rgba(context_, c.red, c.green, c.blue, c.alpha);
}

void Canvas::disc(double x, double y, double radius) const {
  cairo_new_sub_path(context_);
  cairo_arc(context_, x, y, radius, 0, math::two_pi);
  cairo_close_path(context_);
}

void Canvas::text(double x, double y, double size, double room, const std::string& text) const {
  cairo_set_font_size(context_, size);
  cairo_text_extents_t extents;
  cairo_text_extents(context_, text.c_str(), &extents);
  if (extents.x_advance > room) cairo_set_font_size(context_, size * room / extents.x_advance);
  cairo_move_to(context_, x, y);
  cairo_show_text(context_, text.c_str());
}

std::string Canvas::finish() {
  check(cairo_status(context_));
  if (format_ == PictureFormat::png)
    check(cairo_surface_write_to_png_stream(surface_, append, &bytes_));
  cairo_surface_finish(surface_);
  check(cairo_surface_status(surface_));
  if (format_ == PictureFormat::svg) forget_surface_number(bytes_);
  return std::move(bytes_);
}

void Canvas::check(cairo_status_t status) const {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw the picture: ") +
                             cairo_status_to_string(status));
}

}  // namespace somas::report
