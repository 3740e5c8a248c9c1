#include <array>
#include <csignal>
#include <string_view>
#include <system_error>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/report/anatomy.hpp"
#include "core/report/picture.hpp"
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

void refuse_same_file(const char* option, const std::optional<fs::path>& file, const char* other,
                      const std::optional<fs::path>& other_file) {
  if (!file || !other_file || file->empty()) return;
  std::error_code error;
  if (run::target_of(*file) == run::target_of(*other_file) ||
      fs::equivalent(*file, *other_file, error))
    throw run::UsageError(std::string(option) + " and " + other +
                          " name the same file: " + file->string());
}

void check_outputs(const ReplayCommand& command) {
  const auto check = [&](const char* option, const std::optional<fs::path>& file) {
    if (!file) return;
    if (file->empty()) throw run::UsageError(std::string(option) + ": the name is empty");
    refuse_file_of_run(option, *file, command.run);
    run::check_output(*file);
  };
  refuse_same_file("--csv", command.csv, "--anatomy-csv", command.anatomy_csv);
  refuse_same_file("--csv", command.csv, "--picture", command.picture.file);
  refuse_same_file("--anatomy-csv", command.anatomy_csv, "--picture", command.picture.file);
  check("--csv", command.csv);
  check("--anatomy-csv", command.anatomy_csv);
  check("--picture", command.picture.file);
}

std::optional<report::Picture> picture_of(const PictureCommand& command) {
  if (!command.file) return std::nullopt;
  (void)report::picture_format(*command.file);  // refuses before a life is simulated
  return report::Picture({.steps = command.steps,
                          .grid = command.grid,
                          .whole_world = command.view == "world",
                          .width = command.width});
}

}  // namespace

int execute(const ReplayCommand& command, run::Terminal& terminal) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a write error, not the end
  std::optional<report::Picture> picture = picture_of(command.picture);
  check_outputs(command);
  report::Anatomy anatomy;
  run::ReplayOptions options{.run = command.run,
                             .generation = command.generation,
                             .overrides = command.overrides,
                             .plugin_directories = command.plugin_path,
                             .observer = {}};
  const bool with_anatomy = command.anatomy || command.anatomy_csv;
  if (with_anatomy || picture)
    options.observer = [&](const model::Simulation& world) {
      if (with_anatomy) anatomy.observe(world);
      if (picture) picture->observe(world);
    };
  const run::ReplayReport replayed = run::replay(options);
  if (picture) picture->check_complete();
  for (const std::string& warning : replayed.warnings) terminal.line("warning: " + warning);
  print(to_text(replayed));
  if (command.anatomy) print("anatomy\n" + anatomy.to_text());
  if (command.anatomy_csv) run::write_output(*command.anatomy_csv, anatomy.to_csv());
  if (picture)
    run::write_output(*command.picture.file,
                      picture->render(report::picture_format(*command.picture.file)));
  if (command.csv) run::write_output(*command.csv, run::to_csv(replayed.replayed));
  return replayed.matches() ? exit_ok : exit_not_reproduced;
}

}  // namespace somas::host
