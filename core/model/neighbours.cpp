#include "core/model/neighbours.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace somas::model {

namespace {

/// However fast a body is, it must not cost everybody wide bins.
constexpr double widest_margin = 0.2;

/// For each set of eight lanes, these first.
alignas(32) constexpr auto lanes_first = [] {
  std::array<std::array<std::uint32_t, 8>, 256> table{};
  for (std::size_t set = 0; set < 256; ++set) {
    std::size_t to = 0;
    for (std::uint32_t lane = 0; lane < 8; ++lane)
      if ((set >> lane & 1) != 0) table[set][to++] = lane;
  }
  return table;
}();

/// Moves those of eight items whose lanes are set to the front.
inline void compress(std::uint32_t set, EightItems& items) {
  EightItems lanes;
  std::memcpy(&lanes, lanes_first[set].data(), sizeof lanes);
  items = __builtin_shuffle(items, lanes);
}

}  // namespace

bool NeighbourPairs::stale(std::span<const Body> bodies, double range) {
  if (!valid_ || built_.size() != bodies.size() || range > range_) return true;
  // Two bodies approach by at most both displacements, and their reach grows by both growths: a
  // pair is safe while both have drifted less than their margins.
  bool drifted_away = false;
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const double growth = std::max(0.0, bodies[i].radius - built_[i].radius) * range_;
    const double allowed = built_[i].margin - growth;
    safe_square_[i] = allowed > 0 ? allowed * allowed : 0.0;
    drifted_away |= drifted(i, Two{bodies[i].x, bodies[i].y});
  }
  return drifted_away;
}

void NeighbourPairs::build(std::span<const Body> bodies, double range, double skin, double time) {
  range_ = range;
  built_.resize(bodies.size());
  safe_square_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    const double way = time * std::sqrt(body.vx * body.vx + body.vy * body.vy);
    const double own = 0.5 * skin + (way < widest_margin ? way : widest_margin);
    built_[i] = {body.x, body.y, body.radius, own};
    safe_square_[i] = own * own;
  }
  bins_.sort(built_, range);
  find();
  sort();
  pad();
  valid_ = true;
}

void NeighbourPairs::find() {
  count_ = 0;
  for (std::uint32_t row = 0; row < bins_.rows(); ++row)
    for (std::uint32_t column = 0; column < bins_.columns(); ++column) find_of_bin(row, column);
}

void NeighbourPairs::find_of_bin(std::uint32_t row, std::uint32_t column) {
  const std::uint32_t columns = bins_.columns(), bin = row * columns + column;
  const std::uint32_t left = std::min(column, 1u);
  const std::uint32_t right = std::min(column + 1, columns - 1) - column;
  // Half of the bins around: the other half finds its pairs with this one by itself.
  const std::uint32_t end = bins_.start(bin + right + 1);
  const bool top = row + 1 == bins_.rows();
  const std::uint32_t above_begin = top ? 0 : bins_.start(bin + columns - left);
  const std::uint32_t above_end = top ? 0 : bins_.start(bin + columns + right + 1);
  for (std::uint32_t k = bins_.start(bin); k < bins_.start(bin + 1); ++k) {
    // Room for all, and for the last eight written.
    const std::size_t room = count_ + (end - k) + (above_end - above_begin) + 16;
    if (found_first_.size() < room) {
      found_first_.resize(2 * room);
      found_second_.resize(2 * room);
    }
    const std::size_t before = count_;
    collect(k, k + 1, end);
    collect(k, above_begin, above_end);
    if (bins_.coarse()) drop_distant(before);
  }
}

inline void NeighbourPairs::collect(std::uint32_t k, std::uint32_t begin, std::uint32_t end) {
  // Most candidates fail: collect the others eight by eight, without branching on each.
  constexpr EightMask lanes{0, 1, 2, 3, 4, 5, 6, 7};
  const float *all_x = bins_.x(), *all_y = bins_.y(), *all_reach = bins_.reach();
  const std::uint32_t* all = bins_.items();
  const float x = all_x[k], y = all_y[k], own_reach = all_reach[k];
  const EightItems item = all[k] + EightItems{};
  std::uint32_t* first = found_first_.data() + count_;
  std::uint32_t* second = found_second_.data() + count_;
  for (std::uint32_t c = begin; c < end; c += 8) {
    EightFloats xs, ys, reaches;
    EightItems items;
    std::memcpy(&xs, all_x + c, sizeof xs);
    std::memcpy(&ys, all_y + c, sizeof ys);
    std::memcpy(&reaches, all_reach + c, sizeof reaches);
    std::memcpy(&items, all + c, sizeof items);
    const EightFloats dx = xs - x, dy = ys - y, reach = reaches + own_reach;
    const EightMask within =
        (dx * dx + dy * dy < reach * reach) & (lanes < static_cast<std::int32_t>(end - c));
    const std::uint32_t set = bits_of(within);
    compress(set, items);
    const EightItems lower = items < item ? items : item, upper = items < item ? item : items;
    std::memcpy(first, &lower, sizeof lower);
    std::memcpy(second, &upper, sizeof upper);
    first += std::popcount(set);
    second += std::popcount(set);
  }
  count_ = static_cast<std::size_t>(first - found_first_.data());
}

/// Of the pairs found from `from` on keeps those within reach in double precision.
void NeighbourPairs::drop_distant(std::size_t from) {
  std::size_t kept = from;
  for (std::size_t p = from; p < count_; ++p) {
    const Disc &a = built_[found_first_[p]], &b = built_[found_second_[p]];
    const double dx = a.x - b.x, dy = a.y - b.y;
    const double reach = range_ * (a.radius + b.radius) + a.margin + b.margin;
    if (!(dx * dx + dy * dy < reach * reach)) continue;
    found_first_[kept] = found_first_[p];
    found_second_[kept++] = found_second_[p];
  }
  count_ = kept;
}

void NeighbourPairs::sort() {
  // By the second, then stably by the first: two counting sorts. Counts stand two places on, so
  // that places taken one on leave the starts.
  start_.assign(built_.size() + 2, 0);
  by_second_.assign(built_.size() + 2, 0);
  for (std::size_t p = 0; p < count_; ++p) {
    ++start_[found_first_[p] + 2];
    ++by_second_[found_second_[p] + 2];
  }
  for (std::size_t i = 2; i < start_.size(); ++i) {
    start_[i] += start_[i - 1];
    by_second_[i] += by_second_[i - 1];
  }
  if (sorted_.size() < count_) sorted_.resize(2 * count_);
  for (std::size_t p = 0; p < count_; ++p)
    sorted_[by_second_[found_second_[p] + 1]++] = {found_first_[p], found_second_[p]};
  if (first_.size() < count_ + 3) {
    first_.resize(2 * count_ + 3);
    second_.resize(2 * count_ + 3);
  }
  for (std::size_t p = 0; p < count_; ++p) {
    const std::uint32_t at = start_[sorted_[p].first + 1]++;
    first_[at] = sorted_[p].first;
    second_[at] = sorted_[p].second;
  }
}

void NeighbourPairs::pad() {
  for (std::size_t p = count_; count_ > 0 && p < count_ + 3; ++p) {
    first_[p] = first_[count_ - 1];
    second_[p] = second_[count_ - 1];
  }
}

}  // namespace somas::model
