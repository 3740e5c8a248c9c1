#include "core/report/movie.hpp"

#include <algorithm>
#include <cmath>

#include "core/plugins/suggest.hpp"
#include "core/report/chart.hpp"
#include "core/report/render.hpp"

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

/// Draws the frames of one movie.
class FramePainter {
 public:
  FramePainter(const MovieOptions& options, const Screenplay& play)
      : play_(play),
        width_(options.width),
        height_(movie_height(options.width)),
        font_(std::max(9.0, width_ / 60)) {}

  [[nodiscard]] std::string_view paint(const Scene& scene) {
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

 private:
  void paint_column(const Scene& scene, const Rect& column) const {
    double y = column.y + paint_words(scene, column) + 0.5 * font_;
    y += Legend(legend(scene), font_).paint(*canvas_, column.x, y, column.width) + font_;
    paint_curves(scene, {column.x, y, column.width, column.bottom() - y});
  }

  double paint_words(const Scene& scene, const Rect& column) const {
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

  [[nodiscard]] std::vector<LegendEntry> legend(const Scene& scene) const {
    using Swatch = LegendEntry::Swatch;
    std::vector<LegendEntry> entries;
    for (std::size_t s = 0; s < scene.counts.size(); ++s)
      entries.push_back({.colour = colour_of_state(s),
                         .words = play_.setting.states[s] + " " + std::to_string(scene.counts[s])});
    entries.push_back(
        {.swatch = Swatch::rim, .words = "dividing " + std::to_string(scene.dividing())});
    for (std::size_t t = 0; t < scene.tables.size(); ++t)
      entries.push_back(
          {.swatch = Swatch::dot, .colour = colour_of_table(t), .words = play_.setting.tables[t]});
    for (const Zones::Zone& zone : play_.zones.zones())
      if (!zone.everywhere)
        entries.push_back({.swatch = Swatch::hatch, .words = "zone of " + zone.resource});
    return entries;
  }

  // Cells by state over the whole life, and where we are.
  void paint_curves(const Scene& scene, const Rect& area) const {
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

  const Screenplay& play_;
  double width_, height_, font_;
  std::optional<Canvas> canvas_;
};

SceneWants wants_of(const MovieOptions& options) { return {.grid = options.grid}; }

}  // namespace

std::uint32_t movie_height(std::uint32_t width) { return width * 9 / 16 / 2 * 2; }

Screenplay plan_movie(const MovieOptions& options, evaluation::StopToken stop) {
  Screenplay play;
  Extent extent;
  bool begun = false;
  run::ReplayOptions replay = replay_options(options);
  replay.prelude = [&](const run::Champion& champion) {
    play.history = LifeHistory(champion.own_seat);
  };
  replay.observer = [&](const model::Simulation& world) {
    if (stop.stop_requested()) throw Cancelled{};
    if (!begun) play.setting = setting_of(world, wants_of(options));
    begun = true;
    const Scene scene = scene_of(world, play.setting, wants_of(options));
    for (const SceneCell& cell : scene.cells) extent.add(cell);
    play.levels.add(scene);
    play.zones.observe(world);
    play.history.observe(world);
  };
  const run::ReplayReport replayed = live_again(replay);
  play.subject = subject_of(options.run, replayed, options.overrides);
  play.warnings = replayed.warnings;
  play.view = view_of(extent, play.setting.radius, options.whole_world);
  const std::uint64_t steps = play.history.steps();
  play.every = options.every != 0 ? options.every : (steps + most_frames - 1) / most_frames;
  play.frames = (steps + play.every - 1) / play.every;
  return play;
}

void shoot_movie(const MovieOptions& options, const Screenplay& play, evaluation::StopToken stop,
                 const FrameSink& sink) {
  FramePainter painter(options, play);
  std::uint64_t frame = 0;
  run::ReplayOptions replay = replay_options(options);
  replay.observer = [&](const model::Simulation& world) {
    if (stop.stop_requested()) throw Cancelled{};
    const std::uint64_t step = world.state().step - 1;
    if (step % play.every != 0) return;
    sink(painter.paint(scene_of(world, play.setting, wants_of(options))), frame++);
  };
  (void)live_again(replay);
}

}  // namespace somas::report
