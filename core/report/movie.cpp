#include "core/report/movie.hpp"

#include <algorithm>
#include <cmath>

#include "core/plugins/suggest.hpp"
#include "core/recording/file.hpp"
#include "core/report/chart.hpp"
#include "core/report/recorded_life.hpp"
#include "core/report/render.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

constexpr std::uint64_t most_frames = 600;  // unless the user says how many steps a frame is

run::ReplayOptions replay_options(const MovieOptions& o) {
  run::ReplayOptions replay;
  replay.run = o.run;
  replay.generation = o.generation;
  replay.population = o.population;
  replay.overrides = o.overrides;
  replay.plugin_directories = o.plugin_directories;
  return replay;
}

SceneWants wants_of(const MovieOptions& options) { return {.grid = options.grid}; }

// ---- of a recording -----------------------------------------------------------------------------

void check_recording(const MovieOptions& o, const RecordedLife& life) {
  const auto refuse = [&](const char* option, bool given) {
    if (given)
      throw run::UsageError(std::string(option) + " needs a run directory; " + o.run.string() +
                            " is a recording");
  };
  refuse("--generation", o.generation.has_value());
  refuse("--population", o.population != 1);
  refuse("--set", !o.overrides.empty());
  if (o.every % life.header.every != 0)
    throw run::UsageError("--every " + std::to_string(o.every) +
                          ": the recording has a frame every " +
                          plugins::plural(life.header.every, "step") + "; give a multiple of it");
}

/// Frames without fields show the last there were.
void each_scene(const MovieOptions& options, const Setting& setting, evaluation::StopToken stop,
                const std::function<void(const Scene&)>& visit) {
  std::vector<double> grid;
  const SceneWants wants = wants_of(options);
  each_frame(options.run, [&](const recording::Header& header, const recording::Frame& frame) {
    if (stop.stop_requested()) throw Cancelled{};
    Scene scene = scene_of(header, frame, setting, wants);
    if (frame.has_fields)
      grid = scene.grid;
    else
      scene.grid = grid;
    visit(scene);
  });
}

Screenplay plan_recorded(const MovieOptions& options, evaluation::StopToken stop) {
  const RecordedLife life = look_into(options.run);
  check_recording(options, life);
  Screenplay play;
  play.subject = subject_of(life);
  recording::read(options.run, play.history);
  SceneWants wants = wants_of(options);
  wants.organism = play.history.organism();
  play.setting = setting_of(life.header, wants);
  each_scene(options, play.setting, stop, [&](const Scene& scene) { play.look_at(scene); });
  each_frame(options.run, [&](const recording::Header& header, const recording::Frame& frame) {
    play.zones.observe(header, frame);
  });
  play.settle(options);
  // Frames are where the recording has them.
  const std::uint64_t least = life.header.every;
  play.every = (play.every + least - 1) / least * least;
  play.frames = static_cast<std::uint64_t>(std::count_if(
      life.frames.begin(), life.frames.end(), [&](auto step) { return play.shows(step); }));
  return play;
}

}  // namespace

FramePainter::FramePainter(const MovieOptions& options, const Screenplay& screenplay)
    : play_(screenplay),
      wants_(wants_of(options)),
      width_(options.width),
      height_(movie_height(options.width)),
      font_(std::max(9.0, width_ / 60)) {}

std::string_view FramePainter::paint(const model::Simulation& simulation) {
  return paint(scene_of(simulation, play_.setting, wants_));
}

std::string_view FramePainter::paint(const Scene& scene) {
  canvas_.emplace(PictureFormat::png, width_, height_);
  const double gap = 0.5 * font_, side = height_ - 2 * gap;
  const Rect square{gap, gap, side, side};
  ScenePainter painter(*canvas_, play_.setting, play_.zones.zones(), play_.levels, 0.1 * font_);
  painter.paint(scene, {}, square, play_.view);
  painter.scale_bar(font_);
  canvas_->frame(square, 1, frame_grey);
  const double left = square.right() + font_;
  paint_column(scene, {left, gap, width_ - left - gap, side});
  return canvas_->pixels();
}

void FramePainter::paint_column(const Scene& scene, const Rect& column) const {
  double y = column.y + paint_words(scene, column) + 0.5 * font_;
  y += Legend(legend(scene), font_).paint(*canvas_, column.x, y, column.width) + font_;
  paint_curves(scene, {column.x, y, column.width, column.bottom() - y});
}

double FramePainter::paint_words(const Scene& scene, const Rect& column) const {
  const Subject& s = play_.subject;
  std::vector<std::string> lines{
      s.experiment + ", generation " + std::to_string(s.generation),
      "run " + s.run + ", seed " + std::to_string(s.seed),
      "survival " + grouped(s.survival) + (s.censored ? " (alive at the end)" : "")};
  for (const std::string& change : s.changes) lines.push_back("what if " + change);
  canvas_->colour(black);
  canvas_->text(column.x, column.y + 1.6 * font_, 1.6 * font_, column.width,
                "step " + grouped(scene.step));
  double y = 2.2 * font_;
  for (const std::string& line : lines) {
    y += 1.4 * font_;
    canvas_->text(column.x, column.y + y, font_, column.width, line);
  }
  return y + 0.4 * font_;
}

