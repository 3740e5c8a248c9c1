#include "core/run/runner.hpp"

#include <chrono>
#include <utility>

#include "core/evaluation/thread_evaluator.hpp"
#include "core/evolution/reproduction.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/progress.hpp"
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
    report_.directory = path;
    for (const std::string& warning : warnings) terminal.line("warning: " + warning);
    if (options.quiet) return;
    terminal.line("run " + path.string() + ": " + plural(settings_.generations, "generation") +
                  " of " + std::to_string(settings_.population) + ", seed " +
                  std::to_string(experiment.seed) + ", " + plural(evaluator_.threads(), "thread"));
    progress_.emplace(terminal, settings_.generations, evaluations());
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
  /// Simulations a generation.
  [[nodiscard]] std::uint64_t evaluations() const {
    return std::uint64_t{settings_.population} * settings_.trials;
  }

  /// False if stopped; then nothing of this generation reaches the disk.
  bool generation(std::uint64_t number) {
    const Clock::time_point begun = Clock::now();
    if (progress_) progress_->begin_generation(number);
    reproduce(number);
    const auto results = evaluate(number);
    if (!results) return false;

    Generation record;
    record.number = number;
    record.population = &population_;
    record.evaluations = evaluations();
    absorb(*results, record);
    record.statistics = evolution::statistics(population_);
    const std::size_t best = evolution::rank(population_).front();
    const evaluation::Row& expected = (*results)[best * settings_.trials].rows.front();
    if (!record_champion(number, best, expected, record.champion)) return false;

    const std::chrono::duration<double> seconds = Clock::now() - begun;
    directory_->commit(record, heredity_, {seconds.count(), evaluator_.threads()});
    note(record);
    return true;
  }

  void reproduce(std::uint64_t number) {
    try {
      population_ = number == 0 ? evolution::initial(settings_, heredity_, experiment_.seed, given_)
                                : evolution::next(settings_, heredity_, population_,
                                                  experiment_.seed, number);
    } catch (const model::PluginFailure& failure) {
      throw PluginError("generation " + std::to_string(number) + ": " + failure.what());
    }
  }

  std::optional<std::vector<evaluation::Result>> evaluate(std::uint64_t number) {
    // All individuals face the same seeds.
    std::vector<evaluation::Task> tasks;
    tasks.reserve(evaluations());
    for (const evolution::Individual& individual : population_)
      for (std::uint32_t trial = 0; trial < settings_.trials; ++trial)
        tasks.push_back(
            single_task(individual.genome, evolution::trial_seed(experiment_.seed, number, trial)));
    try {
      return evaluator_.evaluate(tasks, stop_, [this](std::size_t done) {
        if (progress_) progress_->update(done);
      });
    } catch (const evaluation::EvaluationError& error) {
      fail(number, population_[error.task() / settings_.trials], tasks[error.task()].seed, error);
    }
  }

  /// Keeps the genome that brought a plugin down, so that its author can try again.
  [[noreturn]] void fail(std::uint64_t number, const evolution::Individual& individual,
                         std::uint64_t seed, const evaluation::EvaluationError& error) {
    const std::filesystem::path file = directory_->path() / "failed-genome.json";
    Json json;
    json["generation"] = number;
    json["id"] = individual.id;
    json["seed"] = hex64(seed);
    json["error"] = error.what();
    json["genome"] = genome_to_json(individual.genome, heredity_, owners_of(experiment_));
    write_file(file, to_text(json));
    const std::string text = "generation " + std::to_string(number) + ", individual " +
                             std::to_string(individual.id) + ": " + error.what() +
                             " (genome saved in " + file.string() + ")";
    if (error.of_plugin()) throw PluginError(text);
    throw std::runtime_error(text);
  }

  void absorb(const std::vector<evaluation::Result>& results, Generation& record) {
    for (std::size_t i = 0; i < population_.size(); ++i) {
      std::vector<double> trials;
      for (std::size_t trial = 0; trial < settings_.trials; ++trial) {
        const evaluation::Row& row = results[i * settings_.trials + trial].rows.front();
        trials.push_back(row.score);
        record.censored += row.outcome.censored ? 1 : 0;
        record.refused_divisions += row.outcome.refused_divisions;
        record.cell_steps += row.outcome.cell_steps;
      }
      evolution::assign_fitness(population_[i], std::move(trials));
    }
  }

  /// Simulates the best once more, step by step. False if stopped.
  bool record_champion(std::uint64_t number, std::size_t best, const evaluation::Row& expected,
                       Champion& champion) {
    champion.experiment = experiment_.name;
    champion.generation = number;
    champion.individual = population_[best];
    champion.seed = evolution::trial_seed(experiment_.seed, number, 0);
    auto recording = record(ecosystem_, champion.individual.genome, champion.seed, stop_);
    if (!recording) return false;
    if (recording->outcome.survival != expected.outcome.survival ||
        recording->score != expected.score)
      throw std::runtime_error(
          "generation " + std::to_string(number) + ", individual " +
          std::to_string(champion.individual.id) + ": survived " +
          std::to_string(expected.outcome.survival) + " steps when evaluated and " +
          std::to_string(recording->outcome.survival) +
          " when simulated again with the same seed; does a plugin keep state of its own?");
    champion.recording = std::move(*recording);
    return true;
  }

  void note(const Generation& record) {
    if (report_.generations == 0 || record.statistics.best > report_.best) {
      report_.best = record.statistics.best;
      report_.best_generation = record.number;
    }
    report_.generations = record.number + 1;
    if (progress_) progress_->end_generation(record.statistics);
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
  std::optional<Progress> progress_;
  evolution::Population population_;
  RunReport report_;
};

}  // namespace

RunReport run(const experiment::Experiment& experiment, const RunOptions& options,
              Terminal& terminal, evaluation::StopToken stop) {
  return Run(experiment, options, terminal, stop).all_generations();
}

}  // namespace somas::run
