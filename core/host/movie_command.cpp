#include <csignal>
#include <cstdio>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/host/output_check.hpp"
#include "core/plugins/suggest.hpp"
#include "core/report/encoder.hpp"
#include "core/report/movie.hpp"
#include "core/report/recorded_life.hpp"
#include "core/report/render.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/signals.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;

/// On a terminal one line, redrawn; elsewhere a line at every quarter.
class FrameProgress {
 public:
  FrameProgress(run::Terminal& terminal, std::uint64_t frames)
      : terminal_(terminal), frames_(frames) {}
  ~FrameProgress() { terminal_.status(""); }

  void done(std::uint64_t count) {
    const std::uint64_t percent = 100 * count / std::max<std::uint64_t>(1, frames_);
    const std::string text = "movie: frame " + std::to_string(count) + " of " +
                             std::to_string(frames_) + ", " + std::to_string(percent) + " %";
    if (terminal_.interactive()) return terminal_.status(text);
    if (percent / 25 == quarter_) return;
    quarter_ = percent / 25;
    terminal_.line(text);
  }

 private:
  run::Terminal& terminal_;
  std::uint64_t frames_, quarter_ = 0;
};

report::MovieOptions options_of(const MovieCommand& command) {
  report::MovieOptions options;
  options.run = command.run;
  options.generation = command.generation;
  options.population = command.population;
  options.overrides = command.overrides;
  options.plugin_directories = command.plugin_path;
  options.grid = command.grid;
  options.whole_world = command.view == "world";
  options.width = command.width / 2 * 2;
  options.every = command.every;
  return options;
}

fs::path output_of(const MovieCommand& command) {
  if (command.out) {
    (void)report::movie_format(*command.out);
    refuse_file_of_run("--out", *command.out, command.run);
    run::check_output(*command.out);
    std::error_code error;
    if (fs::exists(*command.out, error) && !fs::is_regular_file(*command.out, error))
      throw run::UsageError("--out: " + command.out->string() + " is no regular file");
    return *command.out;
  }
  if (report::is_recording(command.run))
    throw run::UsageError(command.run.string() + " is a recording: --out must name the movie");
  const std::uint64_t generation =
      command.generation ? *command.generation : run::last_generation(command.run);
  const fs::path champion = run::champion_path(command.run, generation, command.population);
  const fs::path directory = command.run / "figures";
  std::error_code error;
  if (!fs::is_directory(directory, error)) run::check_output(directory);
  return directory / ("movie-" + champion.stem().string() + ".mp4");
}

}  // namespace

int execute(const MovieCommand& command, run::Terminal& terminal) {
  const run::SignalGuard signals;
  const report::MovieOptions options = options_of(command);
  const fs::path file = output_of(command);
  try {
    terminal.status("movie: living the life once to find the frames");
    const report::Screenplay play = report::plan_movie(options, signals.token());
    for (const std::string& warning : play.warnings) terminal.line("warning: " + warning);
    std::error_code error;
    if (!command.out) fs::create_directory(file.parent_path(), error);
    if (error) throw run::WriteError(file.parent_path(), error.value());
    report::Encoder encoder({.file = file,
                             .width = options.width,
                             .height = report::movie_height(options.width),
                             .fps = command.fps,
                             .stop = signals.token()});
    FrameProgress progress(terminal, play.frames);
    report::shoot_movie(options, play, signals.token(),
                        [&](std::string_view pixels, std::uint64_t frame) {
                          encoder.add(pixels);
                          progress.done(frame + 1);
                        });
    encoder.finish();
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f", static_cast<double>(play.frames) / command.fps);
    print(file.string() + ": " + plugins::plural(play.frames, "frame") + ", " + seconds + " s\n");
  } catch (const report::Cancelled&) {
    terminal.status("");
    terminal.line("somas-host: cancelled; there is no movie");
    if (run::SignalGuard::received() == SIGHUP) return exit_hung_up;
    return run::SignalGuard::received() == SIGTERM ? exit_terminated : exit_interrupted;
  } catch (const report::NotReproduced& error) {
    terminal.status("");
    terminal.line(std::string("somas-host: ") + error.what());
    return exit_not_reproduced;
  } catch (...) {
    terminal.status("");
    throw;
  }
  return exit_ok;
}

}  // namespace somas::host