std::vector<LegendEntry> FramePainter::legend(const Scene& scene) const {
  using Swatch = LegendEntry::Swatch;
  std::vector<LegendEntry> entries;
  for (std::size_t s = 0; s < scene.counts.size(); ++s)
    entries.push_back({.colour = colour_of_state(s),
                       .words = play_.setting.states[s] + " " + std::to_string(scene.counts[s])});
  entries.push_back({.swatch = Swatch::rim,
                     .colour = black,
                     .words = "dividing " + std::to_string(scene.dividing())});
  for (std::size_t o = 0; o < play_.setting.organisms.size(); ++o)
    entries.push_back({.swatch = Swatch::rim,
                       .colour = colour_of_organism(o),
                       .words = play_.setting.organisms[o]});
  for (std::size_t t = 0; t < scene.tables.size(); ++t)
    entries.push_back(
        {.swatch = Swatch::dot, .colour = colour_of_table(t), .words = play_.setting.tables[t]});
  for (const Zones::Zone& zone : play_.zones.zones())
    if (!zone.everywhere)
      entries.push_back({.swatch = Swatch::hatch, .words = "zone of " + zone.resource});
  return entries;
}

// Cells by state over the whole life, and where we are.
void FramePainter::paint_curves(const Scene& scene, const Rect& area) const {
  if (area.height < 6 * font_) return;
  const LifeHistory& history = play_.history;
  const std::vector<double> total = history.total();
  const double most = *std::max_element(total.begin(), total.end());
  const Axis x{history.step().front(), history.step().back(), "", true};
  const Axis y{0, round_end(most), "", true};
  const Chart chart(*canvas_, {area.x, area.y + font_, area.width, area.height - font_}, x, y, 0,
                    false);
  for (std::size_t s = 0; s < history.cells().values.size(); ++s)
    chart.line(history.step(), history.cells().values[s], colour_of_state(s), 0.12 * font_);
  chart.vertical(static_cast<double>(scene.step), black);
  canvas_->frame(chart.plot(), 1, frame_grey);
  canvas_->colour(black);
  canvas_->text(area.x, area.y + 0.9 * font_, 0.9 * font_, area.width,
                "cells (0 to " + number(y.high) + ") over the life");
}

void Screenplay::observe(const model::Simulation& simulation, const MovieOptions& options) {
  SceneWants wants = wants_of(options);
  wants.organism = history.organism();
  if (history.steps() == 0) setting = setting_of(simulation, wants);
  look_at(scene_of(simulation, setting, wants));
  zones.observe(simulation);
  history.observe(simulation);
}

void Screenplay::look_at(const Scene& scene) {
  for (const SceneCell& cell : scene.cells) extent.add(cell);
  levels.add(scene);
}

void Screenplay::settle(const MovieOptions& options) {
  view = view_of(extent, setting.radius, options.whole_world);
  const std::uint64_t steps = history.steps();
  every = options.every != 0 ? options.every : (steps + most_frames - 1) / most_frames;
  frames = (steps + every - 1) / every;
}

std::uint32_t movie_height(std::uint32_t width) { return width * 9 / 16 / 2 * 2; }

Screenplay plan_movie(const MovieOptions& options, evaluation::StopToken stop) {
  if (is_recording(options.run)) return plan_recorded(options, stop);
  Screenplay play;
  run::ReplayOptions replay = replay_options(options);
  replay.prelude = [&](const run::Champion& champion) {
    play.history = LifeHistory(champion.own_seat);
  };
  replay.observer = [&](const model::Simulation& world) {
    if (stop.stop_requested()) throw Cancelled{};
    play.observe(world, options);
  };
  const run::ReplayReport replayed = live_again(replay);
  play.subject = subject_of(options.run, replayed, options.overrides);
  play.warnings = replayed.warnings;
  play.settle(options);
  return play;
}

void shoot_movie(const MovieOptions& options, const Screenplay& play, evaluation::StopToken stop,
                 const FrameSink& sink) {
  FramePainter painter(options, play);
  std::uint64_t frame = 0;
  if (is_recording(options.run))
    return each_scene(options, play.setting, stop, [&](const Scene& scene) {
      if (play.shows(scene.step)) sink(painter.paint(scene), frame++);
    });
  run::ReplayOptions replay = replay_options(options);
  replay.observer = [&](const model::Simulation& world) {
    if (stop.stop_requested()) throw Cancelled{};
    if (play.shows(world.state().step - 1)) sink(painter.paint(world), frame++);
  };
  (void)live_again(replay);
}

}  // namespace somas::report
