// The only unit that includes CLI11, which takes long to compile.
#include "core/host/command_line.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <sstream>

#include <CLI/CLI.hpp>

#include "core/experiment/sweep.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/build_info.hpp"
#include "core/run/errors.hpp"

namespace somas::host {
namespace {

const std::vector<std::string> command_names = {"run",  "resume", "validate", "plugins", "describe",
                                                "new",  "check",  "schema",   "replay",  "compete",
                                                "dump", "render", "movie",    "export"};

bool is_command(const std::string& word) {
  return std::find(command_names.begin(), command_names.end(), word) != command_names.end();
}

bool is_general_option(const std::string& word) {
  return word == "--help" || word == "-h" || word == "--version";
}

// A word that was meant as a command should not be reported as a missing file.
void refuse_misspelt_command(const std::string& word) {
  if (word.starts_with('-') || word.find_first_of("./") != std::string::npos) return;
  if (std::filesystem::exists(word)) return;
  throw run::UsageError("\"" + word + "\" is neither a command nor a file; commands: " +
                        plugins::join(command_names) + plugins::did_you_mean(word, command_names));
}

/// "somas-host FILE" means "somas-host run FILE".
std::vector<std::string> with_command(std::vector<std::string> arguments) {
  if (arguments.empty() || is_command(arguments.front()) || is_general_option(arguments.front()))
    return arguments;
  refuse_misspelt_command(arguments.front());
  arguments.insert(arguments.begin(), "run");
  return arguments;
}

/// The options of all commands; lives as long as the parser.
struct Options {
  RunCommand run;
  ResumeCommand resume;
  DumpCommand dump;
  ValidateCommand validate;
  PluginsCommand plugins;
  DescribeCommand describe;
  NewCommand create;
  CheckCommand check;
  SchemaCommand schema;
  ReplayCommand replay;
  CompeteCommand compete;
  ExportCommand exported;
  std::string record;  ///< --record of run
  RenderCommand render;
  MovieCommand movie;
  std::string opponents;  ///< --against
  std::string save_state;
  CLI::Option* save_option = nullptr;
  std::optional<std::uint64_t> seed, generations, replicates;
};

/// Checks digits before they become a number, and complains in the user's own words.
std::function<std::string(const std::string&)> whole_number(std::uint64_t least,
                                                            std::uint64_t most) {
  return [least, most](const std::string& text) -> std::string {
    std::uint64_t value = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    if (parsed.ec == std::errc{} && parsed.ptr == end && value >= least && value <= most) return {};
    return "'" + text + "' is not a whole number from " + std::to_string(least) + " to " +
           std::to_string(most);
  };
}

void add_overrides(CLI::App& app, std::vector<std::string>& overrides) {
  app.add_option("--set", overrides, "Replace a value of the experiment; may be repeated")
      ->type_name("PATH.TO.KEY=VALUE")
      ->allow_extra_args(false);
}

void add_plugin_path(CLI::App& app, std::vector<std::filesystem::path>& directories) {
  app.add_option("--plugin-path", directories, "A directory to look for plugins; may be repeated")
      ->type_name("DIR")
      ->allow_extra_args(false);
}

void add_file(CLI::App& app, std::filesystem::path& file) {
  app.add_option("FILE", file, "The experiment (YAML)")->type_name("")->required();
}

void add_world_threads(CLI::App& app, unsigned& threads) {
  app.add_option("--world-threads", threads,
                 "Threads that share the steps of each simulation; worth it in worlds of many "
                 "thousands of cells. Default 1. Never changes results")
      ->type_name("N")
      ->check(whole_number(1, 256));
}

/// Returns the option --backend.
CLI::Option* add_backend(CLI::App& app, BackendChoice& choice) {
  CLI::Option* backend =
      app.add_option("--backend", choice.backend,
                     "Who evaluates: processes (default), which a plugin that crashes cannot take "
                     "along; or threads of this one. Never changes results")
          ->type_name("KIND")
          ->check(CLI::IsMember({"processes", "threads"}).description(""));
  CLI::Option* workers =
      app.add_option(
             "--workers", choice.workers,
             "How many of them; default: with the threads of their worlds one per processor")
          ->type_name("N")
          ->check(whole_number(1, 4096));
  app.add_option("--threads", choice.threads, "The same as --backend threads --workers N")
      ->type_name("N")
      ->check(whole_number(1, 4096))
      ->excludes(backend)
      ->excludes(workers);
  add_world_threads(app, choice.world_threads);
  app.add_option("--evaluator-memory", choice.memory_mib,
                 "Most memory of an evaluator process, in MiB; default: no limit")
      ->type_name("MIB")
      ->check(whole_number(64, 1u << 30));
  app.add_option("--watchdog", choice.watchdog_seconds,
                 "Seconds without a step of the simulation after which an evaluator process is "
                 "replaced; default 600")
      ->type_name("S")
      ->check(whole_number(1, 1'000'000));
  return backend;
}

// Which runs make a campaign.
CLI::Option* add_design(CLI::App& app, std::vector<std::string>& sweeps, Options& options) {
  app.add_option("--replicates", options.replicates,
                 "Runs of each condition, with seeds of their own (the same as --set replicates=N)")
      ->type_name("N")
      ->check(whole_number(1, experiment::most_runs));
  return app
      .add_option("--sweep", sweeps,
                  "A factor and its levels: a run, or several, for each; may be repeated, for all "
                  "combinations")
      ->type_name("PATH.TO.KEY=VALUE,VALUE,...")
      ->allow_extra_args(false);
}

void add_at_once(CLI::App& app, std::uint64_t& at_once) {
  app.add_option("--runs-at-once", at_once,
                 "Of a campaign: runs that share the evaluators at a time; default: as many as "
                 "keep them busy")
      ->type_name("N")
      ->check(whole_number(1, 1000));
}

void add_run(CLI::App& parser, Options& options) {
  RunCommand& run = options.run;
  CLI::App& app = *parser.add_subcommand("run", "Run an experiment; the word may be left out");
  add_file(app, run.file);
  add_overrides(app, run.overrides);
  app.add_option("--seed", options.seed, "Seed of the run (the same as --set seed=N)")
      ->type_name("N")
      ->check(whole_number(0, INT64_MAX));
  app.add_option("--generations", options.generations,
                 "Number of generations (the same as --set evolution.generations=N)")
      ->type_name("N")
      ->check(whole_number(1, 1'000'000'000));
  app.add_option("--out", run.out, "Run directory, absent or empty; default runs/NAME-seedSEED")
      ->type_name("DIR");
  app.add_option("--genome", run.genomes,
                 "A saved genome (a champion's file) that joins the first generation; may be "
                 "repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("--record", options.record,
                 "Whose lives are recorded: champions, all or none (the same as --set "
                 "record.what=...)")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"champions", "all", "none"}).description(""));
  CLI::Option* sweep = add_design(app, run.sweeps, options);
  CLI::Option* dry_run =
      app.add_flag("--dry-run", run.dry_run, "Check all, say what it would cost, and run nothing");
  app.add_flag("--single", run.single, "One run, whatever replicates and sweep the file has")
      ->excludes(sweep)
      ->excludes(dry_run)
      ->excludes(app.get_option("--replicates"));
  add_at_once(app, run.at_once);
  CLI::Option* backend = add_backend(app, run.backend);
  app.add_flag(
         "--profile", run.profile,
         "Measure where the time of the simulations goes, by phase and plugin: a table at the "
         "end, and profile.json in the run directory. Evaluates in threads of this process")
      ->excludes(backend);
  app.add_flag("--quiet,-q", run.quiet, "No progress; warnings and errors only");
  add_plugin_path(app, run.plugin_path);
}

void add_resume(CLI::App& parser, Options& options) {
  ResumeCommand& resume = options.resume;
  CLI::App& app = *parser.add_subcommand(
      "resume",
      "Go on with a run or a campaign, wherever it ended; the results are those of one that was "
      "never stopped");
  app.add_option("RUN", resume.run, "A run directory, or a campaign's")->type_name("")->required();
  app.add_option("--generations", options.generations,
                 "Number of generations in all: extends a run that is complete")
      ->type_name("N")
      ->check(whole_number(1, 1'000'000'000));
  app.add_flag("--accept-changes", resume.accept_changes,
               "Go on although plugins, experiment or host have changed; the manifest records it");
  app.add_option("--replicates", options.replicates, "Of a campaign: runs of each condition in all")
      ->type_name("N")
      ->check(whole_number(1, experiment::most_runs));
  app.add_option("--sweep", resume.sweeps,
                 "Of a campaign: all levels of a factor, those that are there and new ones")
      ->type_name("PATH.TO.KEY=VALUE,VALUE,...")
      ->allow_extra_args(false);
  add_at_once(app, resume.at_once);
  add_backend(app, resume.backend);
  app.add_flag("--quiet,-q", resume.quiet, "No progress; warnings and errors only");
  add_plugin_path(app, resume.plugin_path);
}

void add_dump(CLI::App& parser, Options& options) {
  CLI::App& app = *parser.add_subcommand(
      "dump", "Print all results of a run's store as text, in an order that is always the same");
  app.add_option("RUN", options.dump.run, "A run directory")->type_name("")->required();
  app.add_flag("--hash", options.dump.hash, "Print a hash of them (XXH3-128) instead");
}

void add_validate(CLI::App& parser, Options& options) {
  CLI::App& app = *parser.add_subcommand("validate", "Check an experiment without running it");
  add_file(app, options.validate.file);
  add_overrides(app, options.validate.overrides);
  add_design(app, options.validate.sweeps, options);
  app.add_flag("--resolved", options.validate.show_resolved,
               "Print the experiment with every key and its value");
  add_plugin_path(app, options.validate.plugin_path);
}

void add_plugins(CLI::App& parser, Options& options) {
  CLI::App& app = *parser.add_subcommand(
      "plugins", "List the plugins found, the files rejected and why, and the search path");
  add_plugin_path(app, options.plugins.plugin_path);
}

void add_describe(CLI::App& parser, Options& options) {
  DescribeCommand& describe = options.describe;
  CLI::App& app = *parser.add_subcommand("describe", "Show a plugin class and its parameters");
  app.add_option("ID", describe.id, "The class, as in an experiment file")
      ->type_name("")
      ->required();
  app.add_option("--format", describe.format, "text, yaml (to paste) or markdown")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"text", "yaml", "markdown"}).description(""));
  add_plugin_path(app, describe.plugin_path);
}

