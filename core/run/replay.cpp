#include "core/run/replay.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/experiment/experiment.hpp"
#include "core/model/snapshot.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/manifest.hpp"
#include "core/run/midlife.hpp"
#include "core/run/recordings.hpp"
#include "core/run/run_directory.hpp"

namespace somas::run {
namespace {

using plugins::plural;

/// The experiment as it was resolved then, with today's plugins.
experiment::Experiment load_resolved(const ReplayOptions& options,
                                     const std::vector<std::string>& overrides,
                                     ReplayReport& report) {
  const std::filesystem::path file = options.run / "resolved.yaml";
  const std::filesystem::path manifest_file = options.run / "manifest.json";
  const Json manifest = parse_json(read_file(manifest_file), manifest_file.string());

  experiment::LoadOptions load{overrides, options.plugin_directories};
  if (load.plugin_directories.empty())
    load.plugin_directories = plugin_path_of(manifest, manifest_file.string());
  experiment::Experiment experiment = experiment::load(file, load);
  report.warnings = changed_plugins(manifest, manifest_file.string(), experiment);
  return experiment;
}

// A what-if may have changed the ports; otherwise genes that do not fit are an error.
void make_fit(Champion& champion, const evolution::Heredity& heredity, ReplayReport& report,
              const std::string& origin) {
  const auto fit = [&](model::Genome& genome, std::uint64_t key, const std::string& place) {
    try {
      heredity.check(genome);
      return;
    } catch (const std::exception& error) {
      if (!report.what_if) throw UsageError(origin + ": " + place + ": " + error.what());
      report.warnings.push_back("the " + place +
                                " is made to fit the changed experiment: " + error.what());
    }
    Rng rng(champion.seed, key, 0, stable_key("what-if"), champion.individual.id);
    heredity.conform(genome, rng);
  };
  fit(champion.individual.genome, 0, "genome");
  for (std::size_t s = 0; s < champion.roster.size(); ++s)
    if (s != champion.own_seat)
      fit(champion.roster[s].genome, champion.roster[s].key,
          "genome of roster[" + std::to_string(s) + "]");
}

std::string cells_at(const LifeRecord& life, std::size_t step) {
  std::string text;
  for (std::size_t state = 0; state < life.states.size(); ++state)
    text += (text.empty() ? "" : ", ") + std::to_string(life.census[state][step]) + " " +
            life.states[state];
  return text;
}

std::string step_text(const LifeRecord& life, std::size_t step) {
  step -= life.first_step;
  if (step >= life.hashes.size()) return "ended before it";
  return "hash " + hex64(life.hashes[step]) + ", cells " + cells_at(life, step);
}

std::string number_text(bool value) { return value ? "true" : "false"; }
std::string number_text(std::uint64_t value) { return std::to_string(value); }
std::string number_text(std::uint32_t value) { return std::to_string(value); }
std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// A file that was renamed, or pasted together, is no record of its generation.
void check_identity(const Champion& champion, std::uint64_t generation, std::uint32_t population,
                    const std::filesystem::path& run, const std::string& origin) {
  if (champion.generation != generation)
    throw UsageError(origin + ".generation: " + std::to_string(champion.generation) +
                     " in the file, " + std::to_string(generation) + " in its name");
  if (std::max(1u, champion.population) != population)
    throw UsageError(origin + ".population: " + std::to_string(champion.population) +
                     " in the file, " + std::to_string(population) + " in its name");
  const std::optional<std::uint64_t> id =
      champion_id(run, generation, std::max(1u, champion.population));
  if (id && *id != champion.individual.id)
    throw UsageError(origin + ".id: " + std::to_string(champion.individual.id) +
                     " in the file, but generations.csv says that individual " +
                     std::to_string(*id) + " is the champion");
}

std::vector<std::string> differences(const Champion& champion, const LifeRecord& replayed) {
  const LifeRecord recorded = rest_of(champion.life, replayed.first_step);
  std::vector<std::string> found;
  if (recorded.states != replayed.states) found.emplace_back("the states of cells are others");
  if (const auto step = first_difference(recorded, replayed))
    found.push_back("first differing step " + std::to_string(*step) + ": recorded " +
                    step_text(recorded, *step) + "; replayed " + step_text(replayed, *step));
  const Outcome &then = recorded.outcome, &now = replayed.outcome;
  const auto compare = [&](const char* field, auto was, auto is) {
    if (was == is) return;
    found.push_back(std::string(field) + ": recorded " + number_text(was) + ", replayed " +
                    number_text(is));
  };
  compare("survival", then.survival, now.survival);
  compare("censored", then.censored, now.censored);
  compare("score", recorded.score, replayed.score);
  // The first of the trials is the one that is replayed.
  if (!champion.individual.trials.empty())
    compare("trials[0]", champion.individual.trials.front(), replayed.score);
  compare("divisions", then.divisions, now.divisions);
  compare("specializations", then.specializations, now.specializations);
  compare("refused_divisions", then.refused_divisions, now.refused_divisions);
  compare("final_cells", then.final_cells, now.final_cells);
  compare("peak_cells", then.peak_cells, now.peak_cells);
  compare("cell_steps", then.cell_steps, now.cell_steps);
  // The share of an organism alone is not on record.
  if (!champion.roster.empty()) compare("biomass_share", then.biomass_share, now.biomass_share);
  return found;
}

// Who else was there, and what was left for the champion.
std::string company_text(const Champion& champion, const LifeRecord& replayed) {
  if (champion.roster.empty()) return "";
  std::string text;
  for (std::size_t s = 0; s < champion.roster.size(); ++s) {
    const RosterSeat& seat = champion.roster[s];
    if (s == champion.own_seat) continue;
    text += text.empty() ? "with " : ", ";
    text += seat.id ? "individual " + std::to_string(*seat.id) : "random genes";
    if (seat.population != 0) text += " of population " + std::to_string(seat.population);
  }
  char share[32];
  std::snprintf(share, sizeof share, "%.4f", replayed.outcome.biomass_share);
  return text + "; share of biomass " + share + "\n";
}

std::string life_text(const LifeRecord& life) {
  const Outcome& outcome = life.outcome;
  return "survival " + std::to_string(outcome.survival) +
         (outcome.censored ? " (alive at the end)" : "") + ", peak " +
         plural(outcome.peak_cells, "cell") + ", " + plural(outcome.divisions, "division") + ", " +
         plural(outcome.specializations, "specialization");
}

// A line at about ten moments of a life.
std::string census_text(const LifeRecord& life) {
  std::string text;
  const std::size_t steps = life.hashes.size();
  const std::size_t stride = std::max<std::size_t>(1, (steps + 9) / 10);
  for (std::size_t step = 0; step < steps; step += stride)
    text += "  step " + std::to_string(life.first_step + step) + ": " + cells_at(life, step) + "\n";
  if (steps > 0 && (steps - 1) % stride != 0)
    text += "  step " + std::to_string(life.first_step + steps - 1) + ": " +
            cells_at(life, steps - 1) + "\n";
  return text;
}

// What changes in mid-life must leave what there is its meaning.
void check_same_kind(const experiment::Experiment& then, const experiment::Experiment& now,
                     const Champion& champion) {
  const auto same = [](const char* kind, const std::string& was, const std::string& is) {
    if (was != is)
      throw UsageError("--set: in mid-life the " + std::string(kind) + " cannot change from '" +
                       was + "' to '" + is + "'");
  };
  same("controller", then.controller.id, now.controller.id);
  same("specialization", then.specialization.id, now.specialization.id);
  try {
    const evolution::Heredity heredity(*now.ecosystem);
    for (const evaluation::Organism& organism : task_of(champion).roster)
      heredity.check(*organism.genome);
  } catch (const std::exception& error) {
    throw UsageError(
        std::string("--set: cannot be changed in mid-life, the genome would not fit: ") +
        error.what());
  }
}

/// A recorder for each of the recipients.
class Recorders {
 public:
  Recorders(const ReplayOptions& options, const Champion& champion,
            const experiment::Experiment& experiment) {
    if (options.recipients.empty()) return;
    const evolution::Heredity heredity(*experiment.ecosystem);
    std::vector<recording::LifeWitness*> all;
    for (const Recipient& recipient : options.recipients) {
      experiment::RecordSettings settings = experiment.record;
      settings.every = recipient.every.value_or(settings.every);
      settings.fields_every = recipient.fields_every.value_or(settings.fields_every);
      settings.controller = recipient.controller.value_or(settings.controller);
      recorders_.push_back(std::make_unique<recording::Recorder>(
          *experiment.ecosystem, champion.own_seat, *recipient.sink,
          provenance_of(champion, heredity, experiment, options.run), recorder_options(settings)));
      all.push_back(recorders_.back().get());
    }
    witnesses_.emplace(std::move(all));
  }

