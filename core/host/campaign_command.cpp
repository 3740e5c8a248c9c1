#include "core/host/campaign_command.hpp"

#include <cstdio>

#include "core/evaluation/cluster.hpp"
#include "core/host/exit_codes.hpp"
#include "core/host/run_ending.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/campaign_plan.hpp"
#include "core/run/campaign_runner.hpp"
#include "core/run/errors.hpp"
#include "core/run/signals.hpp"

namespace somas::host {
namespace {

using plugins::plural;

std::string ending_of(const run::CampaignReport& report) {
  std::string text = report.directory.string() + ": " + plural(report.runs, "run") + " of " +
                     plural(report.conditions, "condition") + ", " +
                     std::to_string(report.complete) + " complete";
  if (report.failed > 0) text += ", " + std::to_string(report.failed) + " failed (see index.csv)";
  if (report.best) {
    char best[32];
    std::snprintf(best, sizeof best, "%.6g", *report.best);
    text.append(", best ").append(best).append(" in ").append(report.best_run);
  }
  return text + "\n";
}

int exit_code_of(run::RunFault fault) {
  switch (fault) {
    case run::RunFault::none:
      return exit_ok;
    case run::RunFault::input:
      return exit_bad_input;
    case run::RunFault::plugin:
      return exit_plugin_failed;
    case run::RunFault::disk:
      return exit_cannot_write;
    case run::RunFault::evaluators:
      return exit_evaluators_lost;
    case run::RunFault::internal:
      break;
  }
  return exit_internal_error;
}

/// The options of a command, for the process that goes on after a crash. An MPI job cannot: its
/// other ranks have lost rank 0.
std::optional<std::vector<std::string>> restart_of(
    const BackendChoice& backend, std::uint64_t at_once, bool quiet,
    const std::vector<std::filesystem::path>& plugin_path) {
  if (evaluation::Cluster::present() != nullptr) return std::nullopt;
  std::vector<std::string> words;
  const auto add = [&](const char* option, std::uint64_t value) {
    if (value != 0) words.insert(words.end(), {option, std::to_string(value)});
  };
  if (backend.threads == 0) words = {"--backend", backend.backend};
  if (backend.threads == 0) add("--workers", backend.workers);
  add("--threads", backend.threads);
  add("--world-threads", backend.world_threads);
  add("--evaluator-memory", backend.memory_mib);
  add("--watchdog", backend.watchdog_seconds);
  add("--runs-at-once", at_once);
  if (quiet) words.emplace_back("--quiet");
  for (const std::filesystem::path& directory : plugin_path)
    words.insert(words.end(), {"--plugin-path", directory.string()});
  return words;
}

int end_campaign(const run::CampaignReport& report, bool quiet) {
  const int signal = report.stopped ? run::SignalGuard::received() : 0;
  try {
    if (!quiet) print(ending_of(report));
  } catch (const run::WriteError&) {
    // The terminal that hung up cannot show it.
    if (exit_code_of_signal(signal) != exit_hung_up) throw;
  }
  return signal != 0 ? exit_code_of_signal(signal) : exit_code_of(report.fault);
}

}  // namespace

int run_design(const RunCommand& command, const experiment::Design& design,
               run::Terminal& terminal) {
  const run::SignalGuard signals;
  const run::CampaignPlan plan = run::plan_campaign(design, {.file = command.file,
                                                             .overrides = command.overrides,
                                                             .sweeps = command.sweeps,
                                                             .plugin_path = command.plugin_path,
                                                             .genomes = command.genomes,
                                                             .command_line = command.command_line});
  const auto backend = make_backend(command.backend, terminal);
  if (command.dry_run) print(plan_text(plan));
  if (command.dry_run || !command.quiet)
    terminal.line(cost_text(run::cost_of(plan, *backend, signals.token())));
  if (command.dry_run) return exit_ok;
  const run::CampaignOptions options{
      .backend = backend.get(),
      .at_once = command.at_once,
      .quiet = command.quiet,
      .restart = restart_of(command.backend, command.at_once, command.quiet, command.plugin_path)};
  return end_campaign(
      run::run_campaign(plan, command.out, command.genomes, options, terminal, signals.token()),
      command.quiet);
}

int resume_design(const ResumeCommand& command, run::Terminal& terminal) {
  const run::SignalGuard signals;
  const auto backend = make_backend(command.backend, terminal);
  const run::CampaignOptions options{
      .backend = backend.get(),
      .at_once = command.at_once,
      .quiet = command.quiet,
      .restart = restart_of(command.backend, command.at_once, command.quiet, command.plugin_path)};
  const run::CampaignResumeOptions resume{.directory = command.run,
                                          .replicates = command.replicates,
                                          .generations = command.generations,
                                          .sweeps = command.sweeps,
                                          .accept_changes = command.accept_changes,
                                          .plugin_path = command.plugin_path};
  return end_campaign(run::resume_campaign(resume, options, terminal, signals.token()),
                      command.quiet);
}

int validate_design(const ValidateCommand& command, const experiment::Design& design) {
  const run::CampaignPlan plan = run::plan_campaign(
      design,
      {.file = command.file, .overrides = command.overrides, .plugin_path = command.plugin_path});
  print("OK: " + plan_text(plan));
  return exit_ok;
}

}  // namespace somas::host