void add_new(CLI::App& parser, Options& options) {
  NewCommand& create = options.create;
  CLI::App& app = *parser.add_subcommand(
      "new", "Write a project for a plugin of your own: source, build, test, experiment");
  app.add_option("KIND", create.kind, "environment, controller, specialization or fitness")
      ->type_name("")
      ->required()
      ->check(CLI::IsMember({"environment", "controller", "specialization", "fitness"})
                  .description(""));
  app.add_option("NAME", create.name, "The plugin's id, in lower_snake_case")
      ->type_name("")
      ->required();
  app.add_option("DIR", create.directory, "Where to write it; absent or empty")
      ->type_name("")
      ->required();
}

void add_check(CLI::App& parser, CheckCommand& check) {
  CLI::App& app = *parser.add_subcommand(
      "check", "Examine a plugin file, in a process of its own: does it keep the contract?");
  app.add_option("FILE", check.file, "The plugin (NAME.somas.so)")->type_name("")->required();
  app.add_option("--set", check.overrides,
                 "A parameter of a class, in place of its default; may be repeated")
      ->type_name("ID.PARAMETER=VALUE")
      ->allow_extra_args(false);
  app.add_option("--seconds", check.seconds, "Longest that one call may take; default 20")
      ->type_name("S")
      ->check(whole_number(1, 1'000'000));
  app.add_option("--memory", check.memory_mib, "Most memory of the process, in MiB; default 2048")
      ->type_name("MIB")
      ->check(whole_number(64, 1u << 30));
}

