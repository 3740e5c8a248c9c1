#include "core/model/neighbours.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/model/compress.hpp"

namespace somas::model {

namespace {

constexpr EightMask lanes{0, 1, 2, 3, 4, 5, 6, 7};

/// A layer of a sorting network: of a lane and its partner, whose partner it is, the lower one gets
/// the lower item.
template <int... Partners>
inline void exchange(EightItems& items) {
  const EightItems others = __builtin_shufflevector(items, items, Partners...);
  const EightItems low = others < items ? others : items, high = others < items ? items : others;
  items = lanes < EightMask{Partners...} ? low : high;
}

inline EightItems read_items(const std::uint32_t* items, std::size_t count) {
  EightItems all;
  std::memcpy(&all, items, sizeof all);
  return lanes < static_cast<std::int32_t>(count) ? all : ~EightItems{};
}

constexpr auto swap_fours = exchange<4, 5, 6, 7, 0, 1, 2, 3>;
constexpr auto swap_twos = exchange<2, 3, 0, 1, 6, 7, 4, 5>;
constexpr auto swap_ones = exchange<1, 0, 3, 2, 5, 4, 7, 6>;

/// 19 exchanges in six layers (D. E. Knuth, The Art of Computer Programming 3, 5.3.4).
inline void sort_eight(EightItems& items) {
  swap_twos(items);
  swap_fours(items);
  swap_ones(items);
  exchange<0, 1, 4, 5, 2, 3, 6, 7>(items);
  exchange<0, 4, 2, 6, 1, 5, 3, 7>(items);
  exchange<0, 2, 1, 4, 3, 6, 5, 7>(items);
}

/// Sorts items that rise, then fall, or fall, then rise (K. E. Batcher's bitonic merge).
inline void merge_eight(EightItems& items) {
  swap_fours(items);
  swap_twos(items);
  swap_ones(items);
}

/// Sorts up to eight items; reads and writes eight.
inline void sort_few(const std::uint32_t* items, std::size_t count, std::uint32_t* sorted) {
  EightItems few = read_items(items, count);
  sort_eight(few);
  std::memcpy(sorted, &few, sizeof few);
}

/// Sorts nine to sixteen items; reads and writes sixteen.
inline void sort_more(const std::uint32_t* items, std::size_t count, std::uint32_t* sorted) {
  EightItems low = read_items(items, 8), high = read_items(items + 8, count - 8);
  sort_eight(low);
  sort_eight(high);
  const EightItems falling = __builtin_shufflevector(high, high, 7, 6, 5, 4, 3, 2, 1, 0);
  high = falling < low ? low : falling;
  low = falling < low ? falling : low;
  merge_eight(low);
  merge_eight(high);
  std::memcpy(sorted, &low, sizeof low);
  std::memcpy(sorted + 8, &high, sizeof high);
}

}  // namespace

bool NeighbourPairs::stale(std::span<const Body> bodies, double range) {
  if (!valid_ || built_.size() != bodies.size() || range > range_) return true;
  // Two bodies approach by at most both displacements, and their reach grows by both growths: a
  // pair is safe while both have drifted less than their margins.
  std::atomic<bool> any_drifted = false;
  share(team_, static_cast<std::uint32_t>(bodies.size()),
        [&](std::uint32_t begin, std::uint32_t end) {
          bool drifted_away = false;
          for (std::uint32_t i = begin; i < end; ++i) {
            const double growth = std::max(0.0, bodies[i].radius - built_[i].radius) * range_;
            const double allowed = built_[i].margin - growth;
            safe_square_[i] = allowed > 0 ? allowed * allowed : 0.0;
            drifted_away |= drifted(i, Two{bodies[i].x, bodies[i].y});
          }
          if (drifted_away) any_drifted = true;
        });
  return any_drifted;
}

void NeighbourPairs::build(std::span<const Body> bodies, double range, double skin, double time) {
  range_ = range;
  built_.resize(bodies.size());
  safe_square_.resize(bodies.size());
  const auto count = static_cast<std::uint32_t>(bodies.size());
  share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const Body& body = bodies[i];
      const double way = time * std::sqrt(body.vx * body.vx + body.vy * body.vy);
      const double own = 0.5 * skin + (way < longest_way ? way : longest_way);
      built_[i] = {body.x, body.y, body.radius, own};
      safe_square_[i] = own * own;
    }
  });
  bins_.sort(built_, range);
  const unsigned parts = team_ == nullptr ? 1 : team_->parts(count);
  if (parts > 1) {
    find_in_parts(parts);
  } else {
    found_[0].count = 0;
    find(0, count, found_[0]);
    count_ = found_[0].count;
    sort(found_[0]);
  }
  pad();
  valid_ = true;
  indexed_ = false;
}

/// Those of the bodies at places [begin, end) in the bins with others at later places.
void NeighbourPairs::find(std::uint32_t begin, std::uint32_t end, Found& found) const {
  const std::uint32_t columns = bins_.columns();
  for (std::uint32_t k = begin; k < end; ++k) {
    // Half of the bins around: the other half finds its pairs with this one by itself.
    const std::uint32_t bin = bins_.bin_at(k);
    const std::uint32_t beside_end = bins_.start(bin + 2);
    const std::uint32_t above_begin = bins_.start(bin + columns - 1);
    const std::uint32_t above_end = bins_.start(bin + columns + 2);
    // Room for all, and for the last eight written.
    const std::size_t room = found.count + (beside_end - k) + (above_end - above_begin) + 16;
    if (found.first.size() < room) {
      found.first.resize(2 * room);
      found.second.resize(2 * room);
    }
    const std::size_t before = found.count;
    collect(k, k + 1, beside_end, found);
    collect(k, above_begin, above_end, found);
    if (bins_.coarse()) drop_distant(before, found);
  }
}

