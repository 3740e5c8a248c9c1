#include "core/report/canvas.hpp"

#include <algorithm>
#include <initializer_list>
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

cairo_surface_t* surface_of(PictureFormat format, double width, double height, double scale,
                            std::string& bytes) {
  if (format == PictureFormat::svg)
    return cairo_svg_surface_create_for_stream(append, &bytes, width, height);
  if (format == PictureFormat::png)
    return cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width * scale + 0.5),
                                      static_cast<int>(height * scale + 0.5));
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

std::string escaped(const std::string& text) {
  std::string xml;
  for (const char c : text) {
    if (c == '&')
      xml += "&amp;";
    else if (c == '<')
      xml += "&lt;";
    else if (c == '>')
      xml += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      xml += c;
  }
  return xml;
}

// Right after the opening tag, where readers look for it. Letters themselves are drawn as shapes.
void add_title(std::string& svg, const std::string& title,
               const std::vector<std::string>& written) {
  const std::size_t root = svg.find("<svg");
  const std::size_t at = svg.find('>', root);
  if (root == std::string::npos || at == std::string::npos) return;
  std::string text = "\n<title>" + escaped(title) + "</title>\n<desc>";
  for (const std::string& line : written) text += escaped(line) + "\n";
  svg.insert(at + 1, text + "</desc>");
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

Canvas::Canvas(PictureFormat format, double width, double height, double scale)
    : format_(format),
      surface_(surface_of(format, width, height, scale, bytes_)),
      context_(cairo_create(surface_)) {
  try {
    check(cairo_status(context_));
  } catch (...) {
    cairo_destroy(context_);
    cairo_surface_destroy(surface_);
    throw;
  }
  if (format == PictureFormat::png) cairo_scale(context_, scale, scale);
  choose_font(context_);
  colour(white);
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

double Canvas::width_of(double size, const std::string& text) const {
  cairo_set_font_size(context_, size);
  cairo_text_extents_t extents;
  cairo_text_extents(context_, text.c_str(), &extents);
  return extents.x_advance;
}

double Canvas::label(double x, double y, double size, const std::string& text,
                     Anchor anchor) const {
  const double width = width_of(size, text);
  const double share = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? 0.5 : 1;
  cairo_move_to(context_, x - share * width, y);
  cairo_show_text(context_, text.c_str());
  cairo_new_path(context_);
  written_.push_back(text);
  return width;
}

void Canvas::upright_label(double x, double y, double size, const std::string& text) const {
  cairo_save(context_);
  cairo_translate(context_, x, y);
  cairo_rotate(context_, -math::two_pi / 4);
  label(0, 0, size, text, Anchor::middle);
  cairo_restore(context_);
}

std::vector<std::string> Canvas::wrapped(double size, double room, const std::string& text) const {
  std::vector<std::string> lines;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    const std::string longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && width_of(size, longer) > room) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
    at = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

void Canvas::marker(double x, double y, Marker shape, double size, const Colour& c) const {
  const double r = size / 2;
  cairo_new_path(context_);
  const auto polygon = [&](std::initializer_list<std::pair<double, double>> corners) {
    for (const auto& [dx, dy] : corners) cairo_line_to(context_, x + dx * r, y + dy * r);
    cairo_close_path(context_);
  };
  switch (shape) {
    case Marker::ring:
      disc(x, y, 0.85 * r);
      return stroke(0.3 * r, c);
    case Marker::square:
      polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
      break;
    case Marker::triangle:
      polygon({{0, -1.15}, {1.1, 0.85}, {-1.1, 0.85}});
      break;
    case Marker::diamond:
      polygon({{0, -1.3}, {1.15, 0}, {0, 1.3}, {-1.15, 0}});
      break;
    case Marker::disc:
      disc(x, y, r);
      break;
  }
  fill(c);
}

void Canvas::line(double x0, double y0, double x1, double y1, double width,
                  const Colour& colour) const {
  cairo_move_to(context_, x0, y0);
  cairo_line_to(context_, x1, y1);
  stroke(width, colour);
}

void Canvas::fill(const Rect& rect, const Colour& colour) const {
  cairo_rectangle(context_, rect.x, rect.y, rect.width, rect.height);
  fill(colour);
}

void Canvas::frame(const Rect& rect, double width, const Colour& colour) const {
  cairo_rectangle(context_, rect.x, rect.y, rect.width, rect.height);
  stroke(width, colour);
}

void Canvas::stroke(double width, const Colour& c) const {
  if (!(width > 0)) return cairo_new_path(context_);
  colour(c);
  cairo_set_line_width(context_, width);
  cairo_stroke(context_);
}

void Canvas::fill(const Colour& c) const {
  colour(c);
  cairo_fill(context_);
}

std::string_view Canvas::pixels() const {
  cairo_surface_flush(surface_);
  const auto rows = static_cast<std::size_t>(cairo_image_surface_get_height(surface_));
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(surface_));
  return {reinterpret_cast<const char*>(cairo_image_surface_get_data(surface_)), rows * stride};
}

std::string Canvas::finish() {
  if (format_ == PictureFormat::pdf && !title_.empty())
    cairo_pdf_surface_set_metadata(surface_, CAIRO_PDF_METADATA_TITLE, title_.c_str());
  check(cairo_status(context_));
  if (format_ == PictureFormat::png)
    check(cairo_surface_write_to_png_stream(surface_, append, &bytes_));
  cairo_surface_finish(surface_);
  check(cairo_surface_status(surface_));
  if (format_ == PictureFormat::svg) forget_surface_number(bytes_);
  if (format_ == PictureFormat::svg && !title_.empty()) add_title(bytes_, title_, written_);
  return std::move(bytes_);
}

void Canvas::check(cairo_status_t status) const {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw the picture: ") +
                             cairo_status_to_string(status));
}

}  // namespace somas::report
