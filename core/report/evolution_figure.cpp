#include "core/report/evolution_figure.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/plugins/suggest.hpp"
#include "core/report/chart.hpp"
#include "core/report/run_tables.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using Swatch = LegendEntry::Swatch;
using Series = std::vector<double>;

constexpr Colour best_colour = rgb(0x0072B2), median_colour = rgb(0xD55E00),
                 quartile_colour = rgb(0xE69F00);
constexpr double band_alpha = 0.25;

/// Least, median and greatest over the replicates, by generation.
struct Spread {
  Series low, middle, high;
};

Spread spread_of(const std::vector<Generations>& runs, Series Generations::*series,
                 std::size_t generations) {
  Spread spread;
  for (std::size_t g = 0; g < generations; ++g) {
    Series values;
    for (const Generations& one : runs) values.push_back((one.*series)[g]);
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    spread.low.push_back(values.front());
    spread.middle.push_back((values[(n - 1) / 2] + values[n / 2]) / 2);
    spread.high.push_back(values.back());
  }
  return spread;
}

std::string names_of_runs(const std::vector<fs::path>& runs) {
  std::vector<std::string> names;
  for (const fs::path& run : runs) names.push_back(title_of_run(run));
  if (names.size() <= 8) return plugins::join(names);
  return names.front() + " to " + names.back();
}

void check_same_objective(const std::vector<fs::path>& runs) {
  for (const fs::path& run : runs)
    if (objective_of(run) != objective_of(runs.front()))
      throw run::UsageError("fitness is '" + objective_of(runs.front()) + "' in " +
                            runs.front().string() + ", but '" + objective_of(run) + "' in " +
                            run.string() + ": no replicates");
}

std::size_t common_generations(const std::vector<Generations>& runs, const std::string& whose,
                               std::vector<std::string>& warnings) {
  const auto shorter = [](const Generations& a, const Generations& b) {
    return a.best.size() < b.best.size();
  };
  const auto [least, most] = std::minmax_element(runs.begin(), runs.end(), shorter);
  if (least->best.size() < most->best.size())
    warnings.push_back(whose + " have from " + std::to_string(least->best.size()) + " to " +
                       plugins::plural(most->best.size(), "generation") +
                       "; the figure shows those that all have");
  return least->best.size();
}

std::vector<Generations> read_all(const std::vector<fs::path>& paths, std::uint32_t population) {
  std::vector<Generations> runs;
  for (const fs::path& path : paths) runs.push_back(read_generations(path, population));
  return runs;
}

std::string unit_of(const std::string& objective) {
  return objective == "survival" ? " (steps)" : "";
}

Series numbers_to(std::size_t count) {
  Series numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0.0);
  return numbers;
}

Colour faint(Colour colour) {
  colour.alpha = band_alpha;
  return colour;
}

std::vector<LegendEntry> legend_of(bool several) {
  const auto pale = [](Colour colour) { return between(white, colour, band_alpha); };
  if (!several)
    return {{.swatch = Swatch::line, .colour = best_colour, .words = "best"},
            {.swatch = Swatch::line, .colour = median_colour, .words = "median", .dash = 4},
            {.swatch = Swatch::box, .colour = pale(median_colour), .words = "quartiles"}};
  return {
      {.swatch = Swatch::line, .colour = best_colour, .words = "best"},
      {.swatch = Swatch::line, .colour = median_colour, .words = "median", .dash = 4},
      {.swatch = Swatch::line, .colour = quartile_colour, .words = "quartiles", .dash = 1.5},
      {.swatch = Swatch::box, .colour = pale(best_colour), .words = "range of replicates' best"},
      {.swatch = Swatch::box,
       .colour = pale(median_colour),
       .words = "range of replicates' median"}};
}

// ---- one condition ------------------------------------------------------------------------------

