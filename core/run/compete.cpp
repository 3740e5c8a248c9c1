#include "core/run/compete.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "core/evaluation/thread_evaluator.hpp"
#include "core/evolution/heredity.hpp"
#include "core/evolution/matching.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/champion.hpp"
#include "core/run/csv.hpp"
#include "core/run/files.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

constexpr std::uint64_t largest_genome = std::uint64_t{64} << 20;  // bytes

std::string formatted(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::vector<model::Genome> read_all(const experiment::Experiment& experiment,
                                    const evolution::Heredity& heredity,
                                    const CompeteOptions& options, CompeteReport& report) {
  std::vector<model::Genome> genomes;
  for (const std::filesystem::path& file : options.genomes) {
    SavedGenome saved = parse_genome(read_regular_file(file, largest_genome), file.string(),
                                     heredity, owners_of(experiment));
    for (std::string& warning : saved.warnings) report.warnings.push_back(std::move(warning));
    try {
      heredity.check(saved.genome);
    } catch (const std::exception& error) {
      throw UsageError(file.string() +
                       ": the genome does not fit this experiment: " + error.what());
    }
    genomes.push_back(std::move(saved.genome));
    report.competitors.push_back(file.string());
  }
  if (options.against_random) report.competitors.emplace_back("random");
  if (report.competitors.size() < 2)
    throw UsageError(
        "a competition needs two competitors: give --genome twice, or --against random");
  return genomes;
}

/// Competitors in the order of their genomes' bytes; the random one, which has none yet, last.
std::vector<std::size_t> by_genome(const std::vector<model::Genome>& genomes, std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(genomes.size()),
                   [&](std::size_t a, std::size_t b) {
                     const model::Genome &first = genomes[a], &second = genomes[b];
                     return first.controller != second.controller
                                ? first.controller < second.controller
                                : first.tree < second.tree;
                   });
  return order;
}

std::string share_of(const std::string& what, double sum, std::size_t worlds) {
  return what + formatted(" %.4f", sum / static_cast<double>(worlds));
}

}  // namespace

CompeteReport compete(const experiment::Experiment& experiment, const CompeteOptions& options) {
  const evolution::Heredity heredity(*experiment.ecosystem);
  CompeteReport report;
  report.experiment = experiment.name;
  report.objective = experiment.ecosystem->fitness().objective();
  const std::vector<model::Genome> genomes = read_all(experiment, heredity, options, report);
  const std::size_t count = report.competitors.size();
  const std::vector<std::size_t> order = by_genome(genomes, count);

  evolution::Roster roster = experiment.evolution.roster;
  roster.size = static_cast<std::uint32_t>(count);
  std::vector<model::Genome> random(options.seeds);
  std::vector<evaluation::Task> tasks(options.seeds);
  for (std::uint32_t w = 0; w < options.seeds; ++w) {
    tasks[w].seed = Rng(experiment.seed, 0, w, stable_key("compete.seed"), 0).bits();
    Rng genes(tasks[w].seed, 0, 0, stable_key("compete.random"), 0);
    if (options.against_random) random[w] = heredity.random(genes);
    const std::vector<evolution::Seat> seats = evolution::seats_of(roster, tasks[w].seed, 0, 0);
    tasks[w].roster.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      const evolution::Seat& seat = seats[(k + w) % count];
      const std::size_t who = order[k];
      tasks[w].roster[who] = {who < genomes.size() ? &genomes[who] : &random[w], seat.key, seat.x,
                              seat.y};
    }
  }

  evaluation::ThreadEvaluator evaluator(*experiment.ecosystem, options.threads);
  std::vector<evaluation::Result> results = *evaluator.evaluate(tasks, {}, {});
  for (std::uint32_t w = 0; w < options.seeds; ++w) {
    if (const auto& failure = results[w].failure)
      throw PluginError("world " + std::to_string(w) + ": " + failure->plugin + ": " +
                        failure->cause);
    report.bouts.push_back({tasks[w].seed, std::move(results[w].rows)});
  }
  return report;
}

