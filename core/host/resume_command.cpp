#include "core/host/commands.hpp"
#include "core/host/run_ending.hpp"
#include "core/run/runner.hpp"
#include "core/run/signals.hpp"

namespace somas::host {

int execute(const ResumeCommand& command, run::Terminal& terminal) {
  const run::SignalGuard signals;
  const auto backend = make_backend(command.backend, terminal);
  run::ResumeOptions options;
  options.run = command.run;
  options.generations = command.generations;
  options.accept_changes = command.accept_changes;
  options.plugin_path = command.plugin_path;
  options.backend = backend.get();
  options.quiet = command.quiet;
  return end_run(run::resume(options, terminal, signals.token()), command.quiet);
}

}  // namespace somas::host
