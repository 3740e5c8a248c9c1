// An organism in its world at chosen steps: a panel each, side by side and to the same scale.
// Colours of states and tables are those of core/report/palette.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/model/simulation.hpp"
#include "core/report/figure.hpp"
#include "core/report/scene.hpp"

namespace somas::report {

struct PictureOptions {
  std::vector<std::uint64_t> steps = {};  ///< from 0; the world after the step
  std::string grid = {};                  ///< "instance.name"; empty: the first there is; "none"
  bool whole_world = false;               ///< instead of the organism and a margin
  std::uint32_t width = 1600;             ///< pixels of a PNG, points of SVG and PDF
};

class Picture {
 public:
  /// Throws run::UsageError if the width leaves a panel less than `least_panel_width`.
  explicit Picture(PictureOptions options);

  static constexpr std::uint32_t least_panel_width = 100;

  /// Before the first step: which organism is the champion, by its place in the roster.
  void about(std::size_t organism) { wants_.organism = organism; }
  /// Call after every step. Throws run::UsageError, naming the grids, for one that is absent.
  void observe(const model::Simulation& simulation);

  [[nodiscard]] const std::vector<Scene>& panels() const { return panels_; }
  /// Names of the states, by the order of the tree.
  [[nodiscard]] const std::vector<std::string>& states() const { return setting_.states; }

  /// Throws run::UsageError, naming the last step, if the life ended before a chosen one.
  void check_complete() const;
  /// The file's bytes. Throws as check_complete does.
  [[nodiscard]] std::string render(PictureFormat format) const;

 private:
  friend class Painter;

  PictureOptions options_;
  SceneWants wants_;
  Setting setting_;
  bool described_ = false;
  std::uint64_t last_step_ = 0;
  std::vector<Scene> panels_;
};

}  // namespace somas::report
