// Panels of one life, to one scale: the organism over time, its energy, its morphogens.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/report/figure.hpp"
#include "core/report/scene_painter.hpp"

namespace somas::report {

/// What the panels show.
enum class PanelKind {
  timelapse,   ///< cells by state, a panel a step
  energy,      ///< the greener, the higher
  morphogens,  ///< as sensed by cells: all as inks, then each for itself, a row each
  grid,        ///< the same on their grid; or the content of a grid of an environment
};

struct TimelapseOptions {
  PanelKind kind = PanelKind::timelapse;
  std::vector<std::uint64_t> steps = {};  ///< from 0; empty: evenly over the life
  std::string grid = {};                  ///< "instance.name"; "none"; empty: see PanelKind
  bool whole_world = false;
  std::uint32_t columns = 0;  ///< panels side by side; 0: by the width
  std::size_t organism = 0;   ///< whose morphogens: place in the roster
};

/// Steps at even distances, `count` of them or one or two fewer: multiples of a round number, all
/// below `life`.
[[nodiscard]] std::vector<std::uint64_t> even_steps(std::uint64_t life, std::uint32_t count);

/// Panels side by side where the user did not say.
[[nodiscard]] std::uint32_t default_columns(PanelKind kind, double width_mm);

class Timelapse {
 public:
  static constexpr double least_panel = 40;  ///< points

  /// Throws run::UsageError if the panels would be narrower than `least_panel`.
  Timelapse(TimelapseOptions options, FigureSize size);

  /// How long the life will be, for the steps that nobody chose. `there` (ascending): those that
  /// can be had, of which the nearest are taken; empty: all.
  void expect(std::uint64_t life, const std::vector<std::uint64_t>& there = {});
  /// Call after every step.
  void observe(const model::Simulation& simulation);
  /// Or with every frame of a recording. Throws run::UsageError for a step to draw whose frame has
  /// no fields where the panels show some.
  void observe(const recording::Header& header, const recording::Frame& frame);
  /// The file's bytes. Throws run::UsageError, naming the last step, if the life ended before a
  /// chosen one.
  [[nodiscard]] std::string render(const Subject& subject) const;

  [[nodiscard]] const std::vector<Scene>& scenes() const { return scenes_; }

 private:
  /// A kind of panel; several make rows.
  struct Row {
    SceneStyle style;
    std::string label;
  };
  [[nodiscard]] std::vector<Row> rows() const;
  [[nodiscard]] bool shows_morphogens() const;
  [[nodiscard]] double panel_side(double left) const;
  [[nodiscard]] double left_margin() const { return rows().size() > 1 ? 9 : 0; }
  void begin(Setting setting);
  [[nodiscard]] bool wanted(std::uint64_t step) const;
  void keep(Scene scene);
  void check_complete() const;
  void paint(const Canvas& canvas, const Rect& body) const;
  [[nodiscard]] std::string title() const;
  [[nodiscard]] std::vector<LegendEntry> legend() const;
  void add_cell_entries(std::vector<LegendEntry>& entries) const;
  void add_morphogen_entries(std::vector<LegendEntry>& entries) const;
  void add_ground_entries(std::vector<LegendEntry>& entries) const;

  TimelapseOptions options_;
  FigureSize size_;
  SceneWants wants_;
  Setting setting_;
  Zones zones_;
  Levels levels_;
  bool described_ = false;
  std::uint64_t last_step_ = 0;
  std::vector<Scene> scenes_;
};

}  // namespace somas::report
