#include <array>
#include <string_view>
#include <system_error>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/report/anatomy.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/replay.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 10> files_of_a_run = {
    "experiment.yaml", "resolved.yaml", "manifest.json",      "generations.csv", "individuals.csv",
    "timing.csv",      "summary.json",  "failed-genome.json", "champions",       "genomes"};

// A record that a replay overwrites proves nothing any more.
void refuse_file_of_run(const char* option, const fs::path& file, const fs::path& run) {
  const fs::path inside =
      run::target_of(file).lexically_relative(run::target_of(run / ".").lexically_normal());
  if (inside.empty()) return;
  for (const std::string_view name : files_of_a_run)
    if (*inside.begin() == fs::path(name))
      throw run::UsageError(std::string(option) + ": " + file.string() +
                            " belongs to the run, and is never overwritten; name another file");
}

void check_outputs(const ReplayCommand& command) {
  const auto check = [&](const char* option, const std::optional<fs::path>& file) {
    if (!file) return;
    if (file->empty()) throw run::UsageError(std::string(option) + ": the name is empty");
    refuse_file_of_run(option, *file, command.run);
    run::check_output(*file);
  };
  if (command.csv && command.anatomy_csv && !command.csv->empty()) {
    std::error_code error;
    if (run::target_of(*command.csv) == run::target_of(*command.anatomy_csv) ||
        fs::equivalent(*command.csv, *command.anatomy_csv, error))
      throw run::UsageError("--csv and --anatomy-csv name the same file: " + command.csv->string());
  }
  check("--csv", command.csv);
  check("--anatomy-csv", command.anatomy_csv);
}

}  // namespace

int execute(const ReplayCommand& command, run::Terminal& terminal) {
  check_outputs(command);
  report::Anatomy anatomy;
  run::ReplayOptions options{.run = command.run,
                             .generation = command.generation,
                             .population = command.population,
                             .overrides = command.overrides,
                             .plugin_directories = command.plugin_path,
                             .observer = {}};
  if (command.anatomy || command.anatomy_csv)
    options.observer = [&](const model::Simulation& world) {
      if (world.state().organisms.size() > 1)
        throw run::UsageError("--anatomy is of an organism alone in its world; this champion had " +
                              std::to_string(world.state().organisms.size() - 1) + " for company");
      anatomy.observe(world);
    };
  const run::ReplayReport replayed = run::replay(options);
  for (const std::string& warning : replayed.warnings) terminal.line("warning: " + warning);
  print(to_text(replayed));
  if (command.anatomy) print("anatomy\n" + anatomy.to_text());
  if (command.anatomy_csv) run::write_output(*command.anatomy_csv, anatomy.to_csv());
  if (command.csv) run::write_output(*command.csv, run::to_csv(replayed.replayed));
  return replayed.matches() ? exit_ok : exit_not_reproduced;
}

}  // namespace somas::host
