#include <array>
#include <charconv>
#include <cmath>
#include <csignal>
#include <system_error>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/host/output_check.hpp"
#include "core/host/replay_page.hpp"
#include "core/recording/file.hpp"
#include "core/report/anatomy.hpp"
#include "core/report/picture.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/replay.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/state_file.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;

model::Wound wound_of(const std::string& text) {
  std::array<double, 3> numbers{};
  const char* at = text.data();
  const char* end = at + text.size();
  for (std::size_t i = 0; i < numbers.size() && at != nullptr; ++i) {
    const auto read = std::from_chars(at, end, numbers[i]);
    const bool closed =
        i + 1 < numbers.size() ? read.ptr != end && *read.ptr == ',' : read.ptr == end;
    at = read.ec == std::errc{} && closed && std::isfinite(numbers[i]) ? read.ptr + 1 : nullptr;
  }
  if (at == nullptr || !(numbers[2] > 0))
    throw run::UsageError("--wound: '" + text +
                          "' is not X,Y,RADIUS, three numbers, the radius greater than 0");
  return {.x = numbers[0], .y = numbers[1], .radius = numbers[2]};
}

void check_moments(const ReplayCommand& command) {
  if (command.from_step && command.from_state)
    throw run::UsageError("--from-step and --from-state say both where to begin; give one of them");
  if (!command.wounds.empty() && !command.from_step && !command.from_state)
    throw run::UsageError("--wound needs --from-step or --from-state: when is the wound?");
  if (command.save != command.at_step.has_value())
    throw run::UsageError(command.save
                              ? "--save-state needs --at-step: the state before which step?"
                              : "--at-step belongs to --save-state");
  if (command.save && (!command.overrides.empty() || !command.wounds.empty()))
    throw run::UsageError("--save-state is for the recorded life, without --set and --wound");
}

/// Where --save-state writes; nothing if it is not asked for.
std::optional<fs::path> state_file_of(const ReplayCommand& command) {
  if (!command.save) return std::nullopt;
  if (command.save_state) return command.save_state;
  const std::uint64_t generation =
      command.generation ? *command.generation : run::last_generation(command.run);
  const fs::path file =
      run::state_path(command.run, generation, command.population, *command.at_step);
  // A directory that cannot be made is told before the life is simulated.
  std::error_code error;
  run::check_output(fs::is_directory(file.parent_path(), error) ? file : file.parent_path());
  return file;
}

void write_state(const fs::path& file, const run::SavedState& state, bool in_run) {
  std::error_code error;
  if (in_run) fs::create_directory(file.parent_path(), error);
  if (error) throw run::WriteError(file.parent_path(), error.value());
  run::write_output(file, to_text(state));
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
  const std::array<std::pair<const char*, const std::optional<fs::path>*>, 6> outputs{
      {{"--html", &command.page.file},
       {"--record", &command.record},
       {"--csv", &command.csv},
       {"--anatomy-csv", &command.anatomy_csv},
       {"--picture", &command.picture.file},
       {"--save-state", &command.save_state}}};
  for (const auto& [option, file] : outputs)
    for (const auto& [other, other_file] : outputs)
      if (file != other_file) refuse_same_file(option, *file, other, *other_file);
  for (const auto& [option, file] : outputs) {
    if (!*file) continue;
    if ((*file)->empty()) throw run::UsageError(std::string(option) + ": the name is empty");
    refuse_file_of_run(option, **file, command.run);
    run::check_output(**file);
  }
  if ((command.every || command.fields_every) && !command.page.file && !command.record)
    throw run::UsageError(std::string(command.every ? "--every" : "--fields-every") +
                          " is of a page or a recording; give --html or --record");
}