Wins wins_of(const CompeteReport& report) {
  Wins wins{std::vector<std::uint64_t>(report.competitors.size()), 0};
  for (const Bout& bout : report.bouts) {
    const auto less = [](const auto& a, const auto& b) { return a.score < b.score; };
    const auto best = std::max_element(bout.rows.begin(), bout.rows.end(), less);
    const auto as_good = std::count_if(bout.rows.begin(), bout.rows.end(),
                                       [&](const auto& row) { return row.score == best->score; });
    if (as_good > 1)
      ++wins.ties;
    else
      ++wins.of[static_cast<std::size_t>(best - bout.rows.begin())];
  }
  return wins;
}

double sign_test(std::uint64_t first, std::uint64_t second) {
  const std::uint64_t n = first + second, fewer = std::min(first, second);
  // Sum of C(n, k) / 2^n over k <= fewer, each term from the one before.
  double term = 1, sum = 0;
  for (std::uint64_t k = 0; k < n; ++k) term *= 0.5;
  for (std::uint64_t k = 0; k <= fewer; ++k) {
    sum += term;
    term *= static_cast<double>(n - k) / static_cast<double>(k + 1);
  }
  return std::min(1.0, 2 * sum);
}

std::string to_text(const CompeteReport& report) {
  const std::size_t count = report.competitors.size(), worlds = report.bouts.size();
  std::string text = report.experiment + ": " + plugins::plural(count, "competitor") + " in " +
                     plugins::plural(worlds, "world") + "; survival, share of biomass\n";
  for (std::size_t k = 0; k < count; ++k)
    text += "  " + std::to_string(k + 1) + ": " + report.competitors[k] + "\n";
  std::vector<double> survival(count), share(count), score(count);
  for (const Bout& bout : report.bouts) {
    text += "  seed " + hex64(bout.seed) + ":";
    for (std::size_t k = 0; k < count; ++k) {
      const Outcome& outcome = bout.rows[k].outcome;
      text += k == 0 ? "  " : " | ";
      text += std::to_string(outcome.survival) + formatted(" %.4f", outcome.biomass_share);
      survival[k] += static_cast<double>(outcome.survival);
      share[k] += outcome.biomass_share;
      score[k] += bout.rows[k].score;
    }
    text += "\n";
  }
  const Wins wins = wins_of(report);
  for (std::size_t k = 0; k < count; ++k)
    text +=
        std::to_string(k + 1) + ": " + std::to_string(wins.of[k]) + " of " +
        std::to_string(worlds) + " won by " + report.objective +
        "; means: " + formatted("survival %.1f, ", survival[k] / static_cast<double>(worlds)) +
        share_of("share", share[k], worlds) +
        formatted(", %s %.6g\n", report.objective.c_str(), score[k] / static_cast<double>(worlds));
  if (wins.ties > 0) text += "ties: " + std::to_string(wins.ties) + "\n";
  for (std::size_t k = 1; k < count; ++k) {
    std::uint64_t more = 0, less = 0;
    for (const Bout& bout : report.bouts) {
      more += bout.rows[0].score > bout.rows[k].score ? 1 : 0;
      less += bout.rows[0].score < bout.rows[k].score ? 1 : 0;
    }
    text += "1 above " + std::to_string(k + 1) + " in " + std::to_string(more) + ", below in " +
            std::to_string(less) + formatted(": sign test p = %.3g\n", sign_test(more, less));
  }
  return text;
}

std::string to_csv(const CompeteReport& report) {
  std::string text = "seed,competitor,genome,survival,censored,biomass_share,score,peak_cells\n";
  CsvLine line;
  for (const Bout& bout : report.bouts)
    for (std::size_t k = 0; k < report.competitors.size(); ++k) {
      const evaluation::Row& row = bout.rows[k];
      line.add(hex64(bout.seed)).add(k + 1).add(report.competitors[k]);
      line.add(row.outcome.survival)
          .add(row.outcome.censored ? 1 : 0)
          .add(row.outcome.biomass_share)
          .add(row.score)
          .add(row.outcome.peak_cells);
      text += line.take();
    }
  return text;
}

}  // namespace somas::run
