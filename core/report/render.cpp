#include "core/report/render.hpp"

#include <algorithm>
#include <array>

#include "core/plugins/suggest.hpp"
#include "core/recording/file.hpp"
#include "core/report/evolution_figure.hpp"
#include "core/report/life_figures.hpp"
#include "core/report/lineage_figure.hpp"
#include "core/report/recorded_life.hpp"
#include "core/report/run_tables.hpp"
#include "core/report/timelapse.hpp"
#include "core/run/errors.hpp"
#include "core/run/run_directory.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;

const std::array<std::string, 8> names = {"timelapse",  "energy", "morphogens", "grid",
                                          "population", "phases", "evolution",  "lineage"};

bool has_panels(What what) {
  return what == What::timelapse || what == What::energy || what == What::morphogens ||
         what == What::grid;
}

bool is_of_a_life(What what) { return what != What::evolution && what != What::lineage; }

// A recording is of one life, which cannot be changed.
void check_recording(const RenderOptions& o) {
  const auto refuse = [&](const std::string& option, bool given) {
    if (given)
      throw run::UsageError(option + " needs a run directory; " + o.runs.front().string() +
                            " is a recording");
  };
  refuse("--what " + name_of(o.what), !is_of_a_life(o.what));
  refuse("--generation", o.generation.has_value());
  refuse("--population", o.population != 1);
  refuse("--set", !o.overrides.empty());
}

// An option that would change nothing is a misunderstanding.
void check_options(const RenderOptions& o) {
  const auto refuse = [&](const std::string& option) {
    throw run::UsageError(option + " says nothing about --what " + name_of(o.what));
  };
  if (o.runs.empty()) throw run::UsageError("there is no run to draw");
  if (o.runs.size() > 1 && o.what != What::evolution)
    throw run::UsageError("--what " + name_of(o.what) +
                          " is of one run; --what evolution takes several as replicates");
  if (!has_panels(o.what)) {
    if (!o.steps.empty()) refuse("--steps");
    if (o.columns != 0) refuse("--columns");
    if (o.whole_world) refuse("--view");
  }
  if (!o.grid.empty() && o.what != What::timelapse && o.what != What::grid) refuse("--grid");
  if (!o.overrides.empty() && !is_of_a_life(o.what)) refuse("--set");
  if (o.what == What::evolution && o.generation) refuse("--generation");
}

run::ReplayOptions replay_options(const RenderOptions& o) {
  run::ReplayOptions replay;
  replay.run = o.runs.front();
  replay.generation = o.generation;
  replay.population = o.population;
  replay.overrides = o.overrides;
  replay.plugin_directories = o.plugin_directories;
  return replay;
}

PanelKind panel_kind(What what) {
  if (what == What::energy) return PanelKind::energy;
  if (what == What::morphogens) return PanelKind::morphogens;
  return what == What::grid ? PanelKind::grid : PanelKind::timelapse;
}

// How long a changed life will be, nobody knows before it is over.
std::uint64_t length_of_changed_life(const RenderOptions& options) {
  return live_again(replay_options(options)).replayed.hashes.size();
}

Rendered render_panels(const RenderOptions& o) {
  TimelapseOptions panels{.kind = panel_kind(o.what),
                          .steps = o.steps,
                          .grid = o.grid,
                          .whole_world = o.whole_world,
                          .columns = o.columns};
  std::optional<Timelapse> timelapse;
  timelapse.emplace(panels, o.size);  // refuses before a life is simulated
  std::uint64_t life = 0;
  if (o.steps.empty() && !o.overrides.empty()) life = length_of_changed_life(o);
  run::ReplayOptions replay = replay_options(o);
  replay.prelude = [&](const run::Champion& champion) {
    panels.organism = champion.own_seat;
    timelapse.emplace(panels, o.size);
    // The last step shows nobody.
    const std::uint64_t recorded = champion.life.hashes.size();
    timelapse->expect(std::max<std::uint64_t>(1, life != 0 ? life : recorded) - 1);
  };
  replay.observer = [&](const model::Simulation& world) { timelapse->observe(world); };
  const run::ReplayReport replayed = live_again(replay);
  return {timelapse->render(subject_of(o.runs.front(), replayed, o.overrides)), replayed.warnings};
}

