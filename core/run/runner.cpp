#include "core/run/runner.hpp"

#include <future>
#include <utility>

#include "core/evaluation/crash_report.hpp"
#include "core/evolution/matching.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/progress.hpp"
#include "core/run/resume.hpp"
#include "core/run/run_directory.hpp"

namespace somas::run {
namespace {

using plugins::plural;

constexpr std::uint64_t largest_genome = std::uint64_t{64} << 20;  // bytes

std::vector<GivenGenome> read_genomes(const std::vector<std::filesystem::path>& files) {
  std::vector<GivenGenome> genomes;
  genomes.reserve(files.size());
  for (const std::filesystem::path& file : files)
    genomes.push_back({file, read_regular_file(file, largest_genome)});
  return genomes;
}

/// Genomes that seed a first generation, and what to say of them.
struct Given {
  std::vector<model::Genome> genomes;
  std::vector<std::string> warnings;
};

Given parse_genomes(const std::vector<GivenGenome>& files,
                    const experiment::Experiment& experiment) {
  const evolution::Heredity heredity(*experiment.ecosystem);
  Given given;
  for (const GivenGenome& file : files) {
    SavedGenome saved =
        parse_genome(file.text, file.file.string(), heredity, owners_of(experiment));
    given.genomes.push_back(std::move(saved.genome));
    for (std::string& warning : saved.warnings) given.warnings.push_back(std::move(warning));
  }
  if (given.genomes.size() > experiment.evolution.population)
    throw UsageError(std::to_string(given.genomes.size()) + " genomes do not fit a population of " +
                     std::to_string(experiment.evolution.population));
  return given;
}

/// How a run is carried out.
struct Ways {
  evaluation::Backend* backend = nullptr;
  unsigned threads = 0;
  bool quiet = false;
  Watcher* watcher = nullptr;
  bool any_machine = false;  ///< even if it computes other bits than those before
};

/// From where the directory stands to the end, with progress on the terminal.
RunReport carry_out(const experiment::Experiment& experiment, RunDirectory& directory,
                    std::vector<model::Genome> given, const Ways& ways, Terminal& terminal,
                    evaluation::StopToken stop) {
  const auto own_backend =
      ways.backend != nullptr ? nullptr : evaluation::thread_backend(ways.threads);
  evaluation::Backend& backend = ways.backend != nullptr ? *ways.backend : *own_backend;
  const auto evaluator = backend.evaluator(experiment);
  if (const auto reference = directory.store().reference(); reference && !ways.any_machine)
    evaluator->expect(*reference);
  const evolution::Settings& settings = experiment.evolution;
  const std::uint64_t finished = directory.store().generations();
  std::optional<Progress> progress;
  if (ways.watcher != nullptr) {
    // It is told all that the terminal would show.
  } else if (!ways.quiet && finished == settings.generations) {
    terminal.line("run " + directory.path().string() + " is complete: " +
                  plural(finished, "generation") + " (--generations N extends it)");
  } else if (!ways.quiet) {
    terminal.line("run " + directory.path().string() + ": " +
                  plural(settings.generations, "generation") + " of " +
                  std::to_string(settings.population) + ", seed " +
                  std::to_string(experiment.seed) + ", " + backend.description() +
                  (finished > 0 ? "; " + plural(finished, "generation") + " done" : ""));
    progress.emplace(terminal, settings.generations,
                     evolution::matches(settings, experiment.seed, 0).size());
  }
  Watcher* watcher = progress ? &*progress : ways.watcher;
  Coordinator coordinator({experiment, *evaluator, backend.workers(), directory, watcher, stop,
                           backend.world_threads()},
                          std::move(given));
  const std::filesystem::path crash = crash_path(directory.path());
  std::error_code ignored;
  std::filesystem::remove(crash, ignored);
  // In a thread of its own, which is named after what it does (see enter_phase).
  return std::async(std::launch::async,
                    [&] {
                      const evaluation::WatchedThread watched(crash);
                      return coordinator.all_generations();
                    })
      .get();
}

/// Copies of the genomes that seeded the run, from its directory.
std::vector<GivenGenome> genomes_in(const std::filesystem::path& run) {
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0;; ++i) {
    std::filesystem::path file = run / "genomes" / ("given-" + std::to_string(i) + ".json");
    std::error_code error;
    if (!std::filesystem::exists(file, error)) break;
    files.push_back(std::move(file));
  }
  return read_genomes(files);
}

}  // namespace

void check_genomes(const std::vector<std::filesystem::path>& files,
                   const experiment::Experiment& experiment) {
  static_cast<void>(parse_genomes(read_genomes(files), experiment));
}

RunReport run(const experiment::Experiment& experiment, const RunOptions& options,
              Terminal& terminal, evaluation::StopToken stop) {
  // Whatever can be wrong with the input shows before a directory is made.
  const std::vector<GivenGenome> files = read_genomes(options.genomes);
  Given given = parse_genomes(files, experiment);
  const Json manifest =
      manifest_of(experiment, {options.file, options.command_line, options.plugin_path, files});

  const std::filesystem::path path =
      make_run_directory(options.out, experiment.name, experiment.seed);
  RunDirectory directory(path, experiment, manifest, files);
  for (const std::string& warning : given.warnings) terminal.line("warning: " + warning);
  return carry_out(experiment, directory, std::move(given.genomes),
                   {options.backend, options.threads, options.quiet, options.watcher}, terminal,
                   stop);
}

RunReport resume(const ResumeOptions& options, Terminal& terminal, evaluation::StopToken stop) {
  Resumption resumption = reopen(options, terminal);
  const std::vector<GivenGenome> files = genomes_in(options.run);
  Given given = parse_genomes(files, resumption.experiment);
  return carry_out(
      resumption.experiment, *resumption.directory, std::move(given.genomes),
      {options.backend, options.threads, options.quiet, options.watcher, options.accept_changes},
      terminal, stop);
}

}  // namespace somas::run
