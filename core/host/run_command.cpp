#include <algorithm>

#include <spdlog/spdlog.h>

#include "core/experiment/warnings.hpp"
#include "core/host/campaign_command.hpp"
#include "core/host/commands.hpp"
#include "core/host/run_ending.hpp"
#include "core/run/profile_report.hpp"
#include "core/run/runner.hpp"
#include "core/run/signals.hpp"

namespace somas::host {

namespace {

/// What file and options say of replicates and a sweep; nothing: it is a single run.
std::optional<experiment::Design> design_of(const RunCommand& command) {
  if (command.single) return std::nullopt;
  auto design =
      experiment::read_design(command.file, {command.overrides, command.sweeps, command.dry_run});
  if (design && design->is_one_run() && !command.dry_run) return std::nullopt;
  return design;
}

}  // namespace

int execute(const RunCommand& command, run::Terminal& terminal) {
  const auto design = design_of(command);
  if (design && command.profile)
    throw run::UsageError("--profile looks at one run, not at a campaign; --single makes it one");
  if (design) return run_design(command, *design, terminal);
  // From here on Ctrl-C only asks: plugins may take a while to load.
  const run::SignalGuard signals;
  const experiment::Experiment experiment =
      experiment::load(command.file, {command.overrides, command.plugin_path});
  for (const std::string& warning : experiment::warnings_of(experiment)) spdlog::warn(warning);

  // Only threads of this process can be looked into.
  model::Profile profile;
  const auto backend =
      command.profile
          ? evaluation::thread_backend(std::max(command.backend.threads, command.backend.workers),
                                       &profile, {.threads = command.backend.world_threads})
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
