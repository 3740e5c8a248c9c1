#include "core/report/life_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/report/chart.hpp"
#include "core/report/scene_painter.hpp"

namespace somas::report {
namespace {

using Swatch = LegendEntry::Swatch;

constexpr std::array<const char*, 4> numerals = {"I", "II", "III", "IV"};

double most_of(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

Axis time_axis(const LifeHistory& history) {
  return {.low = history.step().front(),
          .high = history.step().back(),
          .label = "time (steps)",
          .whole = true};
}

// Darker than the ground of a picture: there are no cells to stand out from.
Colour availability_grey(double share) { return between(white, rgb(0xC4C4C4), share); }

bool scarce(const std::vector<double>& availability) {
  return std::any_of(availability.begin(), availability.end(), [](double a) { return a < 0.9; });
}

// Neighbours of the same grey, to a sixteenth, become one rectangle.
void shade_availability(const Chart& chart, const LifeHistory& history,
                        const std::vector<double>& availability) {
  const auto grey_at = [&](std::size_t i) { return std::round(16 * availability[i]) / 16; };
  for (std::size_t first = 0; first < availability.size();) {
    std::size_t end = first + 1;
    while (end < availability.size() && grey_at(end) == grey_at(first)) ++end;
    if (grey_at(first) > 0)
      chart.shade(history.step()[first] - 0.5, history.step()[end - 1] + 0.5,
                  availability_grey(grey_at(first)));
    first = end;
  }
}

// ---- phases -------------------------------------------------------------------------------------

/// Sums over bins of equal width, all series alike.
struct Bins {
  double width = 1;
  std::vector<double> left;

  explicit Bins(const LifeHistory& history) {
    const double least = static_cast<double>(history.steps()) / 60;
    width = 1;
    for (const double w : {2.0, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0, 200.0, 500.0, 1000.0})
      if (width < least) width = w;
    for (double x = history.step().front(); x <= history.step().back(); x += width)
      left.push_back(x);
  }
  [[nodiscard]] std::vector<double> sums(const std::vector<double>& series) const {
    std::vector<double> sum(left.size(), 0);
    for (std::size_t i = 0; i < series.size(); ++i)
      sum[std::min(left.size() - 1, static_cast<std::size_t>(static_cast<double>(i) / width))] +=
          series[i];
    return sum;
  }
};

class PhasesFigure {
 public:
  PhasesFigure(const LifeHistory& history, const Subject& subject, const FigureSize& size)
      : history_(history),
        size_(size),
        bins_(history),
        phases_(phases_of(history)),
        subject_(subject) {}

  [[nodiscard]] std::string render() {
    Frame frame{.title = "Phases of a life.",
                .caption = caption(),
                .legend = legend(),
                .body = numerals_height + 4 * part_height() + Chart::bottom_margin};
    frame.paint = [this](const Canvas& canvas, const Rect& body) { paint(canvas, body); };
    return draw(frame, size_);
  }

 private:
  static constexpr double numerals_height = 10;
  [[nodiscard]] double part_height() const { return std::clamp(0.17 * size_.width(), 50.0, 80.0); }

  [[nodiscard]] std::string caption() const {
    std::string text;
    for (std::size_t i = 0; i < phases_.size(); ++i)
      text += std::string(i == 0 ? "" : ", ") + numerals[i] + " " + phases_[i].name + " (" +
              grouped(static_cast<std::uint64_t>(phases_[i].first)) + " to " +
              grouped(static_cast<std::uint64_t>(phases_[i].last)) + ")";
    return text + ". Deaths, divisions and specializations are those of " + number(bins_.width) +
           (bins_.width == 1 ? " step" : " steps") +
           "; resources and moving things are shares of their most. " + caption_of(subject_);
  }

  [[nodiscard]] std::vector<LegendEntry> legend() const;
  void paint(const Canvas& canvas, const Rect& body);
  void paint_numerals(const Canvas& canvas, const Chart& chart) const;
  void paint_cells(const Chart& chart) const;
  void paint_deaths(const Chart& chart) const;
  void paint_actions(const Chart& chart) const;
  void paint_world(const Chart& chart) const;
  [[nodiscard]] std::vector<double> deaths_of_bins() const;
  [[nodiscard]] static std::optional<std::size_t> first_above_0(const std::vector<double>& series) {
    for (std::size_t i = 0; i < series.size(); ++i)
      if (series[i] > 0) return i;
    return std::nullopt;
  }
  [[nodiscard]] bool happened(std::size_t cause) const {
    return first_above_0(history_.deaths().values[cause]).has_value();
  }

  const LifeHistory& history_;
  FigureSize size_;
  Bins bins_;
  std::vector<Phase> phases_;
  const Subject& subject_;
};

constexpr Colour division_colour = black, specialization_colour = rgb(0x56B4E9);

std::vector<LegendEntry> PhasesFigure::legend() const {
  std::vector<LegendEntry> entries;
  const auto& states = history_.cells();
  for (std::size_t s = 0; s < states.names.size(); ++s)
    entries.push_back(
        {.swatch = Swatch::box, .colour = colour_of_state(s), .words = states.names[s]});
  const auto later_state = [&](std::size_t s) {
    return s > 0 && first_above_0(states.values[s]).has_value();
  };
  bool specialized = false;
  for (std::size_t s = 0; s < states.names.size(); ++s) specialized |= later_state(s);
  if (specialized)
    entries.push_back({.swatch = Swatch::marker,
                       .colour = black,
                       .words = "first cell of a state",
                       .marker = Marker::triangle});
  for (std::size_t c = 0; c < history_.deaths().names.size(); ++c)
    if (happened(c))
      entries.push_back({.swatch = Swatch::box,
                         .colour = colour_of_cause(c),
                         .words = "death: " + history_.deaths().names[c]});
  entries.push_back({.swatch = Swatch::line, .colour = division_colour, .words = "divisions"});
  entries.push_back({.swatch = Swatch::line,
                     .colour = specialization_colour,
                     .words = "specializations",
                     .dash = 4});
  const std::string most = " (most: ";
  for (std::size_t r = 0; r < history_.resources().names.size(); ++r)
    entries.push_back({.swatch = Swatch::line,
                       .colour = frame_grey,
                       .words = history_.resources().names[r] + most +
                                number(most_of(history_.resources().values[r])) + ")",
                       .dash = dashes[r % dashes.size()]});
  for (std::size_t t = 0; t < history_.tables().names.size(); ++t)
    entries.push_back({.swatch = Swatch::line,
                       .colour = colour_of_table(t),
                       .words = history_.tables().names[t] + most +
                                number(most_of(history_.tables().values[t])) + ")"});
  return entries;
}

std::vector<double> PhasesFigure::deaths_of_bins() const {
  std::vector<double> all(bins_.left.size(), 0);
  for (const std::vector<double>& cause : history_.deaths().values) {
    const std::vector<double> sums = bins_.sums(cause);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += sums[i];
  }
  return all;
}

void PhasesFigure::paint(const Canvas& canvas, const Rect& body) {
  const std::vector<double> divisions = bins_.sums(history_.divisions()),
                            specializations = bins_.sums(history_.specializations());
  const double actions = std::max(most_of(divisions), most_of(specializations));
  struct Part {
    Axis y;
    void (PhasesFigure::*paint)(const Chart&) const;
  };
  const std::array<Part, 4> parts{
      {{{0, round_end(most_of(history_.total())), "cells", true}, &PhasesFigure::paint_cells},
       {{0, round_end(most_of(deaths_of_bins())), "deaths", true}, &PhasesFigure::paint_deaths},
       {{0, round_end(actions), "events", true}, &PhasesFigure::paint_actions},
       {{0, 1, "share", false}, &PhasesFigure::paint_world}}};
  double left = 0;
  for (const Part& part : parts) left = std::max(left, Chart::left_margin(canvas, part.y));

  double y = body.y + numerals_height;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool last = i + 1 == parts.size();
    const double height = part_height() + (last ? Chart::bottom_margin - 3 : 0);
    const Chart chart(canvas, {body.x, y, body.width, height}, time_axis(history_), parts[i].y,
                      left, last);
    (this->*parts[i].paint)(chart);
    for (std::size_t p = 1; p < phases_.size(); ++p)
      chart.vertical(phases_[p].first - 0.5, rgb(0x404040), 2);
    chart.axes();
    if (i == 0) paint_numerals(canvas, chart);
    y += height;
  }
}

void PhasesFigure::paint_numerals(const Canvas& canvas, const Chart& chart) const {
  canvas.colour(black);
  // Those that are too short for their numeral stand in the caption.
  for (std::size_t p = 0; p < phases_.size(); ++p)
    if (chart.px(phases_[p].last + 1) - chart.px(phases_[p].first) >
        canvas.width_of(label_font, numerals[p]))
      canvas.label((chart.px(phases_[p].first) + chart.px(phases_[p].last)) / 2, chart.plot().y - 5,
                   label_font, numerals[p], Anchor::middle);
  for (std::size_t s = 1; s < history_.cells().names.size(); ++s)
    if (const auto first = first_above_0(history_.cells().values[s]))
      canvas.marker(chart.px(history_.step()[*first]), chart.plot().y - 2, Marker::triangle, 4.5,
                    colour_of_state(s));
}

void PhasesFigure::paint_cells(const Chart& chart) const {
  std::vector<double> below(history_.steps(), 0);
  for (std::size_t s = 0; s < history_.cells().values.size(); ++s) {
    std::vector<double> above = below;
    for (std::size_t i = 0; i < above.size(); ++i) above[i] += history_.cells().values[s][i];
    chart.band(history_.step(), below, above, colour_of_state(s));
    below = above;
  }
}

void PhasesFigure::paint_deaths(const Chart& chart) const {
  std::vector<double> below(bins_.left.size(), 0);
  for (std::size_t c = 0; c < history_.deaths().values.size(); ++c) {
    const std::vector<double> sums = bins_.sums(history_.deaths().values[c]);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      chart.bar(bins_.left[i], bins_.left[i] + 0.9 * bins_.width, below[i], below[i] + sums[i],
                colour_of_cause(c));
      below[i] += sums[i];
    }
  }
}

void PhasesFigure::paint_actions(const Chart& chart) const {
  std::vector<double> middles;
  for (const double left : bins_.left)
    middles.push_back(std::min(left + bins_.width / 2, history_.step().back()));
  chart.line(middles, bins_.sums(history_.divisions()), division_colour);
  chart.line(middles, bins_.sums(history_.specializations()), specialization_colour, 1.1, 4);
}

void PhasesFigure::paint_world(const Chart& chart) const {
  const auto relative = [](std::vector<double> series) {
    const double most = most_of(series);
    for (double& value : series) value = most > 0 ? value / most : 0;
    return series;
  };
  const auto& resources = history_.resources().values;
  for (std::size_t r = 0; r < resources.size(); ++r)
    chart.line(history_.step(), relative(resources[r]), frame_grey, 1.1, dashes[r % dashes.size()]);
  const auto& tables = history_.tables().values;
  for (std::size_t t = 0; t < tables.size(); ++t)
    chart.line(history_.step(), relative(tables[t]), colour_of_table(t));
}

}  // namespace

