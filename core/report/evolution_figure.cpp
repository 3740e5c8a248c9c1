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

std::size_t common_generations(const std::vector<Generations>& runs,
                               std::vector<std::string>& warnings) {
  const auto shorter = [](const Generations& a, const Generations& b) {
    return a.best.size() < b.best.size();
  };
  const auto [least, most] = std::minmax_element(runs.begin(), runs.end(), shorter);
  if (least->best.size() < most->best.size())
    warnings.push_back("the runs have from " + std::to_string(least->best.size()) + " to " +
                       plugins::plural(most->best.size(), "generation") +
                       "; the figure shows those that all have");
  return least->best.size();
}

std::vector<LegendEntry> legend_of(bool several) {
  const auto faint = [](Colour colour) { return between(white, colour, band_alpha); };
  if (!several)
    return {{.swatch = Swatch::line, .colour = best_colour, .words = "best"},
            {.swatch = Swatch::line, .colour = median_colour, .words = "median", .dash = 4},
            {.swatch = Swatch::box, .colour = faint(median_colour), .words = "quartiles"}};
  return {
      {.swatch = Swatch::line, .colour = best_colour, .words = "best"},
      {.swatch = Swatch::line, .colour = median_colour, .words = "median", .dash = 4},
      {.swatch = Swatch::line, .colour = quartile_colour, .words = "quartiles", .dash = 1.5},
      {.swatch = Swatch::box, .colour = faint(best_colour), .words = "range of replicates' best"},
      {.swatch = Swatch::box,
       .colour = faint(median_colour),
       .words = "range of replicates' median"}};
}

}  // namespace

std::string evolution_figure(const std::vector<fs::path>& given, std::uint32_t population,
                             const FigureSize& size, std::vector<std::string>& warnings) {
  const std::vector<fs::path> paths = runs_in(given);
  check_same_objective(paths);
  std::vector<Generations> runs;
  for (const fs::path& path : paths) runs.push_back(read_generations(path, population));
  const std::size_t count = common_generations(runs, warnings);
  const bool several = runs.size() > 1;

  const Spread best = spread_of(runs, &Generations::best, count),
               median = spread_of(runs, &Generations::median, count),
               upper = spread_of(runs, &Generations::upper_quartile, count),
               lower = spread_of(runs, &Generations::lower_quartile, count);
  Series generation(count);
  std::iota(generation.begin(), generation.end(), 0.0);

  const std::string objective = objective_of(paths.front());
  const std::string unit = objective == "survival" ? " (steps)" : "";
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
                 objective + unit, false};
    const Chart chart(canvas, body, x, y, Chart::left_margin(canvas, y));
    const auto faint = [](Colour colour) {
      colour.alpha = band_alpha;
      return colour;
    };
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

}  // namespace somas::report
