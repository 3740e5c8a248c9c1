#include <csignal>
#include <cstdio>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"
#include "core/run/runner.hpp"
#include "core/run/signals.hpp"

namespace somas::host {
namespace {

std::string ending_of(const run::RunReport& report, std::uint64_t planned) {
  std::string text = report.directory.string() + ": ";
  if (report.generations == 0) return text + "stopped before a generation was finished\n";
  char best[32];
  std::snprintf(best, sizeof best, "%.6g", report.best);
  if (report.stopped)
    text += "stopped after " + std::to_string(report.generations) + " of " +
            plugins::plural(planned, "generation");
  else
    text += plugins::plural(report.generations, "generation");
  return text + ", best " + best + " in generation " + std::to_string(report.best_generation) +
         "\n";
}

}  // namespace

int execute(const RunCommand& command, run::Terminal& terminal) {
  // From here on Ctrl-C only asks: plugins may take a while to load.
  const run::SignalGuard signals;
  const experiment::Experiment experiment =
      experiment::load(command.file, {command.overrides, command.plugin_path});

  const auto backend = make_backend(command.backend, terminal);
  run::RunOptions options;
  options.file = command.file;
  options.out = command.out;
  options.backend = backend.get();
  options.quiet = command.quiet;
  options.genomes = command.genomes;
  options.plugin_path = command.plugin_path;
  options.command_line = command.command_line;
  const run::RunReport report = run::run(experiment, options, terminal, signals.token());

  const int signal = report.stopped ? run::SignalGuard::received() : 0;
  const std::string ending = ending_of(report, experiment.evolution.generations);
  try {
    if (!command.quiet) print(ending);
  } catch (const run::WriteError&) {
    // The terminal that hung up cannot show it.
    if (signal != SIGHUP) throw;
  }
  if (!report.stopped) return exit_ok;
  if (signal == SIGHUP) return exit_hung_up;
  return signal == SIGTERM ? exit_terminated : exit_interrupted;
}

}  // namespace somas::host