void add_schema(CLI::App& parser, Options& options) {
  CLI::App& app = *parser.add_subcommand(
      "schema", "Print a JSON Schema of experiment files and all plugins found, for editors");
  app.add_option("--out", options.schema.out, "Write it to this file")->type_name("FILE");
  add_plugin_path(app, options.schema.plugin_path);
}

void add_moments(CLI::App& app, Options& options) {
  ReplayCommand& replay = options.replay;
  app.add_option("--from-step", replay.from_step,
                 "Begin before this step; --set and --wound hold from there on")
      ->type_name("N")
      ->check(whole_number(0, UINT64_MAX));
  app.add_option("--from-state", replay.from_state, "Begin with a state that --save-state wrote")
      ->type_name("FILE");
  app.add_option("--wound", replay.wounds,
                 "Remove the cells whose centre lies in a disc, at the step where the replay "
                 "begins; may be repeated")
      ->type_name("X,Y,RADIUS")
      ->allow_extra_args(false);
  options.save_option = app.add_option("--save-state", options.save_state,
                                       "Write the world before the step of --at-step; default "
                                       "RUN/states/gen-NNNN-step-NNNNNN.state")
                            ->type_name("[FILE]")
                            ->expected(0, 1);
  app.add_option("--at-step", replay.at_step, "The step of --save-state")
      ->type_name("N")
      ->check(whole_number(1, UINT64_MAX));
}

