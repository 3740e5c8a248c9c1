// A life as moving pictures: the world on the left, on the right who is there and how their numbers
// went.
//
// The champion lives twice (a recording is read twice). The first life finds what the frames need
// in advance: how many there are, which part of the world holds the organism, the ends of the
// scales of colour; and that the record is reproduced. The second is drawn, frame by frame; nothing
// is kept.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/evaluation/stop.hpp"
#include "core/report/encoder.hpp"
#include "core/report/figure.hpp"
#include "core/report/life_history.hpp"
#include "core/report/scene_painter.hpp"

namespace somas::report {

struct MovieOptions {
  std::filesystem::path run;                     ///< or a recording
  std::optional<std::uint64_t> generation = {};  ///< default: the last
  std::uint32_t population = 1;                  ///< 2 in mode coevolution only
  std::vector<std::string> overrides = {};       ///< a what-if, not checked against the record
  std::vector<std::filesystem::path> plugin_directories = {};
  std::string grid = {};  ///< "instance.name"; empty: the first; "none"
  bool whole_world = false;
  std::uint32_t width = 960;  ///< pixels, even; the height is 9/16 of it, even
  std::uint64_t every = 0;    ///< steps from frame to frame; 0: at most 600 frames
};

/// What the first life finds.
struct Screenplay {
  Subject subject = {};
  Setting setting;
  Zones zones;
  Levels levels;
  LifeHistory history;
  Extent extent;
  View view;
  std::uint64_t every = 1;
  std::uint64_t frames = 0;
  std::vector<std::string> warnings;

  /// Call after every step of the first life, and `settle` at its end.
  void observe(const model::Simulation& simulation, const MovieOptions& options);
  void settle(const MovieOptions& options);
  /// In the second life: whether the world after a step makes a frame.
  [[nodiscard]] bool shows(std::uint64_t step) const { return step % every == 0; }

  void look_at(const Scene& scene);
};

/// Draws the frames of one movie.
class FramePainter {
 public:
  /// `screenplay` must outlive the painter.
  FramePainter(const MovieOptions& options, const Screenplay& screenplay);

  /// The pixels (blue, green, red, nothing; row by row), valid until the next frame.
  [[nodiscard]] std::string_view paint(const model::Simulation& simulation);
  [[nodiscard]] std::string_view paint(const Scene& scene);

 private:
  void paint_column(const Scene& scene, const Rect& column) const;
  double paint_words(const Scene& scene, const Rect& column) const;
  [[nodiscard]] std::vector<LegendEntry> legend(const Scene& scene) const;
  void paint_curves(const Scene& scene, const Rect& area) const;

  const Screenplay& play_;
  SceneWants wants_;
  double width_, height_, font_;
  std::optional<Canvas> canvas_;
};

/// The first life. Throws Cancelled, NotReproduced, and what run::replay and recording::read throw;
/// run::UsageError for steps a frame that a recording does not have.
[[nodiscard]] Screenplay plan_movie(const MovieOptions& options, evaluation::StopToken stop);

/// Gets the pixels of a frame (blue, green, red, nothing; row by row) and its number, from 0.
using FrameSink = std::function<void(std::string_view pixels, std::uint64_t frame)>;

/// The second life. Throws what plan_movie and the sink throw.
void shoot_movie(const MovieOptions& options, const Screenplay& screenplay,
                 evaluation::StopToken stop, const FrameSink& sink);

[[nodiscard]] std::uint32_t movie_height(std::uint32_t width);

}  // namespace somas::report