std::string figure_of_runs(const std::vector<fs::path>& paths, std::uint32_t population,
                           const FigureSize& size, std::vector<std::string>& warnings) {
  check_same_objective(paths);
  const std::vector<Generations> runs = read_all(paths, population);
  const std::size_t count = common_generations(runs, "the runs", warnings);
  const bool several = runs.size() > 1;

  const Spread best = spread_of(runs, &Generations::best, count),
               median = spread_of(runs, &Generations::median, count),
               upper = spread_of(runs, &Generations::upper_quartile, count),
               lower = spread_of(runs, &Generations::lower_quartile, count);
  const Series generation = numbers_to(count);

  const std::string objective = objective_of(paths.front());
  std::string caption = several
                            ? "Medians and ranges of " + plugins::plural(runs.size(), "replicate") +
                                  ": " + names_of_runs(paths)
                            : "Run " + names_of_runs(paths);
  if (population > 1) caption += ", population " + std::to_string(population);
  Frame frame{.title = "Fitness over the generations.",
              .caption = caption + "; " + plugins::plural(count, "generation") + ".",
              .legend = legend_of(several),
              .body = std::clamp(0.5 * size.width(), 110.0, 230.0)};
  frame.paint = [&](const Canvas& canvas, const Rect& body) {
    const double most = *std::max_element(best.high.begin(), best.high.end());
    const double least = *std::min_element(lower.low.begin(), lower.low.end());
    const Axis x{0, generation.back(), "generation", true};
    const Axis y{least < 0 ? -round_end(-least) : 0, most > 0 ? round_end(most) : 0,
                 objective + unit_of(objective), false};
    const Chart chart(canvas, body, x, y, Chart::left_margin(canvas, y));
    if (several) {
      chart.band(generation, best.low, best.high, faint(best_colour));
      chart.band(generation, median.low, median.high, faint(median_colour));
      chart.line(generation, upper.middle, quartile_colour, 0.8, 1.5);
      chart.line(generation, lower.middle, quartile_colour, 0.8, 1.5);
    } else {
      chart.band(generation, lower.middle, upper.middle, faint(median_colour));
    }
    chart.line(generation, median.middle, median_colour, 1.2, 4);
    chart.line(generation, best.middle, best_colour, 1.3);
    // A single generation is no line.
    if (count == 1) {
      chart.marker(0, best.middle[0], Marker::disc, 3, best_colour);
      chart.marker(0, median.middle[0], Marker::disc, 3, median_colour);
    }
    chart.axes();
  };
  return draw(frame, size);
}

// ---- several conditions -------------------------------------------------------------------------

/// The best of a condition's replicates, and how it is drawn.
struct ConditionCurve {
  Series generation;
  Spread best;
  Colour colour;
  double dash = 0;
};

void draw_curves(const Canvas& canvas, const Rect& body, const std::vector<ConditionCurve>& curves,
                 const std::string& objective) {
  double most = 0, least = 0, last = 0;
  for (const ConditionCurve& curve : curves) {
    most = std::max(most, *std::max_element(curve.best.high.begin(), curve.best.high.end()));
    least = std::min(least, *std::min_element(curve.best.low.begin(), curve.best.low.end()));
    last = std::max(last, curve.generation.back());
  }
  const Axis x{0, last, "generation", true};
  const Axis y{least < 0 ? -round_end(-least) : 0, most > 0 ? round_end(most) : 0,
               "best " + objective + unit_of(objective), false};
  const Chart chart(canvas, body, x, y, Chart::left_margin(canvas, y));
  for (const ConditionCurve& curve : curves)
    chart.band(curve.generation, curve.best.low, curve.best.high, faint(curve.colour));
  for (const ConditionCurve& curve : curves) {
    chart.line(curve.generation, curve.best.middle, curve.colour, 1.3, curve.dash);
    if (curve.generation.size() == 1)
      chart.marker(0, curve.best.middle[0], Marker::disc, 3, curve.colour);
  }
  chart.axes();
}

std::string figure_of_conditions(const std::vector<Condition>& conditions,
                                 const std::string& campaign, std::uint32_t population,
                                 const FigureSize& size, std::vector<std::string>& warnings) {
  std::vector<fs::path> all;
  for (const Condition& condition : conditions)
    all.insert(all.end(), condition.runs.begin(), condition.runs.end());
  check_same_objective(all);

  Frame frame{.title = "Best fitness over the generations.",
              .caption = "Campaign " + campaign +
                         ", a line a condition: median over its replicates; bands: their range",
              .body = std::clamp(0.5 * size.width(), 110.0, 230.0)};
  if (population > 1) frame.caption += "; population " + std::to_string(population);
  frame.caption += ".";
  std::vector<ConditionCurve> curves;
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const Condition& condition = conditions[i];
    const std::vector<Generations> runs = read_all(condition.runs, population);
    const std::size_t count =
        common_generations(runs, "the runs of condition " + condition.name, warnings);
    curves.push_back({.generation = numbers_to(count),
                      .best = spread_of(runs, &Generations::best, count),
                      .colour = colour_of_state(i),
                      .dash = dashes[i % dashes.size()]});
    frame.legend.push_back(
        {.swatch = Swatch::line,
         .colour = curves.back().colour,
         .words = condition.name + " (" + plugins::plural(runs.size(), "replicate") + ")",
         .dash = curves.back().dash});
  }
  frame.paint = [&](const Canvas& canvas, const Rect& body) {
    draw_curves(canvas, body, curves, objective_of(all.front()));
  };
  return draw(frame, size);
}

}  // namespace

std::string evolution_figure(const std::vector<fs::path>& given, std::uint32_t population,
                             const FigureSize& size, std::vector<std::string>& warnings) {
  if (given.size() > 1 || !is_campaign(given.front()))
    return figure_of_runs(runs_in(given), population, size, warnings);
  const std::vector<Condition> conditions = conditions_of(given.front(), warnings);
  if (conditions.size() == 1)
    return figure_of_runs(conditions.front().runs, population, size, warnings);
  return figure_of_conditions(conditions, name_of_directory(given.front()), population, size,
                              warnings);
}

}  // namespace somas::report
