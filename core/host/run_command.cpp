#include <algorithm>

#include "core/host/commands.hpp"
#include "core/host/run_ending.hpp"
#include "core/run/profile_report.hpp"
#include "core/run/runner.hpp"
#include "core/run/signals.hpp"

namespace somas::host {

int execute(const RunCommand& command, run::Terminal& terminal) {
  // From here on Ctrl-C only asks: plugins may take a while to load.
  const run::SignalGuard signals;
  const experiment::Experiment experiment =
      experiment::load(command.file, {command.overrides, command.plugin_path});

  // Only threads of this process can be looked into.
  model::Profile profile;
  const auto backend =
      command.profile ? evaluation::thread_backend(
                            std::max(command.backend.threads, command.backend.workers), &profile)
                      : make_backend(command.backend, terminal);
  run::RunOptions options;
  options.file = command.file;
  options.out = command.out;
  options.backend = backend.get();
  options.quiet = command.quiet;
  options.genomes = command.genomes;
  options.plugin_path = command.plugin_path;
  options.command_line = command.command_line;
  const run::RunReport report = run::run(experiment, options, terminal, signals.token());
  if (command.profile) {
    const run::ProfileReport measured = run::report_on(profile);
    run::write_profile(report.directory, measured);
    if (!command.quiet) print(run::to_text(measured));
  }
  return end_run(report, command.quiet);
}

}  // namespace somas::host