std::string population_figure(const LifeHistory& history, const Subject& subject,
                              const FigureSize& size) {
  const LifeHistory::Series& cells = history.cells();
  const std::vector<double> total = history.total(), availability = history.availability();
  const bool shaded = scarce(availability);
  const bool with_total = cells.names.size() > 1;

  Frame frame{.title = "Cell population through time.",
              .caption = caption_of(subject),
              .body = std::clamp(0.5 * size.width(), 110.0, 230.0)};
  for (std::size_t s = 0; s < cells.names.size(); ++s)
    frame.legend.push_back({.swatch = Swatch::line,
                            .colour = colour_of_state(s),
                            .words = cells.names[s],
                            .dash = dashes[s % dashes.size()]});
  if (with_total)
    frame.legend.push_back({.swatch = Swatch::line, .colour = black, .words = "all cells"});
  if (shaded)
    frame.legend.push_back({.swatch = Swatch::ramp,
                            .words = "resources, share of the most",
                            .ramp = availability_grey,
                            .low = "0",
                            .high = "1"});
  frame.paint = [&](const Canvas& canvas, const Rect& body) {
    const Axis y{0, round_end(most_of(total)), "cells", true};
    const Chart chart(canvas, body, time_axis(history), y, Chart::left_margin(canvas, y));
    if (shaded) shade_availability(chart, history, availability);
    if (with_total) chart.line(history.step(), total, black, 0.6);
    for (std::size_t s = 0; s < cells.names.size(); ++s)
      chart.line(history.step(), cells.values[s], colour_of_state(s), 1.3,
                 dashes[s % dashes.size()]);
    chart.axes();
  };
  return draw(frame, size);
}

std::string phases_figure(const LifeHistory& history, const Subject& subject,
                          const FigureSize& size) {
  return PhasesFigure(history, subject, size).render();
}

}  // namespace somas::report
