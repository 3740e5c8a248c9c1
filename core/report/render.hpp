// One command, one figure: from a run directory to a file's bytes.
//
// Figures of a life come from living the recorded champion again, which must reproduce its record;
// those of a run come from its tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/report/figure.hpp"
#include "core/run/replay.hpp"

namespace somas::report {

enum class What { timelapse, energy, morphogens, grid, population, phases, evolution, lineage };

/// Throws run::UsageError, with what there is and what was probably meant.
[[nodiscard]] What what_named(const std::string& name);
[[nodiscard]] std::string name_of(What what);

struct RenderOptions {
  /// Run directories, several for What::evolution only; or one recording, for figures of a life.
  std::vector<std::filesystem::path> runs;
  What what = What::timelapse;
  std::optional<std::uint64_t> generation = {};  ///< default: the last
  std::uint32_t population = 1;                  ///< 2 in mode coevolution only
  std::vector<std::string> overrides = {};       ///< a what-if, not checked against the record
  std::vector<std::filesystem::path> plugin_directories = {};
  std::vector<std::uint64_t> steps = {};  ///< of panels; empty: evenly over the life
  std::string grid = {};                  ///< see PanelKind
  bool whole_world = false;
  std::uint32_t columns = 0;  ///< panels side by side; 0: by the width
  FigureSize size = {};
};

struct Rendered {
  std::string bytes;
  std::vector<std::string> warnings;
};

/// The life that was lived again is not the recorded one: there is nothing to draw.
class NotReproduced : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws NotReproduced, run::UsageError, and what run::replay and recording::read throw.
[[nodiscard]] Rendered render(const RenderOptions& options);

/// figures/WHAT-gen-NNNN.svg (or another format) in the first run; of What::evolution without a
/// generation. Throws run::UsageError for a run without a champion.
[[nodiscard]] std::filesystem::path default_output(const RenderOptions& options);

/// Lives a champion again and checks it, unless there are overrides. Throws NotReproduced.
[[nodiscard]] run::ReplayReport live_again(run::ReplayOptions options);

}  // namespace somas::report
