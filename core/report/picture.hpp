// An organism in its world, drawn for papers: a panel for each chosen step, side by side and to
// the same scale.
//
// Drawn from below: a grid's content (inside the world; grey, linear in CIE lightness), the world's
// circle, outlines of environments, cells (true radius, a colour a state; dividing cells have a
// black rim), and the rows of tables with columns x and y (particles). Colours of states and tables
// are those of Okabe and Ito (2008), which colour-blind people can tell apart; from the seventh
// state on they return darker.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/model/simulation.hpp"

namespace somas::report {

enum class PictureFormat { svg, pdf, png };

/// By the extension of a file's name. Throws run::UsageError, saying what is allowed.
[[nodiscard]] PictureFormat picture_format(const std::filesystem::path& file);

struct PictureOptions {
  std::vector<std::uint64_t> steps = {};  ///< from 0; the world after the step
  std::string grid = {};                  ///< "instance.name"; empty: the first there is; "none"
  bool whole_world = false;               ///< instead of the organism and a margin
  std::uint32_t width = 1600;             ///< pixels of a PNG, points of SVG and PDF
};

/// A cell, and dots of a table, as they were. Lengths are those of the model (founder's radius: 1).
struct Disc {
  double x = 0, y = 0, radius = 0;
  std::uint16_t state = 0;  ///< index into the picture's states
  bool dividing = false;
};

/// The world after one step, as far as it is drawn.
struct Panel {
  std::uint64_t step = 0;
  std::vector<Disc> cells;                 ///< in canonical order
  std::vector<std::uint32_t> counts;       ///< cells by state
  std::vector<std::vector<Point>> tables;  ///< rows, by table drawn
  std::vector<double> grid;                ///< content, row-major; empty without a grid

  [[nodiscard]] std::uint32_t dividing() const;
};

class Picture {
 public:
  /// Throws run::UsageError if the width leaves a panel less than `least_panel_width`.
  explicit Picture(PictureOptions options);

  static constexpr std::uint32_t least_panel_width = 100;

  /// Call after every step. Throws run::UsageError, naming the grids, for one that is absent.
  void observe(const model::Simulation& simulation);

  [[nodiscard]] const std::vector<Panel>& panels() const { return panels_; }
  /// Names of the states, by the order of the tree.
  [[nodiscard]] const std::vector<std::string>& states() const { return states_; }

  /// Throws run::UsageError, naming the last step, if the life ended before a chosen one.
  void check_complete() const;
  /// The file's bytes. Throws as check_complete does.
  [[nodiscard]] std::string render(PictureFormat format) const;

 private:
  friend class Painter;
  void describe(const model::Simulation& simulation);
  void choose_grid(const model::Schema& schema);
  [[nodiscard]] Panel capture(const model::WorldState& world) const;

  PictureOptions options_;
  std::vector<std::string> states_, tables_;
  struct PositionColumns {
    Id table, x, y;
  };
  std::vector<PositionColumns> position_columns_;
  Id grid_ = no_id;
  std::string grid_name_;
  GridSpec grid_spec_;
  std::vector<model::Outline> outlines_;
  double radius_ = 0;
  bool described_ = false;
  std::uint64_t last_step_ = 0;
  std::vector<Panel> panels_;
};

}  // namespace somas::report
