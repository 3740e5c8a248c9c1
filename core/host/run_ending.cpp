#include "core/host/run_ending.hpp"

#include <csignal>
#include <cstdio>
#include <string>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"
#include "core/run/signals.hpp"

namespace somas::host {
namespace {

std::string ending_of(const run::RunReport& report) {
  std::string text = report.directory.string() + ": ";
  if (report.generations == 0) return text + "stopped before a generation was finished\n";
  char best[32];
  std::snprintf(best, sizeof best, "%.6g", report.best);
  if (report.stopped)
    text += "stopped after " + std::to_string(report.generations) + " of " +
            plugins::plural(report.planned, "generation");
  else
    text += plugins::plural(report.generations, "generation");
  return text + ", best " + best + " in generation " + std::to_string(report.best_generation) +
         "\n";
}

}  // namespace

int exit_code_of_signal(int signal) {
  if (signal == SIGHUP) return exit_hung_up;
  // Ctrl-C is a person's; all others come from who manages the machine.
  return signal == SIGINT ? exit_interrupted : exit_terminated;
}

int end_run(const run::RunReport& report, bool quiet) {
  const int signal = report.stopped ? run::SignalGuard::received() : 0;
  try {
    if (!quiet) print(ending_of(report));
  } catch (const run::WriteError&) {
    // The terminal that hung up cannot show it.
    if (signal != SIGHUP) throw;
  }
  return report.stopped ? exit_code_of_signal(signal) : static_cast<int>(exit_ok);
}

}  // namespace somas::host
