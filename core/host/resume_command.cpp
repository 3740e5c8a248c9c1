#include "core/host/campaign_command.hpp"
#include "core/host/commands.hpp"
#include "core/host/run_ending.hpp"
#include "core/run/campaign.hpp"
#include "core/run/errors.hpp"
#include "core/run/runner.hpp"
#include "core/run/signals.hpp"

namespace somas::host {

int execute(const ResumeCommand& command, run::Terminal& terminal) {
  if (run::holds_campaign(command.run)) return resume_design(command, terminal);
  if (command.replicates || !command.sweeps.empty() || command.at_once != 0)
    throw run::UsageError(
        command.run.string() +
        " is no campaign: --replicates, --sweep and --runs-at-once are for those");
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