/// A recording does not live again: it can be shown only.
void check_recording(const ReplayCommand& command) {
  const auto refuse = [&](const char* option, bool given) {
    if (given)
      throw run::UsageError(std::string(option) + " needs a run directory; " +
                            command.run.string() + " is a recording");
  };
  refuse("--generation", command.generation.has_value());
  refuse("--population", command.population != 1);
  refuse("--set", !command.overrides.empty());
  refuse("--from-step", command.from_step.has_value());
  refuse("--from-state", command.from_state.has_value());
  refuse("--save-state", command.save);
  refuse("--anatomy", command.anatomy);
  refuse("--anatomy-csv", command.anatomy_csv.has_value());
  refuse("--csv", command.csv.has_value());
  refuse("--picture", command.picture.file.has_value());
  refuse("--record", command.record.has_value());
  refuse("--every", command.every.has_value());
  refuse("--fields-every", command.fields_every.has_value());
  if (!command.page.file)
    throw run::UsageError(command.run.string() +
                          " is a recording, which cannot be replayed; --html FILE makes a page of "
                          "it, `somas-host render` a figure");
  if (!command.page.compare) refuse("--compare-set", !command.page.compare_overrides.empty());
  refuse_same_file("--html", command.page.file, "RUN", command.run);
  run::check_output(*command.page.file);
}

int show_recording(const ReplayCommand& command, run::Terminal& terminal) {
  check_recording(command);
  ReplayPage page(command);
  recording::read(command.run, *page.life().sink);
  return page.write(terminal) ? exit_ok : exit_not_reproduced;
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
  // A file that may not grow is an error to report, not a death by signal.
  std::signal(SIGXFSZ, SIG_IGN);
  std::error_code error;
  if (fs::is_regular_file(command.run, error)) return show_recording(command, terminal);
  check_moments(command);
  std::optional<report::Picture> picture = picture_of(command.picture);
  check_outputs(command);
  const std::optional<fs::path> state_file = state_file_of(command);
  report::Anatomy anatomy;
  run::ReplayOptions options{.run = command.run,
                             .generation = command.generation,
                             .population = command.population,
                             .overrides = command.overrides,
                             .plugin_directories = command.plugin_path,
                             .observer = {},
                             .from_step = command.from_step,
                             .from_state = command.from_state,
                             .wounds = {},
                             .save_at = command.at_step,
                             .world_threads = command.world_threads};
  for (const std::string& wound : command.wounds) options.wounds.push_back(wound_of(wound));
  const bool with_anatomy = command.anatomy || command.anatomy_csv;
  if (with_anatomy || picture)
    options.observer = [&](const model::Simulation& world) {
      if (with_anatomy && world.state().organisms.size() > 1)
        throw run::UsageError("--anatomy is of an organism alone in its world; this champion had " +
                              std::to_string(world.state().organisms.size() - 1) + " for company");
      if (with_anatomy) anatomy.observe(world);
      if (picture) picture->observe(world);
    };
  if (picture)
    options.prelude = [&](const run::Champion& champion) { picture->about(champion.own_seat); };
  std::optional<ReplayPage> page;
  if (command.page.file) options.recipients.push_back(page.emplace(command).life());
  recording::FileWriter recorded;
  if (command.record)
    options.recipients.push_back(
        {.sink = &recorded, .every = command.every, .fields_every = command.fields_every});
  const run::ReplayReport replayed = run::replay(options);
  if (picture) picture->check_complete();
  for (const std::string& warning : replayed.warnings) terminal.line("warning: " + warning);
  print(to_text(replayed));
  if (command.anatomy) print("anatomy\n" + anatomy.to_text());
  if (command.anatomy_csv) run::write_output(*command.anatomy_csv, anatomy.to_csv());
  if (state_file && replayed.saved) {
    write_state(*state_file, *replayed.saved, !command.save_state);
    print("state before step " + std::to_string(replayed.saved->step) + ": " +
          state_file->string() + "\n");
  } else if (state_file) {
    terminal.line("warning: no state is saved: the life up to it is not the recorded one");
  }
  if (picture)
    run::write_output(*command.picture.file,
                      picture->render(report::picture_format(*command.picture.file)));
  if (command.csv) run::write_output(*command.csv, run::to_csv(replayed.replayed));
  if (command.record) {
    const std::vector<std::byte> bytes = recorded.bytes();
    run::write_output(*command.record, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    print("recording: " + command.record->string() + "\n");
  }
  const bool compared = !page || page->write(terminal);
  return replayed.matches() && compared ? exit_ok : exit_not_reproduced;
}

}  // namespace somas::host
