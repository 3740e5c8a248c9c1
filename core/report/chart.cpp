#include "core/report/chart.hpp"

#include <algorithm>
#include <cmath>

#include "core/report/figure.hpp"
#include "core/report/scene_painter.hpp"

namespace somas::report {
namespace {

constexpr double tick_length = 2.5;

double round_step(double least, bool whole) {
  if (whole && least <= 1) return 1;
  double power = 1;
  while (power >= least) power /= 10;
  while (power * 10 < least) power *= 10;
  for (const double factor : {1.0, 2.0, 5.0, 10.0})
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

std::string tick_text(double value) {
  const double nearest = std::round(value);
  if (std::abs(value - nearest) < 1e-9 && nearest >= 1000 && nearest < 1e15)
    return grouped(static_cast<std::uint64_t>(nearest));
  return number(std::abs(value) < 1e-12 ? 0 : value);
}

}  // namespace

std::vector<double> ticks_of(const Axis& axis, int count) {
  const double step = round_step((axis.high - axis.low) / std::max(1, count), axis.whole);
  std::vector<double> ticks;
  const double slack = 1e-9 * step;
  for (double i = std::ceil((axis.low - slack) / step); i * step <= axis.high + slack; ++i)
    ticks.push_back(i * step);
  return ticks;
}

double round_end(double most) {
  if (!(most > 0)) return 1;
  const double step = round_step(most / 8, false);
  return step * std::ceil(most / step * (1 - 1e-12));
}

Chart::Chart(const Canvas& canvas, const Rect& area, Axis x, Axis y, double left, bool with_x)
    : canvas_(canvas),
      plot_{area.x + left, area.y + top_margin, area.width - left - 8,
            area.height - top_margin - (with_x ? bottom_margin : 3)},
      x_(std::move(x)),
      y_(std::move(y)),
      left_(left),
      with_x_(with_x) {
  // A life of one step, a single generation.
  if (!(x_.high > x_.low)) x_.high = x_.low + 1;
  if (!(y_.high > y_.low)) y_.high = y_.low + 1;
}

double Chart::left_margin(const Canvas& canvas, const Axis& y) {
  double widest = 0;
  for (const double tick : ticks_of(y, 4))
    widest = std::max(widest, canvas.width_of(tick_font, tick_text(tick)));
  return widest + tick_length + 3 + 1.4 * label_font;
}

double Chart::px(double x) const {
  return plot_.x + plot_.width * (x - x_.low) / (x_.high - x_.low);
}
double Chart::py(double y) const {
  return plot_.bottom() - plot_.height * (y - y_.low) / (y_.high - y_.low);
}

void Chart::axes() const {
  const int room_up = std::clamp(static_cast<int>(plot_.height / 16), 1, 5);
  for (const double tick : ticks_of(y_, room_up)) {
    canvas_.line(plot_.x - tick_length, py(tick), plot_.x, py(tick), 0.6, black);
    canvas_.colour(black);
    canvas_.label(plot_.x - tick_length - 1.5, py(tick) + 0.36 * tick_font, tick_font,
                  tick_text(tick), Anchor::right);
  }
  const int room = std::max(2, static_cast<int>(plot_.width / 36));
  for (const double tick : ticks_of(x_, room)) {
    canvas_.line(px(tick), plot_.bottom(), px(tick), plot_.bottom() + tick_length, 0.6, black);
    canvas_.colour(black);
    if (with_x_)
      canvas_.label(px(tick), plot_.bottom() + tick_length + 1 + tick_font, tick_font,
                    tick_text(tick), Anchor::middle);
  }
  canvas_.frame(plot_, 0.6, black);
  canvas_.colour(black);
  canvas_.upright_label(plot_.x - left_ + label_font, plot_.y + plot_.height / 2, label_font,
                        y_.label);
  if (with_x_)
    canvas_.label(plot_.x + plot_.width / 2, plot_.bottom() + bottom_margin - 1, label_font,
                  x_.label, Anchor::middle);
}

void Chart::trace(std::span<const double> x, std::span<const double> y) const {
  for (std::size_t i = 0; i < x.size(); ++i) cairo_line_to(canvas_.context(), px(x[i]), py(y[i]));
}

void Chart::line(std::span<const double> x, std::span<const double> y, const Colour& colour,
                 double width, double dash) const {
  cairo_t* c = canvas_.context();
  cairo_new_path(c);
  trace(x, y);
  if (dash > 0) cairo_set_dash(c, &dash, 1, 0);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  canvas_.stroke(width, colour);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_MITER);
  cairo_set_dash(c, nullptr, 0, 0);
}

void Chart::band(std::span<const double> x, std::span<const double> low,
                 std::span<const double> high, const Colour& colour) const {
  cairo_new_path(canvas_.context());
  trace(x, high);
  for (std::size_t i = x.size(); i-- > 0;) cairo_line_to(canvas_.context(), px(x[i]), py(low[i]));
  cairo_close_path(canvas_.context());
  canvas_.fill(colour);
}

void Chart::shade(double x0, double x1, const Colour& colour) const {
  bar(x0, x1, y_.low, y_.high, colour);
}

void Chart::bar(double x0, double x1, double low, double high, const Colour& colour) const {
  const double left = std::max(px(x0), plot_.x), right = std::min(px(x1), plot_.right());
  if (left >= right || high <= low) return;
  canvas_.fill({left, py(high), right - left, py(low) - py(high)}, colour);
}

void Chart::vertical(double x, const Colour& colour, double dash) const {
  if (dash > 0) cairo_set_dash(canvas_.context(), &dash, 1, 0);
  canvas_.line(px(x), plot_.y, px(x), plot_.bottom(), 0.7, colour);
  cairo_set_dash(canvas_.context(), nullptr, 0, 0);
}

void Chart::marker(double x, double y, Marker shape, double size, const Colour& colour) const {
  canvas_.marker(px(x), py(y), shape, size, colour);
}

}  // namespace somas::report
