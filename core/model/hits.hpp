// Which cell a straight path meets first.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/world.hpp"

#include "core/model/disc_bins.hpp"
#include "core/model/neighbours.hpp"

namespace somas::model {

/// Distance along the segment, in [0, 1], at which it meets the disc: 0 when it starts inside,
/// negative when it does not meet it.
[[nodiscard]] double meeting(const Segment& segment, double x, double y, double radius);

/// Finds first hits among cells that are sorted into bins.
class HitFinder {
 public:
  /// Call after cells moved. `bodies` are where they are now, and the items of `bins` are places
  /// among them; each body's disc lies within reach of its place there. Of which cell, in storage,
  /// a body is, `cells` says, and of that cell, which it is in canonical order, `rank`. All are
  /// used until the next call.
  void prepare(std::span<const Body> bodies, const DiscBins& bins,
               std::span<const std::uint32_t> cells, std::span<const std::uint32_t> rank);
  /// The first cell met, in storage (equal distances: the first in canonical order), or -1.
  [[nodiscard]] std::int32_t first(const Segment& segment) const;
  /// The same for many: hits[i] is for segments[i].
  void first(std::span<const Segment> segments, std::span<std::int32_t> hits) const;

 private:
  [[nodiscard]] bool is_later(std::uint32_t one, std::uint32_t other) const {
    return rank_[cells_[one]] > rank_[cells_[other]];
  }
  void mark_inhabited();
  [[nodiscard]] bool far_from_all(const Segment& segment, double length) const;

  std::span<const Body> bodies_;
  std::span<const std::uint32_t> cells_, rank_;
  const DiscBins* bins_ = nullptr;
  std::vector<std::uint8_t> inhabited_, around_;  ///< bins of a row with cells; all near them
};

}  // namespace somas::model
