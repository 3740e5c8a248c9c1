#include "core/run/replay.hpp"

#include <algorithm>
#include <cstdio>

#include "core/experiment/experiment.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/manifest.hpp"
#include "core/run/run_directory.hpp"

namespace somas::run {
namespace {

using plugins::plural;

/// The experiment as it was resolved then, with today's plugins.
experiment::Experiment load_resolved(const ReplayOptions& options, ReplayReport& report) {
  const std::filesystem::path file = options.run / "resolved.yaml";
  const std::filesystem::path manifest_file = options.run / "manifest.json";
  const Json manifest = parse_json(read_file(manifest_file), manifest_file.string());

  experiment::LoadOptions load{options.overrides, options.plugin_directories};
  if (load.plugin_directories.empty())
    load.plugin_directories = plugin_path_of(manifest, manifest_file.string());
  experiment::Experiment experiment = experiment::load(file, load);
  report.warnings = changed_plugins(manifest, manifest_file.string(), experiment);
  return experiment;
}

// A what-if may have changed the ports; otherwise genes that do not fit are an error.
void make_fit(Champion& champion, const evolution::Heredity& heredity, ReplayReport& report,
              const std::string& origin) {
  try {
    heredity.check(champion.individual.genome);
    return;
  } catch (const std::exception& error) {
    if (!report.what_if) throw UsageError(origin + ": genome: " + error.what());
    report.warnings.push_back(std::string("the genome is made to fit the changed experiment: ") +
                              error.what());
  }
  Rng rng(champion.seed, 0, 0, stable_key("what-if"), champion.individual.id);
  heredity.conform(champion.individual.genome, rng);
}

std::string cells_at(const Recording& recording, std::size_t step) {
  std::string text;
  for (std::size_t state = 0; state < recording.states.size(); ++state)
    text += (text.empty() ? "" : ", ") + std::to_string(recording.census[state][step]) + " " +
            recording.states[state];
  return text;
}

std::string step_text(const Recording& recording, std::size_t step) {
  if (step >= recording.hashes.size()) return "ended before it";
  return "hash " + hex64(recording.hashes[step]) + ", cells " + cells_at(recording, step);
}

std::vector<std::string> differences(const Recording& recorded, const Recording& replayed) {
  std::vector<std::string> found;
  if (recorded.states != replayed.states) found.emplace_back("the states of cells are others");
  if (const auto step = first_difference(recorded, replayed))
    found.push_back("first differing step " + std::to_string(*step) + ": recorded " +
                    step_text(recorded, *step) + "; replayed " + step_text(replayed, *step));
  const Outcome &then = recorded.outcome, &now = replayed.outcome;
  if (then.survival != now.survival || then.censored != now.censored)
    found.push_back("survival: recorded " + std::to_string(then.survival) + ", replayed " +
                    std::to_string(now.survival));
  if (recorded.score != replayed.score) {
    char text[96];
    std::snprintf(text, sizeof text, "fitness: recorded %.17g, replayed %.17g", recorded.score,
                  replayed.score);
    found.emplace_back(text);
  }
  return found;
}

std::string life_text(const Recording& recording) {
  const Outcome& outcome = recording.outcome;
  return "survival " + std::to_string(outcome.survival) +
         (outcome.censored ? " (alive at the end)" : "") + ", peak " +
         plural(outcome.peak_cells, "cell") + ", " + plural(outcome.divisions, "division") + ", " +
         plural(outcome.specializations, "specialization");
}

// A line at about ten moments of a life.
std::string census_text(const Recording& recording) {
  std::string text;
  const std::size_t steps = recording.hashes.size();
  const std::size_t stride = std::max<std::size_t>(1, (steps + 9) / 10);
  for (std::size_t step = 0; step < steps; step += stride)
    text += "  step " + std::to_string(step) + ": " + cells_at(recording, step) + "\n";
  if (steps > 0 && (steps - 1) % stride != 0)
    text += "  step " + std::to_string(steps - 1) + ": " + cells_at(recording, steps - 1) + "\n";
  return text;
}

}  // namespace

ReplayReport replay(const ReplayOptions& options) {
  ReplayReport report;
  report.what_if = !options.overrides.empty();
  const std::uint64_t generation =
      options.generation ? *options.generation : last_generation(options.run);
  const std::filesystem::path file = champion_path(options.run, generation);
  if (!std::filesystem::exists(file))
    throw UsageError("generation " + std::to_string(generation) +
                     " has no champion: " + file.string() + " does not exist; the last one is " +
                     std::to_string(last_generation(options.run)));

  const experiment::Experiment experiment = load_resolved(options, report);
  const evolution::Heredity heredity(*experiment.ecosystem);
  report.recorded = parse_champion(read_file(file), file.string(), heredity, owners_of(experiment));
  if (!report.recorded.genes_match_bytes) report.warnings.push_back(edited_warning(file.string()));
  make_fit(report.recorded, heredity, report, file.string());

  report.replayed = *record(*experiment.ecosystem, report.recorded.individual.genome,
                            report.recorded.seed, {}, options.observer);
  if (!report.what_if) {
    report.differences = differences(report.recorded.recording, report.replayed);
    if (!report.recorded.genes_match_bytes && report.differences.empty())
      report.differences.emplace_back("the genome was edited, though its life is the same");
  }
  return report;
}

std::string to_text(const ReplayReport& report) {
  const Champion& champion = report.recorded;
  const std::string steps = std::to_string(report.replayed.hashes.size());
  std::string text = champion.experiment + ": champion of generation " +
                     std::to_string(champion.generation) + ", individual " +
                     std::to_string(champion.individual.id) + " (" +
                     std::string(evolution::name_of(champion.individual.origin)) + "), seed " +
                     hex64(champion.seed) + "\n";
  if (report.what_if) {
    text += "recorded: " + life_text(champion.recording) + "\n";
    text += "what if:  " + life_text(report.replayed) + "\n";
  } else {
    text += life_text(report.replayed) + "\n";
  }
  text += census_text(report.replayed);
  if (report.what_if) return text;

  if (report.matches())
    text += "reproduced: survival and all " + steps + " step hashes equal\n";
  else
    text += "NOT reproduced:\n";
  for (const std::string& difference : report.differences) text += "  " + difference + "\n";
  return text;
}

}  // namespace somas::run