void add_picture(CLI::App& app, PictureCommand& picture) {
  CLI::Option* file =
      app.add_option("--picture", picture.file,
                     "Draw the world after the steps of --steps; FILE ends in .svg, .pdf or .png")
          ->type_name("FILE");
  CLI::Option* steps =
      app.add_option("--steps", picture.steps,
                     "A step to draw, or several: 100,300,500; may be repeated; a panel each")
          ->type_name("N")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->check(whole_number(0, INT64_MAX));
  file->needs(steps);
  steps->needs(file);
  app.add_option("--grid", picture.grid,
                 "The grid below the cells, as INSTANCE.NAME, or none; default: the first")
      ->type_name("GRID")
      ->needs(file);
  app.add_option("--view", picture.view, "organism (default) or world")
      ->type_name("VIEW")
      ->check(CLI::IsMember({"organism", "world"}).description(""))
      ->needs(file);
  app.add_option("--width", picture.width, "Of the picture, in pixels; default 1600")
      ->type_name("N")
      ->check(whole_number(100, 20000))
      ->needs(file);
}

void add_recordings(CLI::App& app, ReplayCommand& replay) {
  PageCommand& page = replay.page;
  app.add_option("--record", replay.record, "Write the life as a recording (HDF5)")
      ->type_name("FILE");
  CLI::Option* file = app.add_option("--html", page.file,
                                     "Write the life as a page to play, scrub and inspect in a "
                                     "browser: one file, no network")
                          ->type_name("FILE");
  app.add_option("--every", replay.every,
                 "Of page and recording: a frame every N steps; default 1, of the recording as the "
                 "run's record.every")
      ->type_name("N")
      ->check(whole_number(1, INT64_MAX));
  app.add_option(
         "--fields-every", replay.fields_every,
         "Of page and recording: grids and morphogens at frames of every N-th step; default "
         "1, of the recording as the run's record.fields_every")
      ->type_name("N")
      ->check(whole_number(1, INT64_MAX));
  app.add_option("--compare", page.compare,
                 "Of the page: a second life beside it, the champion of another run or generation "
                 "(default RUN), or a recording")
      ->type_name("RUN[:GENERATION]")
      ->needs(file);
  app.add_option("--compare-set", page.compare_overrides,
                 "Of the page: the second life with this value replaced; may be repeated. Without "
                 "--compare: the same champion")
      ->type_name("PATH.TO.KEY=VALUE")
      ->allow_extra_args(false)
      ->needs(file);
}

void add_replay(CLI::App& parser, Options& options) {
  ReplayCommand& replay = options.replay;
  CLI::App& app = *parser.add_subcommand(
      "replay",
      "Simulate a champion again: it must reproduce its record, step by step. With --set: what "
      "would have happened if, unchecked");
  app.add_option("RUN", replay.run, "A run directory; for --html also a recording")
      ->type_name("")
      ->required();
  app.add_option("--generation", replay.generation, "Whose champion; default: the last")
      ->type_name("N")
      ->check(whole_number(0, UINT64_MAX));
  app.add_option("--population", replay.population,
                 "Whose champion in mode coevolution: 1 or 2; default 1")
      ->type_name("N")
      ->check(whole_number(1, 2));
  add_overrides(app, replay.overrides);
  app.add_flag("--anatomy", replay.anatomy,
               "Say who lies outside whom, against shuffled states, and what cells died of");
  app.add_option("--anatomy-csv", replay.anatomy_csv,
                 "Write cells, distances from the centroid, clusters, deaths of every step")
      ->type_name("FILE");
  app.add_option("--csv", replay.csv, "Write cells by state and the world's hash of every step")
      ->type_name("FILE");
  add_moments(app, options);
  add_picture(app, replay.picture);
  add_recordings(app, replay);
  add_world_threads(app, replay.world_threads);
  add_plugin_path(app, replay.plugin_path);
}