inline void NeighbourPairs::collect(std::uint32_t k, std::uint32_t begin, std::uint32_t end,
                                    Found& found) const {
  // Most candidates fail: collect the others eight by eight, without branching on each.
  const float *all_x = bins_.x(), *all_y = bins_.y(), *all_reach = bins_.reach();
  const std::uint32_t* all = bins_.items();
  const float x = all_x[k], y = all_y[k], own_reach = all_reach[k];
  const EightItems item = all[k] + EightItems{};
  std::uint32_t* first = found.first.data() + found.count;
  std::uint32_t* second = found.second.data() + found.count;
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
  found.count = static_cast<std::size_t>(first - found.first.data());
}

/// Of the pairs found from `from` on keeps those within reach in double precision.
void NeighbourPairs::drop_distant(std::size_t from, Found& found) const {
  std::size_t kept = from;
  for (std::size_t p = from; p < found.count; ++p) {
    const Disc &a = built_[found.first[p]], &b = built_[found.second[p]];
    const double dx = a.x - b.x, dy = a.y - b.y;
    const double reach = range_ * (a.radius + b.radius) + a.margin + b.margin;
    if (!(dx * dx + dy * dy < reach * reach)) continue;
    found.first[kept] = found.first[p];
    found.second[kept++] = found.second[p];
  }
  found.count = kept;
}

void NeighbourPairs::make_room() {
  if (first_.size() >= count_ + 3) return;
  first_.resize(2 * count_ + 3);
  second_.resize(2 * count_ + 3);
  unsorted_.resize(2 * count_ + 3);
}

/// A counting sort by the first; then the seconds of each.
void NeighbourPairs::sort(const Found& found) {
  // Counts stand two places on, so that places taken one on leave the starts.
  const auto bodies = static_cast<std::uint32_t>(built_.size());
  start_.assign(std::size_t{bodies} + 2, 0);
  for (std::size_t p = 0; p < count_; ++p) ++start_[found.first[p] + 2];
  for (std::size_t i = 2; i < start_.size(); ++i) start_[i] += start_[i - 1];
  make_room();
  for (std::size_t p = 0; p < count_; ++p)
    unsorted_[start_[found.first[p] + 1]++] = found.second[p];
  sort_seconds({0, bodies});
}

void NeighbourPairs::find_in_parts(unsigned parts) {
  const auto count = static_cast<std::uint32_t>(built_.size());
  if (found_.size() < parts) found_.resize(parts);
  counts_.reset(parts, count);
  const auto find_some = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    Found& found = found_[part];
    found.count = 0;
    find(own.begin, own.end, found);
    std::uint32_t* counts = counts_.begin(part);
    for (std::size_t p = 0; p < found.count; ++p) ++counts[found.first[p]];
  };
  team_->run(parts, find_some);
  count_ = counts_.to_places(team_, start_);
  make_room();
  const auto place = [&](unsigned part) {
    const Found& found = found_[part];
    std::uint32_t* places = counts_.of(part);
    for (std::size_t p = 0; p < found.count; ++p)
      unsorted_[places[found.first[p]]++] = found.second[p];
  };
  team_->run(parts, place);
  const auto order = [&](unsigned part) { sort_seconds(stretch(count, part, parts)); };
  team_->run(parts, order);
}

/// From the unsorted ones; and lists the firsts.
void NeighbourPairs::sort_seconds(Stretch bodies) {
  const std::uint32_t* const unsorted = unsorted_.data();
  std::uint32_t* const first = first_.data();
  std::uint32_t* const second = second_.data();
  // Behind the last pair may be those of another part.
  const std::uint32_t last = start_[bodies.end];
  for (std::uint32_t k = bodies.begin; k < bodies.end; ++k) {
    const std::uint32_t begin = start_[k], count = start_[k + 1] - begin;
    if (count <= 8 && begin + 16 <= last) {
      sort_few(unsorted + begin, count, second + begin);
    } else if (count <= 16 && begin + 16 <= last) {
      sort_more(unsorted + begin, count, second + begin);
    } else {
      std::copy_n(unsorted + begin, count, second + begin);
      std::sort(second + begin, second + begin + count);
      std::fill_n(first + begin, count, k);
      continue;
    }
    const EightItems all = k + EightItems{};
    std::memcpy(first + begin, &all, sizeof all);
    std::memcpy(first + begin + 8, &all, sizeof all);
  }
}

void NeighbourPairs::index_by_second(unsigned parts) {
  if (indexed_) return;
  const auto bodies = static_cast<std::uint32_t>(built_.size());
  const auto count = static_cast<std::uint32_t>(count_);
  counts_.reset(parts, bodies);
  const auto count_seconds = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    std::uint32_t* counts = counts_.begin(part);
    for (std::uint32_t p = own.begin; p < own.end; ++p) ++counts[second_[p]];
  };
  team_->run(parts, count_seconds);
  counts_.to_places(team_, second_start_);
  if (pairs_by_second_.size() < count_) pairs_by_second_.resize(2 * count_);
  const auto place = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    std::uint32_t* places = counts_.of(part);
    for (std::uint32_t p = own.begin; p < own.end; ++p) pairs_by_second_[places[second_[p]]++] = p;
  };
  team_->run(parts, place);
  indexed_ = true;
}

void NeighbourPairs::pad() {
  for (std::size_t p = count_; count_ > 0 && p < count_ + 3; ++p) {
    first_[p] = first_[count_ - 1];
    second_[p] = second_[count_ - 1];
  }
}

}  // namespace somas::model
