#include "core/report/lineage_figure.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/report/chart.hpp"
#include "core/report/run_tables.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using Swatch = LegendEntry::Swatch;

/// How an operator is marked: by colour and shape.
struct Style {
  const char* origin;
  Marker shape;
  Colour colour;
};
constexpr std::array<Style, 7> styles{{{"random", Marker::ring, rgb(0x000000)},
                                       {"seed", Marker::diamond, rgb(0x000000)},
                                       {"elite", Marker::disc, rgb(0x8A8A8A)},
                                       {"copy", Marker::ring, rgb(0x56B4E9)},
                                       {"mutation", Marker::square, rgb(0x0072B2)},
                                       {"crossover", Marker::triangle, rgb(0xE69F00)},
                                       {"crossover+mutation", Marker::diamond, rgb(0xD55E00)}}};

const Style& style_of(const std::string& origin) {
  for (const Style& style : styles)
    if (origin == style.origin) return style;
  return styles.front();
}

struct Drawn {
  Generations generations;
  Lineage lineage;
  std::uint64_t last = 0;
};

std::vector<LegendEntry> legend_of(const Lineage& lineage) {
  std::vector<LegendEntry> entries;
  for (const Style& style : styles)
    if (std::any_of(lineage.line.begin(), lineage.line.end(),
                    [&](const Ancestor& one) { return one.origin == style.origin; }))
      entries.push_back({.swatch = Swatch::marker,
                         .colour = style.colour,
                         .words = style.origin,
                         .marker = style.shape});
  entries.push_back(
      {.swatch = Swatch::line, .colour = rgb(0xB0B0B0), .words = "second parent", .dash = 1.5});
  entries.push_back({.swatch = Swatch::line,
                     .colour = rgb(0x009E73),
                     .words = "best of the generation",
                     .dash = 4});
  return entries;
}

void paint_line(const Chart& chart, const Drawn& drawn, double size) {
  const auto last = static_cast<std::ptrdiff_t>(drawn.last + 1);
  std::vector<double> generation(drawn.last + 1);
  std::iota(generation.begin(), generation.end(), 0.0);
  const std::vector<double> best(drawn.generations.best.begin(),
                                 drawn.generations.best.begin() + last);
  chart.line(generation, best, rgb(0x009E73), 0.9, 4);

  const std::vector<Ancestor>& line = drawn.lineage.line;
  std::vector<double> x, y;
  for (std::size_t i = 0; i < line.size(); ++i) {
    x.push_back(static_cast<double>(line[i].generation));
    y.push_back(line[i].fitness);
    const std::optional<Ancestor>& second = drawn.lineage.second_parents[i];
    if (!second) continue;
    const std::array<double, 2> from_to{x.back() - 1, x.back()}, fitness{second->fitness, y.back()};
    chart.line(from_to, fitness, rgb(0xB0B0B0), 0.8, 1.5);
    chart.marker(from_to[0], fitness[0], Marker::ring, 0.8 * size, rgb(0x8A8A8A));
  }
  chart.line(x, y, black, 0.9);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Style& style = style_of(line[i].origin);
    chart.marker(x[i], y[i], style.shape, size, style.colour);
  }
}

double most_fitness(const Drawn& drawn) {
  double most = 0;
  for (std::uint64_t g = 0; g <= drawn.last; ++g) most = std::max(most, drawn.generations.best[g]);
  return most;
}

double least_fitness(const Drawn& drawn) {
  double least = 0;
  for (const Ancestor& one : drawn.lineage.line) least = std::min(least, one.fitness);
  return least;
}

void paint(const Canvas& canvas, const Rect& body, const Drawn& drawn,
           const std::string& objective) {
  const double most = most_fitness(drawn), least = least_fitness(drawn);
  const Axis x{0, static_cast<double>(drawn.last), "generation", true};
  const Axis fitness{least < 0 ? -round_end(-least) : 0, most > 0 ? round_end(most) : 0, objective,
                     false};
  const std::vector<double>& counts = drawn.lineage.ancestors;
  const Axis ancestors{0, round_end(*std::max_element(counts.begin(), counts.end())), "ancestors",
                       true};
  const double left =
      std::max(Chart::left_margin(canvas, fitness), Chart::left_margin(canvas, ancestors));
  const double lower = std::clamp(0.35 * body.height, 58.0, 90.0);
  const Chart above(canvas, {body.x, body.y, body.width, body.height - lower}, x, fitness, left,
                    false);
  paint_line(above, drawn, drawn.last > 80 ? 3 : 4.2);
  above.axes();

  const Chart below(canvas, {body.x, body.bottom() - lower, body.width, lower}, x, ancestors, left);
  std::vector<double> generation(counts.size());
  std::iota(generation.begin(), generation.end(), 0.0);
  below.line(generation, counts, black);
  below.axes();
}

}  // namespace

std::string lineage_figure(const fs::path& run, std::optional<std::uint64_t> generation,
                           std::uint32_t population, const FigureSize& size) {
  Drawn drawn{.generations = read_generations(run, population), .lineage = {}};
  const std::uint64_t count = drawn.generations.best.size();
  drawn.last = generation.value_or(count - 1);
  if (drawn.last >= count)
    throw run::UsageError("generation " + std::to_string(drawn.last) +
                          " is not on record; the last one is " + std::to_string(count - 1));
  const std::uint64_t champion = drawn.generations.champion[drawn.last];
  drawn.lineage = read_lineage(run, drawn.last, champion, population);

  const std::string objective = objective_of(run);
  const Ancestor& oldest = drawn.lineage.line.front();
  std::string caption =
      "Line of first parents, the operator that made each of them, and (below) how many "
      "individuals of each generation are ancestors by either parent. Run " +
      title_of_run(run) + ", generation " + std::to_string(drawn.last);
  if (population > 1) caption += ", population " + std::to_string(population);
  caption += ": champion " + std::to_string(champion) + ", from individual " +
             std::to_string(oldest.id) + " of generation " + std::to_string(oldest.generation) +
             ".";
  Frame frame{.title = "Ancestry of a champion.",
              .caption = caption,
              .legend = legend_of(drawn.lineage),
              .body = std::clamp(0.6 * size.width(), 150.0, 280.0)};
  frame.paint = [&](const Canvas& canvas, const Rect& body) {
    paint(canvas, body, drawn, objective + (objective == "survival" ? " (steps)" : ""));
  };
  return draw(frame, size);
}

}  // namespace somas::report