void add_compete(CLI::App& parser, Options& options) {
  CompeteCommand& compete = options.compete;
  CLI::App& app = *parser.add_subcommand(
      "compete", "Let saved genomes compete in one world, on seeds that no run has used");
  add_file(app, compete.file);
  app.add_option("--genome", compete.genomes,
                 "A competitor: a saved genome (a champion's file); may be repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("--against", options.opponents,
                 "random: one more competitor, of fresh random genes in each world")
      ->type_name("WHOM")
      ->check(CLI::IsMember({"random"}).description(""));
  app.add_option("--seeds", compete.seeds, "Worlds, each with a seed of its own; default 30")
      ->type_name("N")
      ->check(whole_number(1, 1000));
  app.add_option("--seed", options.seed,
                 "Seed that those of the worlds are drawn from (the same as --set seed=N)")
      ->type_name("N")
      ->check(whole_number(0, INT64_MAX));
  add_overrides(app, compete.overrides);
  app.add_option("--threads", compete.threads,
                 "Threads that simulate; default: one per processor. Never changes results")
      ->type_name("N")
      ->check(whole_number(1, 4096));
  app.add_option("--csv", compete.csv, "Write a line per organism and world")->type_name("FILE");
  add_plugin_path(app, compete.plugin_path);
}

std::function<std::string(const std::string&)> number_between(double least, double most) {
  return [least, most](const std::string& text) -> std::string {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    if (parsed.ec == std::errc{} && parsed.ptr == end && value >= least && value <= most) return {};
    return "'" + text + "' is not a number from " + std::to_string(static_cast<int>(least)) +
           " to " + std::to_string(static_cast<int>(most));
  };
}

// Whose life a figure or a movie shows.
template <class LifeCommand>
void add_life(CLI::App& app, LifeCommand& command) {
  app.add_option("--generation", command.generation, "Whose champion; default: the last")
      ->type_name("N")
      ->check(whole_number(0, UINT64_MAX));
  app.add_option("--population", command.population,
                 "Whose champion in mode coevolution: 1 or 2; default 1")
      ->type_name("N")
      ->check(whole_number(1, 2));
  add_overrides(app, command.overrides);
  app.add_option("--grid", command.grid,
                 "The grid of an environment, as INSTANCE.NAME, or none; default: the first")
      ->type_name("GRID");
  app.add_option("--view", command.view, "organism (default) or world")
      ->type_name("VIEW")
      ->check(CLI::IsMember({"organism", "world"}).description(""));
  add_plugin_path(app, command.plugin_path);
}

void add_render(CLI::App& parser, RenderCommand& render) {
  CLI::App& app = *parser.add_subcommand(
      "render", "Draw a figure for a paper: of a champion's life, lived again, or of a run");
  app.add_option("RUN", render.runs,
                 "A run directory; several, or a directory of runs or a campaign, for --what "
                 "evolution; or a recording")
      ->type_name("")
      ->required();
  app.add_option("--what", render.what,
                 "timelapse, energy, morphogens, grid, population, phases, evolution or lineage")
      ->type_name("FIGURE")
      ->required();
  app.add_option("--steps", render.steps,
                 "Steps to draw: 100,300,500 or FIRST:LAST:DISTANCE; default: evenly over the life")
      ->type_name("N")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--columns", render.columns, "Panels side by side; default: by the width")
      ->type_name("N")
      ->check(whole_number(1, 40));
  app.add_option("--format", render.format, "svg (default), pdf or png; or as FILE says")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"svg", "pdf", "png"}).description(""));
  app.add_option("--out", render.out,
                 "The file; default RUN/figures/FIGURE-gen-NNNN.FORMAT. It is replaced")
      ->type_name("FILE");
  app.add_option("--width", render.width,
                 "Of the figure in millimetres; default 178, two columns of a paper, or 85, one, "
                 "for population, evolution and lineage")
      ->type_name("MM")
      ->check(number_between(40, 1000));
  app.add_option("--dpi", render.dpi, "Pixels an inch of a PNG; default 300")
      ->type_name("N")
      ->check(number_between(50, 1200));
  add_life(app, render);
}

void add_movie(CLI::App& parser, MovieCommand& movie) {
  CLI::App& app = *parser.add_subcommand(
      "movie", "Film a champion's life, lived again, through ffmpeg (on the PATH)");
  app.add_option("RUN", movie.run, "A run directory, or a recording")->type_name("")->required();
  app.add_option("--out", movie.out,
                 "The file, .mp4 or .webm; default RUN/figures/movie-gen-NNNN.mp4. It is replaced")
      ->type_name("FILE");
  app.add_option("--fps", movie.fps, "Frames a second; default 25")
      ->type_name("N")
      ->check(number_between(1, 240));
  app.add_option("--every", movie.every, "Steps from frame to frame; default: at most 600 frames")
      ->type_name("N")
      ->check(whole_number(1, 1'000'000));
  app.add_option("--width", movie.width,
                 "Pixels; default 960. The height is nine sixteenths; both are made even")
      ->type_name("N")
      ->check(whole_number(320, 3840));
  add_life(app, movie);
}

