#include "core/experiment/experiment.hpp"
#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/run/compete.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"

namespace somas::host {

int execute(const CompeteCommand& command, run::Terminal& terminal) {
  if (command.csv && command.csv->empty()) throw run::UsageError("--csv: the name is empty");
  if (command.csv) {
    for (const std::filesystem::path& genome : command.genomes)
      if (run::target_of(genome) == run::target_of(*command.csv))
        throw run::UsageError("--csv: " + command.csv->string() +
                              " is one of the genomes; name another file");
    run::check_output(*command.csv);
  }
  const experiment::Experiment experiment =
      experiment::load(command.file, {command.overrides, command.plugin_path});
  const run::CompeteReport report = run::compete(experiment, {.genomes = command.genomes,
                                                              .against_random = command.random,
                                                              .seeds = command.seeds,
                                                              .threads = command.threads});
  for (const std::string& warning : report.warnings) terminal.line("warning: " + warning);
  print(to_text(report));
  if (command.csv) run::write_output(*command.csv, run::to_csv(report));
  return exit_ok;
}

}  // namespace somas::host
