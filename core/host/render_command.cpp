#include <charconv>
#include <csignal>
#include <system_error>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/host/output_check.hpp"
#include "core/report/render.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;
using report::PictureFormat;

/// "250", or "0:1000:100".
void add_steps(const std::string& text, std::vector<std::uint64_t>& steps) {
  std::vector<std::uint64_t> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  for (;;) {
    std::uint64_t value = 0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc{} || (read.ptr != end && *read.ptr != ':')) numbers.clear();
    if (read.ec != std::errc{} || (read.ptr != end && *read.ptr != ':')) break;
    numbers.push_back(value);
    if (read.ptr == end) break;
    at = read.ptr + 1;
  }
  if (numbers.size() == 1) return steps.push_back(numbers[0]);
  if (numbers.size() != 3 || numbers[0] > numbers[1] || numbers[2] == 0)
    throw run::UsageError("--steps: '" + text +
                          "' is neither a step nor FIRST:LAST:DISTANCE, three whole numbers");
  if ((numbers[1] - numbers[0]) / numbers[2] >= 1000)
    throw run::UsageError("--steps: '" + text + "' are more than 1000 panels");
  for (std::uint64_t step = numbers[0]; step <= numbers[1]; step += numbers[2])
    steps.push_back(step);
}

PictureFormat format_of(const RenderCommand& command) {
  std::optional<PictureFormat> named;
  if (!command.format.empty()) named = report::picture_format("x." + command.format);
  if (!command.out) return named.value_or(PictureFormat::svg);
  const PictureFormat of_file = report::picture_format(*command.out);
  if (named && *named != of_file)
    throw run::UsageError("--format " + command.format + ", but --out " + command.out->string());
  return of_file;
}

// Charts are one column wide unless they have to be wider.
double default_width(report::What what) {
  const bool chart = what == report::What::population || what == report::What::evolution ||
                     what == report::What::lineage;
  return chart ? 85 : 178;
}

report::RenderOptions options_of(const RenderCommand& command) {
  report::RenderOptions options;
  options.what = report::what_named(command.what);
  options.runs = command.runs;
  options.generation = command.generation;
  options.population = command.population;
  options.overrides = command.overrides;
  options.plugin_directories = command.plugin_path;
  options.grid = command.grid;
  options.whole_world = command.view == "world";
  options.columns = command.columns;
  for (const std::string& steps : command.steps) add_steps(steps, options.steps);
  options.size = {.format = format_of(command),
                  .width_mm = command.width > 0 ? command.width : default_width(options.what),
                  .dpi = command.dpi};
  return options;
}

// The figure of a run stands in the run unless the user says otherwise.
fs::path output_of(const RenderCommand& command, const report::RenderOptions& options) {
  const fs::path file = command.out ? *command.out : report::default_output(options);
  for (const fs::path& run : command.runs) refuse_file_of_run("--out", file, run);
  std::error_code error;
  const bool no_directory = !command.out && !fs::is_directory(file.parent_path(), error);
  run::check_output(no_directory ? file.parent_path() : file);
  return file;
}

}  // namespace

int execute(const RenderCommand& command, run::Terminal& terminal) {
  // A file that may not grow is an error to report, not a death by signal.
  std::signal(SIGXFSZ, SIG_IGN);
  const report::RenderOptions options = options_of(command);
  const fs::path file = output_of(command, options);
  try {
    const report::Rendered rendered = report::render(options);
    for (const std::string& warning : rendered.warnings) terminal.line("warning: " + warning);
    std::error_code error;
    if (!command.out) fs::create_directory(file.parent_path(), error);
    if (error) throw run::WriteError(file.parent_path(), error.value());
    run::write_output(file, rendered.bytes);
  } catch (const report::NotReproduced& error) {
    terminal.line(std::string("somas-host: ") + error.what());
    return exit_not_reproduced;
  }
  print(file.string() + "\n");
  return exit_ok;
}

}  // namespace somas::host
