// Going through the cells of a world: range by range, shared with a team, or by marks in canonical
// order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "core/model/cells.hpp"
#include "core/model/team.hpp"

namespace somas::model {

/// Calls visit(range) for the ranges that the cells [begin, end) belong to, cut to these.
template <class Visit>
void each_range(const CellStore& cells, std::uint32_t begin, std::uint32_t end, Visit&& visit) {
  for (CellRange range : cells.ranges) {
    range.begin = std::max(range.begin, begin);
    range.end = std::min(range.end, end);
    if (range.begin < range.end) visit(std::as_const(range));
  }
}

/// The same for all cells in ranges; with a team (may be null) for parts of them at once.
template <class Visit>
void share_ranges(Team* team, const CellStore& cells, const Visit& visit) {
  const std::uint32_t count = cells.ranges.empty() ? 0 : cells.ranges.back().end;
  share(team, count,
        [&](std::uint32_t begin, std::uint32_t end) { each_range(cells, begin, end, visit); });
}

/// Calls visit(place) for each place with that mark, in ascending order.
template <class Visit>
void each_marked(std::span<const std::uint8_t> marks, std::uint8_t mark, Visit&& visit) {
  const std::uint8_t *at = marks.data(), *end = at + marks.size();
  while (at != end) {
    at =
        static_cast<const std::uint8_t*>(std::memchr(at, mark, static_cast<std::size_t>(end - at)));
    if (at == nullptr) return;
    visit(static_cast<std::uint32_t>(at - marks.data()));
    ++at;
  }
}

}  // namespace somas::model
