#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/run/files.hpp"
#include "core/run/replay.hpp"

namespace somas::host {

int execute(const ReplayCommand& command, run::Terminal& terminal) {
  const run::ReplayReport report =
      run::replay({command.run, command.generation, command.overrides, command.plugin_path});
  for (const std::string& warning : report.warnings) terminal.line("warning: " + warning);
  print(to_text(report));
  if (command.csv) run::write_file(*command.csv, run::to_csv(report.replayed));
  return report.matches() ? exit_ok : exit_not_reproduced;
}

}  // namespace somas::host
