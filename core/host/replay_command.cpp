#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/report/anatomy.hpp"
#include "core/run/files.hpp"
#include "core/run/replay.hpp"

namespace somas::host {

int execute(const ReplayCommand& command, run::Terminal& terminal) {
  report::Anatomy anatomy;
  run::ReplayOptions options{.run = command.run,
                             .generation = command.generation,
                             .overrides = command.overrides,
                             .plugin_directories = command.plugin_path,
                             .observer = {}};
  if (command.anatomy || command.anatomy_csv)
    options.observer = [&](const model::Simulation& world) { anatomy.observe(world); };
  const run::ReplayReport replayed = run::replay(options);
  for (const std::string& warning : replayed.warnings) terminal.line("warning: " + warning);
  print(to_text(replayed));
  if (command.anatomy) print("anatomy\n" + anatomy.to_text());
  if (command.anatomy_csv) run::write_file(*command.anatomy_csv, anatomy.to_csv());
  if (command.csv) run::write_file(*command.csv, run::to_csv(replayed.replayed));
  return replayed.matches() ? exit_ok : exit_not_reproduced;
}

}  // namespace somas::host
