#include "core/report/legend.hpp"

namespace somas::report {
namespace {

constexpr int ramp_steps = 32;
using Swatch = LegendEntry::Swatch;

void hatch(const Canvas& canvas, const Rect& box) {
  cairo_t* c = canvas.context();
  cairo_save(c);
  cairo_rectangle(c, box.x, box.y, box.width, box.height);
  cairo_clip(c);
  for (double x = box.x - box.height; x < box.right(); x += 2.4) {
    cairo_move_to(c, x, box.bottom());
    cairo_line_to(c, x + box.height, box.y);
  }
  canvas.stroke(0.4, rgb(0x606060));
  cairo_restore(c);
  canvas.frame(box, 0.4, rgb(0x8C8C8C));
}

}  // namespace

double Legend::swatch_width(const Canvas& canvas, const LegendEntry& entry) const {
  if (entry.swatch == Swatch::ramp)
    return 4 * font_ + canvas.width_of(font_, entry.low) + canvas.width_of(font_, entry.high) +
           0.8 * font_;
  if (entry.swatch == Swatch::line) return 2 * font_;
  if (entry.swatch == Swatch::length) return entry.length;
  return font_;
}

double Legend::width_of(const Canvas& canvas, const LegendEntry& entry) const {
  return swatch_width(canvas, entry) + 0.4 * font_ + canvas.width_of(font_, entry.words);
}

void Legend::paint_entry(const Canvas& canvas, const LegendEntry& entry, double x, double y) const {
  const double f = font_, middle = y - 0.36 * f;
  const Rect box{x, y - 0.8 * f, f, 0.85 * f};
  double words = x + swatch_width(canvas, entry) + 0.4 * f;
  switch (entry.swatch) {
    case Swatch::disc:
    case Swatch::dot:
      canvas.disc(x + 0.5 * f, middle, (entry.swatch == Swatch::disc ? 0.42 : 0.18) * f);
      canvas.fill(entry.colour);
      break;
    case Swatch::rim:
    case Swatch::ring:
      canvas.disc(x + 0.5 * f, middle, 0.36 * f);
      canvas.stroke((entry.swatch == Swatch::rim ? 0.18 : 0.07) * f, entry.colour);
      break;
    case Swatch::box:
      canvas.fill(box, entry.colour);
      canvas.frame(box, 0.3, rgb(0x8C8C8C));
      break;
    case Swatch::hatch:
      hatch(canvas, box);
      break;
    case Swatch::line:
      if (entry.dash > 0) cairo_set_dash(canvas.context(), &entry.dash, 1, 0);
      canvas.line(x, middle, x + 2 * f, middle, 1.1, entry.colour);
      cairo_set_dash(canvas.context(), nullptr, 0, 0);
      break;
    case Swatch::length:
      canvas.line(x, middle, x + entry.length, middle, 1.2, black);
      for (const double end : {x, x + entry.length})
        canvas.line(end, middle - 0.25 * f, end, middle + 0.25 * f, 0.6, black);
      break;
    case Swatch::marker:
      canvas.marker(x + 0.5 * f, middle, entry.marker, 0.6 * f, entry.colour);
      break;
    case Swatch::ramp: {
      canvas.colour(black);
      const double left = x + canvas.label(x, y, f, entry.low) + 0.4 * f;
      for (int i = 0; i < ramp_steps; ++i)
        canvas.fill({left + 4 * f * i / ramp_steps, y - 0.8 * f,
                     4 * f / ramp_steps + (i + 1 < ramp_steps ? 0.4 : 0), 0.9 * f},
                    entry.ramp((i + 0.5) / ramp_steps));
      canvas.frame({left, y - 0.8 * f, 4 * f, 0.9 * f}, 0.4, frame_grey);
      canvas.colour(black);
      canvas.label(left + 4.4 * f, y, f, entry.high);
      words = x + swatch_width(canvas, entry) + 0.6 * f;
      break;
    }
  }
  canvas.colour(black);
  canvas.label(words, y, f, entry.words);
}

double Legend::fill(const Canvas& canvas, double x, double y, double width, bool drawn) const {
  if (entries_.empty()) return 0;
  const double line = 1.45 * font_;
  double at = x, baseline = y + font_;
  for (const LegendEntry& entry : entries_) {
    const double wide = width_of(canvas, entry);
    if (at > x && at + wide > x + width) {
      at = x;
      baseline += line;
    }
    if (drawn) paint_entry(canvas, entry, at, baseline);
    at += wide + 1.3 * font_;
  }
  return baseline + 0.45 * font_ - y;
}

double Legend::height(const Canvas& canvas, double width) const {
  return fill(canvas, 0, 0, width, false);
}

double Legend::paint(const Canvas& canvas, double x, double y, double width) const {
  return fill(canvas, x, y, width, true);
}

}  // namespace somas::report