  /// Null if nobody wants the life.
  [[nodiscard]] recording::LifeWitness* witness() { return witnesses_ ? &*witnesses_ : nullptr; }

 private:
  std::vector<std::unique_ptr<recording::Recorder>> recorders_;
  std::optional<recording::LifeWitnesses> witnesses_;
};

// Keeps the state that is asked for when its step has come.
Observer saving(const ReplayOptions& options, ReplayReport& report) {
  return [&options, &report](const model::Simulation& world) {
    if (options.observer) options.observer(world);
    if (options.save_at != world.steps_done() || world.finished()) return;
    const std::uint64_t hash = world.hash();
    if (hash == report.recorded.life.hashes[world.steps_done() - 1])
      report.saved = state_of(report.recorded, world.steps_done(), hash, model::save(world));
  };
}

/// Replays from a moment on; false where the life up to there is not the recorded one.
bool replay_rest(const ReplayOptions& options, const experiment::Experiment& then,
                 model::Team& team, ReplayReport& report) {
  const Champion& champion = report.recorded;
  const std::optional<Moment> moment =
      options.from_state
          ? moment_in(*options.from_state, champion, *then.ecosystem)
          : moment_before(*options.from_step, options.run, champion, *then.ecosystem, &team);
  if (!moment) return false;
  if (options.save_at && *options.save_at <= moment->step)
    throw UsageError("--at-step " + std::to_string(*options.save_at) + " is not after step " +
                     std::to_string(moment->step) + ", at which the replay begins");
  std::optional<experiment::Experiment> changed;
  if (!options.overrides.empty()) {
    ReplayReport told;  // plugins have been compared already
    changed = load_resolved(options, options.overrides, told);
    check_same_kind(then, *changed, champion);
  }
  const experiment::Experiment& now = changed ? *changed : then;
  try {
    Life life = live_from(*now.ecosystem, champion, moment->world);
    Recorders recorders(options, champion, now);
    life.simulation->tell(recorders.witness());
    life.simulation->use(&team);
    report.beginning = Beginning{.step = moment->step, .file = moment->file, .removed = {}};
    for (const model::Wound& wound : options.wounds)
      report.beginning->removed.push_back(life.simulation->wound(wound));
    report.replayed =
        record_rest(life, champion.own_seat, saving(options, report), recorders.witness());
  } catch (const model::SnapshotError& error) {
    throw UsageError(std::string("--set: cannot be changed in mid-life: ") + error.what());
  }
  return true;
}

void check_moments(const ReplayOptions& options, const Champion& champion) {
  if (!options.save_at) return;
  const std::size_t steps = champion.life.hashes.size();
  if (*options.save_at == 0 || *options.save_at >= steps)
    throw UsageError("--at-step " + std::to_string(*options.save_at) +
                     ": the recorded life has states before steps 1 to " +
                     std::to_string(steps == 0 ? 0 : steps - 1));
}

std::string beginning_text(const Beginning& beginning) {
  std::string text = "from step " + std::to_string(beginning.step);
  if (beginning.file) text += ", with the state of " + beginning.file->string();
  for (const std::uint32_t removed : beginning.removed)
    text += "; wound: " + plural(removed, "cell") + " removed";
  return text + "\n";
}

}  // namespace

ReplayReport replay(const ReplayOptions& options) {
  ReplayReport report;
  report.what_if = !options.overrides.empty() || !options.wounds.empty();
  const bool in_mid_life = options.from_step || options.from_state;
  const std::uint64_t generation =
      options.generation ? *options.generation : last_generation(options.run);
  const std::filesystem::path file = champion_path(options.run, generation, options.population);
  if (!std::filesystem::exists(file) && options.population > 1)
    throw UsageError("population " + std::to_string(options.population) +
                     " has no champion in generation " + std::to_string(generation) + ": " +
                     file.string() + " does not exist; only mode coevolution has two populations");
  if (!std::filesystem::exists(file))
    throw UsageError("generation " + std::to_string(generation) +
                     " has no champion: " + file.string() + " does not exist; the last one is " +
                     std::to_string(last_generation(options.run)));

  const experiment::Experiment experiment =
      load_resolved(options, in_mid_life ? std::vector<std::string>{} : options.overrides, report);
  const evolution::Heredity heredity(*experiment.ecosystem);
  report.recorded = parse_champion(read_file(file), file.string(), heredity, owners_of(experiment));
  check_identity(report.recorded, generation, options.population, options.run, file.string());
  if (!report.recorded.genes_match_bytes) report.warnings.push_back(edited_warning(file.string()));
  make_fit(report.recorded, heredity, report, file.string());
  check_moments(options, report.recorded);
  if (options.prelude) options.prelude(report.recorded);

  model::Team team(options.world_threads);
  const bool begun = in_mid_life && replay_rest(options, experiment, team, report);
  if (in_mid_life && !begun) {
    // Where there is no such moment, the whole life shows what differs first.
    report.warnings.push_back(
        "the life up to the step asked for is not the recorded one; replaying "
        "all of it, unchanged");
    report.what_if = false;
  }
  if (!begun) {
    Recorders recorders(options, report.recorded, experiment);
    report.replayed =
        *record_life(*experiment.ecosystem, task_of(report.recorded), report.recorded.own_seat, {},
                     saving(options, report), recorders.witness(), &team);
  }
  if (!report.what_if) {
    report.differences = differences(report.recorded, report.replayed);
    if (!report.recorded.genes_match_bytes && report.differences.empty())
      report.differences.emplace_back("the genome was edited, though its life is the same");
  }
  return report;
}

std::string to_text(const ReplayReport& report) {
  const Champion& champion = report.recorded;
  const std::string steps = std::to_string(report.replayed.hashes.size());
  std::string text =
      champion.experiment + ": champion of generation " + std::to_string(champion.generation) +
      (champion.population != 0 ? ", population " + std::to_string(champion.population)
                                : std::string()) +
      ", individual " + std::to_string(champion.individual.id) + " (" +
      std::string(evolution::name_of(champion.individual.origin)) + "), seed " +
      hex64(champion.seed) + "\n";
  if (report.beginning) text += beginning_text(*report.beginning);
  if (report.what_if) {
    text += "recorded: " + life_text(champion.life) + "\n";
    text += "what if:  " + life_text(report.replayed) + "\n";
  } else {
    text += life_text(report.replayed) + "\n";
  }
  text += company_text(champion, report.replayed) + census_text(report.replayed);
  if (report.what_if) return text;

  if (report.matches())
    text += "reproduced: survival and all " + steps + " step hashes" +
            (report.beginning ? " from step " + std::to_string(report.beginning->step) : "") +
            " equal\n";
  else
    text += "NOT reproduced:\n";
  for (const std::string& difference : report.differences) text += "  " + difference + "\n";
  return text;
}

}  // namespace somas::run
