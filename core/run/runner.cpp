#include "core/run/runner.hpp"

#include <chrono>
#include <utility>

#include "core/evaluation/thread_evaluator.hpp"
#include "core/evolution/reproduction.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/contest.hpp"
#include "core/run/progress.hpp"
#include "core/run/recordings.hpp"
#include "core/run/run_directory.hpp"

namespace somas::run {
namespace {

using plugins::plural;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t largest_genome = std::uint64_t{64} << 20;  // bytes

std::vector<GivenGenome> read_genomes(const std::vector<std::filesystem::path>& files) {
  std::vector<GivenGenome> genomes;
  genomes.reserve(files.size());
  for (const std::filesystem::path& file : files)
    genomes.push_back({file, read_regular_file(file, largest_genome)});
  return genomes;
}

/// One run, from the first generation to the last.
class Run {
 public:
  Run(const experiment::Experiment& experiment, const RunOptions& options, Terminal& terminal,
      evaluation::StopToken stop)
      : experiment_(experiment),
        settings_(experiment.evolution),
        ecosystem_(*experiment.ecosystem),
        heredity_(ecosystem_),
        evaluator_(ecosystem_, options.threads),
        stop_(stop) {
    // Whatever can be wrong with the input shows before a directory is made.
    const std::vector<GivenGenome> given = read_genomes(options.genomes);
    std::vector<std::string> warnings;
    for (const GivenGenome& genome : given) {
      SavedGenome saved =
          parse_genome(genome.text, genome.file.string(), heredity_, owners_of(experiment));
      given_.push_back(std::move(saved.genome));
      for (std::string& warning : saved.warnings) warnings.push_back(std::move(warning));
    }
    if (given_.size() > settings_.population)
      throw UsageError(std::to_string(given_.size()) + " genomes do not fit a population of " +
                       std::to_string(settings_.population));
    const Json manifest =
        manifest_of(experiment, {options.file, options.command_line, options.plugin_path, given});

    const std::filesystem::path path =
        make_run_directory(options.out, experiment.name, experiment.seed);
    directory_.emplace(path, experiment, manifest, given);
    recordings_.emplace(experiment_, heredity_, path);
    report_.directory = path;
    for (const std::string& warning : warnings) terminal.line("warning: " + warning);
    if (options.quiet) return;
    terminal.line("run " + path.string() + ": " + plural(settings_.generations, "generation") +
                  " of " + std::to_string(settings_.population) + ", seed " +
                  std::to_string(experiment.seed) + ", " + plural(evaluator_.threads(), "thread"));
    progress_.emplace(terminal, settings_.generations,
                      evolution::matches(settings_, experiment.seed, 0).size());
  }

  RunReport all_generations() {
    try {
      summarize("running");
      for (std::uint64_t number = 0; number < settings_.generations; ++number) {
        if (!generation(number)) {
          report_.stopped = true;
          break;
        }
        if (number + 1 < settings_.generations) summarize("running");
      }
    } catch (...) {
      // A disk that is full may have room for this; the first failure is the one to tell.
      try {
        summarize("failed");
      } catch (const WriteError&) {
      }
      throw;
    }
    summarize(report_.stopped ? "stopped" : "complete");
    return report_;
  }

 private:
  /// False if stopped; then nothing of this generation reaches the disk.
  bool generation(std::uint64_t number) {
    const Clock::time_point begun = Clock::now();
    if (progress_) progress_->begin_generation(number);
    reproduce(number);
    const auto results = evaluate(number);
    if (!results) return false;

    std::vector<Generation> records(populations_.size());
    for (std::size_t p = 0; p < populations_.size(); ++p) {
      records[p].number = number;
      records[p].population = &populations_[p];
      absorb(*results, p, records[p]);
      if (!record_champion(*results, p, records[p]) || !record_all(number, p)) return false;
    }

    const std::chrono::duration<double> seconds = Clock::now() - begun;
    directory_->commit(records, heredity_, {seconds.count(), evaluator_.threads()});
    note(records);
    return true;
  }

  void reproduce(std::uint64_t number) {
    try {
      populations_.resize(evolution::population_count(settings_));
      for (std::uint32_t p = 0; p < populations_.size(); ++p) {
        const std::uint64_t seed = evolution::population_seed(experiment_.seed, p);
        const auto given =
            p == 0 ? std::span<const model::Genome>(given_) : std::span<const model::Genome>();
        populations_[p] =
            number == 0 ? evolution::initial(settings_, heredity_, seed, given)
                        : evolution::next(settings_, heredity_, populations_[p], seed, number);
      }
      contest_.emplace(settings_, heredity_, experiment_.seed, number, populations_, former_);
    } catch (const model::PluginFailure& failure) {
      throw PluginError("generation " + std::to_string(number) + ": " + failure.what());
    }
  }

  std::optional<std::vector<evaluation::Result>> evaluate(std::uint64_t number) {
    const std::vector<evaluation::Task> tasks = contest_->tasks();
    std::uint64_t done = 0;
    try {
      return evaluator_.evaluate(tasks, stop_, [&](std::size_t, const evaluation::Result&) {
        if (progress_) progress_->update(++done);
      });
    } catch (const evaluation::EvaluationError& error) {
      fail(number, error);
    }
  }