// The short options come last, so that they win over --set.
void add_export(CLI::App& parser, Options& options) {
  ExportCommand& command = options.exported;
  CLI::App& app = *parser.add_subcommand("export", "Write a recording for other programs");
  app.add_option("FILE", command.file, "The recording (HDF5)")->type_name("")->required();
  app.add_option("--format", command.format,
                 "csv (tables), vtp (ParaView) or xyz (extended XYZ, for OVITO)")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"csv", "vtp", "xyz"}).description(""))
      ->required();
  app.add_option("--out", command.out, "A directory, absent or empty")
      ->type_name("DIR")
      ->required();
}

void add_short_overrides(const Options& options, std::vector<std::string>& overrides) {
  if (options.seed) overrides.push_back("seed=" + std::to_string(*options.seed));
  if (options.replicates) overrides.push_back("replicates=" + std::to_string(*options.replicates));
  if (!options.record.empty()) overrides.push_back("record.what=" + options.record);
  if (options.generations)
    overrides.push_back("evolution.generations=" + std::to_string(*options.generations));
}

Command chosen(const CLI::App& parser, Options& options) {
  if (parser.got_subcommand("run")) {
    add_short_overrides(options, options.run.overrides);
    return options.run;
  }
  if (parser.got_subcommand("resume")) {
    options.resume.generations = options.generations;
    options.resume.replicates = options.replicates;
    return options.resume;
  }
  if (parser.got_subcommand("dump")) return options.dump;
  if (parser.got_subcommand("compete")) {
    add_short_overrides(options, options.compete.overrides);
    options.compete.random = !options.opponents.empty();
    return options.compete;
  }
  if (parser.got_subcommand("render")) return options.render;
  if (parser.got_subcommand("movie")) return options.movie;
  if (parser.got_subcommand("validate")) {
    add_short_overrides(options, options.validate.overrides);
    return options.validate;
  }
  if (parser.got_subcommand("export")) return options.exported;
  if (parser.got_subcommand("plugins")) return options.plugins;
  if (parser.got_subcommand("describe")) return options.describe;
  if (parser.got_subcommand("new")) return options.create;
  if (parser.got_subcommand("check")) return options.check;
  if (parser.got_subcommand("schema")) return options.schema;
  options.replay.save = options.save_option->count() > 0;
  if (options.replay.save && !options.save_state.empty())
    options.replay.save_state = options.save_state;
  return options.replay;
}

}  // namespace

Command parse_command_line(const std::vector<std::string>& arguments) {
  Options options;
  options.run.command_line = arguments;
  options.run.command_line.insert(options.run.command_line.begin(), "somas-host");

  CLI::App parser("Evolves multicellular organisms as an experiment file says.", "somas-host");
  parser.require_subcommand(1);
  parser.set_version_flag("--version", "somas-host " + std::string(run::build_info().version));
  parser.footer(std::string("`somas-host FILE` is short for `somas-host run FILE`.\n\n") +
                exit_code_help);
  add_run(parser, options);
  add_resume(parser, options);
  add_validate(parser, options);
  add_plugins(parser, options);
  add_describe(parser, options);
  add_new(parser, options);
  add_check(parser, options.check);
  add_schema(parser, options);
  add_replay(parser, options);
  add_compete(parser, options);
  add_export(parser, options);
  add_dump(parser, options);
  add_render(parser, options.render);
  add_movie(parser, options.movie);

  try {
    // CLI11 takes its words from the back.
    std::vector<std::string> words = with_command(arguments);
    std::reverse(words.begin(), words.end());
    parser.parse(words);
  } catch (const CLI::ParseError& error) {
    // Help and version come this way, too.
    if (error.get_exit_code() != 0)
      throw run::UsageError(std::string(error.what()) + "; run with --help for more information");
    std::ostringstream text;
    parser.exit(error, text, text);
    print(text.str());
    return Done{exit_ok};
  }
  return chosen(parser, options);
}

}  // namespace somas::host