// Steps that somebody chose must have frames.
void check_steps(const std::vector<std::uint64_t>& steps, const RecordedLife& life) {
  const std::vector<std::uint64_t>& frames = life.frames;
  for (const std::uint64_t step : steps) {
    const auto after = std::lower_bound(frames.begin(), frames.end(), step);
    if (after != frames.end() && *after == step) continue;
    std::string nearest;
    if (after != frames.begin()) nearest = std::to_string(*std::prev(after));
    if (after != frames.end()) nearest += (nearest.empty() ? "" : " and ") + std::to_string(*after);
    throw run::UsageError("--steps: the recording has no frame of step " + std::to_string(step) +
                          "; the nearest: " + nearest);
  }
}

Rendered render_recorded_panels(const RenderOptions& o) {
  const RecordedLife life = look_into(o.runs.front());
  check_steps(o.steps, life);
  Timelapse timelapse({.kind = panel_kind(o.what),
                       .steps = o.steps,
                       .grid = o.grid,
                       .whole_world = o.whole_world,
                       .columns = o.columns,
                       .organism = life.header.organisms.at(life.header.own).seat},
                      o.size);
  timelapse.expect(std::max<std::uint64_t>(1, life.ending.steps) - 1,
                   life.fields.empty() ? life.frames : life.fields);
  each_frame(o.runs.front(), [&](const recording::Header& header, const recording::Frame& frame) {
    timelapse.observe(header, frame);
  });
  return {timelapse.render(subject_of(life)), {}};
}

std::string figure_of(What what, const LifeHistory& history, const Subject& subject,
                      const FigureSize& size) {
  return what == What::population ? population_figure(history, subject, size)
                                  : phases_figure(history, subject, size);
}

Rendered render_recorded_life(const RenderOptions& o) {
  LifeHistory history;
  recording::read(o.runs.front(), history);
  return {figure_of(o.what, history, subject_of(look_into(o.runs.front())), o.size), {}};
}

Rendered render_life(const RenderOptions& o) {
  LifeHistory history;
  run::ReplayOptions replay = replay_options(o);
  replay.prelude = [&](const run::Champion& champion) { history = LifeHistory(champion.own_seat); };
  replay.observer = [&](const model::Simulation& world) { history.observe(world); };
  const run::ReplayReport replayed = live_again(replay);
  const Subject subject = subject_of(o.runs.front(), replayed, o.overrides);
  return {figure_of(o.what, history, subject, o.size), replayed.warnings};
}

}  // namespace

What what_named(const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<What>(i);
  throw run::UsageError("--what: there is no figure '" + name +
                        "'; figures: " + plugins::join(names) + plugins::did_you_mean(name, names));
}

std::string name_of(What what) { return names[static_cast<std::size_t>(what)]; }

run::ReplayReport live_again(run::ReplayOptions options) {
  run::ReplayReport replayed = run::replay(options);
  if (replayed.matches()) return replayed;
  throw NotReproduced("the champion of generation " + std::to_string(replayed.recorded.generation) +
                      " does not live its recorded life again: " + replayed.differences.front() +
                      (replayed.warnings.empty() ? "" : "; " + replayed.warnings.front()));
}

Rendered render(const RenderOptions& options) {
  check_options(options);
  if (is_recording(options.runs.front())) {
    check_recording(options);
    return has_panels(options.what) ? render_recorded_panels(options)
                                    : render_recorded_life(options);
  }
  if (has_panels(options.what)) return render_panels(options);
  if (is_of_a_life(options.what)) return render_life(options);
  Rendered rendered;
  rendered.bytes =
      options.what == What::evolution
          ? evolution_figure(options.runs, options.population, options.size, rendered.warnings)
          : lineage_figure(options.runs.front(), options.generation, options.population,
                           options.size);
  return rendered;
}

fs::path default_output(const RenderOptions& options) {
  const fs::path& run = options.runs.front();
  if (is_recording(run))
    throw run::UsageError(run.string() + " is a recording: --out must name the figure");
  const char* const extensions[] = {".svg", ".pdf", ".png"};
  std::string name = name_of(options.what);
  if (options.what == What::evolution) {
    if (!is_campaign(run)) (void)runs_in(options.runs);
  } else {
    const std::uint64_t generation =
        options.generation ? *options.generation : run::last_generation(run);
    name += "-" + run::champion_path(run, generation, options.population).stem().string();
  }
  return run / "figures" / (name + extensions[static_cast<std::size_t>(options.size.format)]);
}

}  // namespace somas::report