  /// Keeps the genomes that brought a plugin down, so that its author can try again.
  [[noreturn]] void fail(std::uint64_t number, const evaluation::EvaluationError& error) {
    const std::filesystem::path file = directory_->path() / "failed-genome.json";
    const evolution::Match& match = contest_->matches()[error.task()];
    Json json;
    json["generation"] = number;
    std::string who;
    if (match.seats.size() == 1) {
      const evolution::Individual& individual = populations_[0][match.seats[0].index];
      who = "individual " + std::to_string(individual.id);
      json["id"] = individual.id;
      json["seed"] = hex64(match.seed);
      json["error"] = error.what();
      json["genome"] = genome_to_json(individual.genome, heredity_, owners_of(experiment_));
    } else {
      who = "simulation " + std::to_string(error.task());
      json["seed"] = hex64(match.seed);
      json["error"] = error.what();
      json["roster"] =
          roster_to_json(contest_->roster(error.task()), heredity_, owners_of(experiment_));
    }
    write_file(file, to_text(json));
    const std::string text = "generation " + std::to_string(number) + ", " + who + ": " +
                             error.what() + " (genome saved in " + file.string() + ")";
    if (error.of_plugin()) throw PluginError(text);
    throw std::runtime_error(text);
  }

  void absorb(const std::vector<evaluation::Result>& results, std::size_t population,
              Generation& record) {
    evolution::Population& members = populations_[population];
    record.evaluations = results.size();
    for (std::size_t i = 0; i < members.size(); ++i) {
      std::vector<double> trials;
      for (std::uint32_t trial = 0; trial < settings_.trials; ++trial) {
        const Contest::Part part = contest_->part(population, i, trial);
        const evaluation::Row& row = results[part.match].rows[part.seat];
        trials.push_back(row.score);
        record.censored += row.outcome.censored ? 1 : 0;
        record.refused_divisions += row.outcome.refused_divisions;
        record.cell_steps += row.outcome.cell_steps;
      }
      evolution::assign_fitness(members[i], std::move(trials));
      if (settings_.mode != evolution::Mode::solo)
        record.opponents.push_back(contest_->opponents(population, i));
    }
    record.statistics = evolution::statistics(members);
  }

  /// Simulates the best of a population once more, step by step. False if stopped.
  bool record_champion(const std::vector<evaluation::Result>& results, std::size_t population,
                       Generation& record) {
    const std::size_t best = evolution::rank(populations_[population]).front();
    const Contest::Part part = contest_->part(population, best, 0);
    const evaluation::Row& expected = results[part.match].rows[part.seat];
    Champion& champion = record.champion;
    champion = first_trial_of(record.number, population, best);
    auto life = recordings_->champion(champion, stop_);
    if (!life) return false;
    if (life->outcome.survival != expected.outcome.survival || life->score != expected.score)
      throw std::runtime_error(
          "generation " + std::to_string(record.number) + ", individual " +
          std::to_string(champion.individual.id) + ": survived " +
          std::to_string(expected.outcome.survival) + " steps when evaluated and " +
          std::to_string(life->outcome.survival) +
          " when simulated again with the same seed; does a plugin keep state of its own?");
    champion.life = std::move(*life);
    return true;
  }

  /// An individual in the world of its first trial, before it lives.
  [[nodiscard]] Champion first_trial_of(std::uint64_t number, std::size_t population,
                                        std::size_t index) const {
    const Contest::Part part = contest_->part(population, index, 0);
    Champion who;
    who.experiment = experiment_.name;
    who.generation = number;
    if (populations_.size() > 1) who.population = static_cast<std::uint32_t>(population) + 1;
    who.individual = populations_[population][index];
    who.seed = contest_->matches()[part.match].seed;
    who.roster = contest_->roster(part.match);
    who.own_seat = part.seat;
    return who;
  }

  /// Everybody's recording, if the experiment wants it. False if stopped.
  bool record_all(std::uint64_t number, std::size_t population) {
    if (!recordings_->of_all()) return true;
    for (std::size_t i = 0; i < populations_[population].size(); ++i)
      if (!recordings_->individual(first_trial_of(number, population, i), stop_)) return false;
    return true;
  }

  void note(const std::vector<Generation>& records) {
    bool first = report_.generations == 0;
    for (const Generation& record : records) {
      if (!first && record.statistics.best <= report_.best) continue;
      report_.best = record.statistics.best;
      report_.best_generation = record.number;
      first = false;
    }
    report_.generations = records.front().number + 1;
    if (settings_.mode == evolution::Mode::hall_of_fame) {
      const evolution::Individual& champion = records.front().champion.individual;
      former_.push_back({champion.id, champion.genome});
    }
    if (progress_) progress_->end_generation(records.front().statistics);
  }

  void summarize(const char* status) {
    Json json;
    json["status"] = status;
    json["generations"] = report_.generations;
    json["planned_generations"] = settings_.generations;
    if (report_.generations > 0) {
      json["best"] = report_.best;
      json["best_generation"] = report_.best_generation;
    }
    directory_->summarize(json);
  }

  const experiment::Experiment& experiment_;
  const evolution::Settings& settings_;
  const model::Ecosystem& ecosystem_;
  evolution::Heredity heredity_;
  evaluation::ThreadEvaluator evaluator_;
  evaluation::StopToken stop_;
  std::vector<model::Genome> given_;
  std::optional<RunDirectory> directory_;
  std::optional<Recordings> recordings_;
  std::optional<Progress> progress_;
  std::vector<evolution::Population> populations_;
  std::vector<FormerChampion> former_;  ///< by generation, for the hall of fame
  std::optional<Contest> contest_;      ///< of the present generation
  RunReport report_;
};

}  // namespace

RunReport run(const experiment::Experiment& experiment, const RunOptions& options,
              Terminal& terminal, evaluation::StopToken stop) {
  return Run(experiment, options, terminal, stop).all_generations();
}

}  // namespace somas::run
