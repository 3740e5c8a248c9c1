// Which cell a straight path meets first.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/world.hpp"

#include "core/model/disc_bins.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/team.hpp"

namespace somas::model {

/// Distance along the segment, in [0, 1], at which it meets the disc: 0 when it starts inside,
/// negative when it does not meet it.
[[nodiscard]] double meeting(const Segment& segment, double x, double y, double radius);

/// Finds first hits among cells that are sorted into bins. Many paths go side by side through each
/// step of the search, so that their waits for memory overlap.
class HitFinder {
 public:
  /// Call after cells moved. `bodies` are where they are now, and the items of `bins` are places
  /// among them; each body's disc lies within reach of its place there. Of which cell, in storage,
  /// a body is, `cells` says, and of that cell, which it is in canonical order, `rank`. All are
  /// used until the next call.
  void prepare(std::span<const Body> bodies, const DiscBins& bins,
               std::span<const std::uint32_t> cells, std::span<const std::uint32_t> rank);
  /// So many paths are asked for next. For many it pays to mark first where no cell can be met,
  /// once after each prepare(); the work is shared with `team` (null: nobody).
  void expect(std::size_t paths, Team* team = nullptr);
  /// The first cell met, in storage (equal distances: the first in canonical order), or -1.
  [[nodiscard]] std::int32_t first(const Segment& segment) const;
  /// The same for many: hits[i] is for segments[i].
  void first(std::span<const Segment> segments, std::span<std::int32_t> hits) const;

 private:
  struct Search;

  [[nodiscard]] bool is_later(std::uint32_t one, std::uint32_t other) const {
    return rank_[cells_[one]] > rank_[cells_[other]];
  }
  void mark(Team* team);
  void mark_round(std::uint32_t begin_row, std::uint32_t end_row);
  std::size_t list_near(std::span<const Segment> segments, std::uint32_t* near) const;
  void find(Search& search) const;
  void find_windows(Search& search) const;
  void fetch_discs(const Search& search) const;
  void list_candidates(Search& search, std::uint32_t path) const;
  void meet_candidates(Search& search) const;

  std::span<const Body> bodies_;
  std::span<const std::uint32_t> cells_, rank_;
  const DiscBins* bins_ = nullptr;
  // Squares smaller than bins, with a margin all round; a bit for each that the middle of a short
  // path lies in when it can meet a cell.
  bool marked_ = false;
  double per_square_ = 0;                              ///< 1 / side
  double short_ = 0;                                   ///< a path at most so long counts as short
  std::uint32_t columns_ = 0, rows_ = 0, stride_ = 0;  ///< of squares; words of a row
  std::vector<std::uint64_t> marks_;
};

}  // namespace somas::model
