// What figures for papers have in common: their size, their letters, their caption.
//
// All lengths are points (1/72 inch). Letters are never smaller than 6 points, so a figure that is
// made for a column's width is legible at it; a PNG has as many pixels as its resolution says.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/report/canvas.hpp"
#include "core/report/legend.hpp"
#include "core/run/replay.hpp"

namespace somas::report {

inline constexpr double points_per_mm = 72 / 25.4;
inline constexpr double label_font = 7, tick_font = 6.5, caption_font = 6.5;

struct FigureSize {
  PictureFormat format = PictureFormat::svg;
  double width_mm = 178;  ///< two columns of a paper; one is about 85
  double dpi = 300;       ///< of a PNG

  [[nodiscard]] double width() const { return width_mm * points_per_mm; }
  [[nodiscard]] double scale() const { return dpi / 72; }
};

/// By the extension of a file's name. Throws run::UsageError, saying what is allowed.
[[nodiscard]] PictureFormat picture_format(const std::filesystem::path& file);

/// Whose life a figure shows.
struct Subject {
  std::string experiment;
  std::string run;         ///< the run directory's name
  std::uint64_t seed = 0;  ///< of the run
  std::uint64_t generation = 0;
  std::uint32_t population = 0;  ///< 1 or 2; 0: there is only one
  std::uint64_t individual = 0;
  std::string origin;            ///< the operator that made it
  std::uint64_t world_seed = 0;  ///< of the simulation
  std::uint64_t survival = 0;
  bool censored = false;
  std::vector<std::string> changes = {};  ///< of a what-if
};
[[nodiscard]] Subject subject_of(const std::filesystem::path& run,
                                 const run::ReplayReport& replayed,
                                 const std::vector<std::string>& overrides);

/// "exp1, run exp1-seed1 (seed 1), generation 29: champion 5817 (mutation), world seed ...;
/// survival 1046 steps".
[[nodiscard]] std::string caption_of(const Subject& subject);

/// "Cell population of ..." and legend, then the words of the caption, below a figure's body.
struct Frame {
  std::string title;    ///< first words of the caption
  std::string caption;  ///< what follows them
  std::vector<LegendEntry> legend = {};
  double body = 0;  ///< height of what `paint` draws
  /// Draws into a rectangle at the upper left corner of the figure, `body` high.
  std::function<void(const Canvas&, const Rect&)> paint = {};
};

/// The file's bytes.
[[nodiscard]] std::string draw(const Frame& frame, const FigureSize& size);

/// A canvas to measure text with.
[[nodiscard]] const Canvas& measuring_canvas();

/// "exp1-seed1", however its path is written.
[[nodiscard]] std::string name_of_directory(const std::filesystem::path& directory);

/// "exp1-seed1 (seed 1)": a run directory's name, and the seed in its manifest.
[[nodiscard]] std::string title_of_run(const std::filesystem::path& run);

/// 12345 -> "12,345".
[[nodiscard]] std::string grouped(std::uint64_t number);

}  // namespace somas::report
