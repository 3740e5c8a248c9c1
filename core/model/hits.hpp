// Which cell a straight path meets first.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/world.hpp"

#include "core/model/cells.hpp"

namespace somas::model {

/// Distance along the segment, in [0, 1], at which it meets the disc: 0 when it starts inside,
/// negative when it does not meet it.
[[nodiscard]] double meeting(const Segment& segment, double x, double y, double radius);

/// Finds first hits on a grid of bins over the cells' present positions.
class HitFinder {
 public:
  /// Sorts the cells' discs; call after they moved.
  void prepare(const CellStore& cells);
  /// Index of the first cell met (equal distances: canonical order), or -1.
  [[nodiscard]] std::int32_t first(const CellStore& cells, const Segment& segment) const;
  /// The same for many: hits[i] is for segments[i].
  void first(const CellStore& cells, std::span<const Segment> segments,
             std::span<std::int32_t> hits);

 private:
  void mark_inhabited();
  [[nodiscard]] bool overlaps(const Segment& segment) const;
  [[nodiscard]] std::int32_t nearest(const CellStore& cells, const Segment& segment) const;

  double left_ = 0, bottom_ = 0, right_ = -1, top_ = -1;  ///< bounds of all discs
  double side_ = 1, widest_ = 0;
  std::int32_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> start_, items_, bin_, placed_, near_;
  std::vector<double> x_, y_, radius_;            ///< of items, with room to read four at a time
  std::vector<std::uint8_t> inhabited_, around_;  ///< bins of a row with cells; all near cells
};

}  // namespace somas::model
