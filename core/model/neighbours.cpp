#include "core/model/neighbours.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

/// However fast a body is, it must not cost everybody wide bins.
constexpr double widest_margin = 0.2;

/// The lanes of a mask as bits.
inline std::uint32_t bits_of(const FourMask& mask) {
#ifdef __AVX__
  Four lanes;
  std::memcpy(&lanes, &mask, sizeof lanes);
  return static_cast<std::uint32_t>(__builtin_ia32_movmskpd256(lanes));
#else
  return static_cast<std::uint32_t>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

using FourItems = std::uint32_t __attribute__((vector_size(16)));

/// For each set of lanes, these first.
constexpr FourItems lanes_first[16] = {{0, 1, 2, 3}, {0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 2, 3},
                                       {2, 0, 1, 3}, {0, 2, 1, 3}, {1, 2, 0, 3}, {0, 1, 2, 3},
                                       {3, 0, 1, 2}, {0, 3, 1, 2}, {1, 3, 0, 2}, {0, 1, 3, 2},
                                       {2, 3, 0, 1}, {0, 2, 3, 1}, {1, 2, 3, 0}, {0, 1, 2, 3}};

/// Writes those of four items whose lanes are set, one after another, and has room for four.
/// Returns the end.
inline std::uint32_t* keep(const std::uint32_t* items, const FourMask& set, std::uint32_t* to) {
  const std::uint32_t bits = bits_of(set);
  FourItems four;
  std::memcpy(&four, items, sizeof four);
  four = __builtin_shuffle(four, lanes_first[bits]);
  std::memcpy(to, &four, sizeof four);
  return to + std::popcount(bits);
}

bool placed(double x, double y) {
  constexpr double absurd = 1e150;
  return std::abs(x) < absurd && std::abs(y) < absurd;
}

}  // namespace

bool NeighbourPairs::stale(std::span<const Body> bodies, double range) const {
  if (!valid_ || built_.size() != bodies.size() || range > range_) return true;
  // Two bodies approach by at most both displacements, and their reach grows by both growths: a
  // pair is safe while both have drifted less than their margins. A NaN is never safe.
  std::size_t safe = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double dx = bodies[i].x - built_[i].x, dy = bodies[i].y - built_[i].y;
    const double growth = std::max(0.0, bodies[i].radius - built_[i].radius) * range_;
    const double allowed = built_[i].margin - growth;
    safe += static_cast<std::size_t>(dx * dx + dy * dy < allowed * allowed) &
            static_cast<std::size_t>(allowed > 0);
  }
  return safe != bodies.size();
}

void NeighbourPairs::build(std::span<const Body> bodies, double range, double skin, double time) {
  range_ = range;
  double radius = 0, margin = 0;
  built_.clear();
  for (const Body& body : bodies) {
    const double way = time * std::sqrt(body.vx * body.vx + body.vy * body.vy);
    const double own = 0.5 * skin + (way < widest_margin ? way : widest_margin);
    built_.push_back({body.x, body.y, body.radius, own});
    radius = std::max(radius, body.radius);
    margin = std::max(margin, own);
  }
  sort_into_bins(2.0 * (radius * range + margin));
  find();
  sort();
  pad();
  valid_ = true;
}

void NeighbourPairs::sort_into_bins(double reach) {
  // Bodies that an absurd force threw out of all bounds have no neighbours, whatever their bin.
  double right = 0, top = 0;
  left_ = bottom_ = 0;
  bool any = false;
  for (const Disc& body : built_) {
    if (!placed(body.x, body.y)) continue;
    left_ = any ? std::min(left_, body.x) : body.x, right = any ? std::max(right, body.x) : body.x;
    bottom_ = any ? std::min(bottom_, body.y) : body.y, top = any ? std::max(top, body.y) : body.y;
    any = true;
  }
  const double longest = std::max(right - left_, top - bottom_);
  // A body far off must not cost a grid as wide: a few bins a body are enough.
  const double most_bins = 4.0 * static_cast<double>(built_.size()) + 1024;
  bin_side_ = std::max(
      {reach, longest / most_bins, std::sqrt((right - left_) * (top - bottom_) / most_bins)});
  columns_ = static_cast<std::uint32_t>((right - left_) / bin_side_) + 1;
  rows_ = static_cast<std::uint32_t>((top - bottom_) / bin_side_) + 1;

  // Counting sort that keeps the order within a bin.
  bin_of_.resize(built_.size());
  bin_start_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  for (std::size_t i = 0; i < built_.size(); ++i) {
    bin_of_[i] = 0;
    if (placed(built_[i].x, built_[i].y)) {
      const auto c = static_cast<std::uint32_t>((built_[i].x - left_) / bin_side_);
      const auto r = static_cast<std::uint32_t>((built_[i].y - bottom_) / bin_side_);
      bin_of_[i] = std::min(r, rows_ - 1) * columns_ + std::min(c, columns_ - 1);
    }
    ++bin_start_[bin_of_[i] + 1];
  }
  for (std::size_t b = 1; b < bin_start_.size(); ++b) bin_start_[b] += bin_start_[b - 1];
  bin_items_.resize(built_.size() + 4);
  for (auto* column : {&bin_x_, &bin_y_, &bin_extent_}) column->resize(built_.size() + 4);
  for (std::uint32_t i = 0; i < built_.size(); ++i) {
    const std::uint32_t at = bin_start_[bin_of_[i]]++;
    bin_items_[at] = i;
    bin_x_[at] = built_[i].x;
    bin_y_[at] = built_[i].y;
    bin_extent_[at] = range_ * built_[i].radius + built_[i].margin;
  }
  for (std::size_t b = bin_start_.size() - 1; b > 0; --b) bin_start_[b] = bin_start_[b - 1];
  bin_start_[0] = 0;
}

void NeighbourPairs::find() {
  count_ = 0;
  start_.assign(bin_of_.size() + 1, 0);
  by_second_.assign(bin_of_.size() + 1, 0);
  near_.resize(std::max(near_.size(), bin_items_.size() + 4));
  for (std::uint32_t row = 0; row < rows_; ++row) {
    for (std::uint32_t column = 0; column < columns_; ++column) {
      const std::uint32_t bin = row * columns_ + column;
      const std::uint32_t left = std::min(column, 1u);
      const std::uint32_t right = std::min(column + 1, columns_ - 1) - column;
      // Half of the bins around: the other half finds its pairs with this one by itself.
      const std::uint32_t end = bin_start_[bin + right + 1];
      const std::uint32_t above = row + 1 < rows_ ? bin + columns_ : bin;
      const std::uint32_t above_begin = row + 1 < rows_ ? bin_start_[above - left] : 0;
      const std::uint32_t above_end = row + 1 < rows_ ? bin_start_[above + right + 1] : 0;
      for (std::uint32_t k = bin_start_[bin]; k < bin_start_[bin + 1]; ++k) {
        std::uint32_t* near = collect(k, k + 1, end, near_.data());
        near = collect(k, above_begin, above_end, near);
        take(bin_items_[k], {near_.data(), near});
      }
    }
  }
}

std::uint32_t* NeighbourPairs::collect(std::uint32_t k, std::uint32_t begin, std::uint32_t end,
                                       std::uint32_t* near) const {
  // Most candidates fail: collect the others four by four, without branching on each.
  constexpr FourMask lanes{0, 1, 2, 3};
  const double x = bin_x_[k], y = bin_y_[k], extent = bin_extent_[k];
  Four xs, ys, extents;
  for (std::uint32_t c = begin; c < end; c += 4) {
    read(&bin_x_[c], xs);
    read(&bin_y_[c], ys);
    read(&bin_extent_[c], extents);
    const Four dx = xs - x, dy = ys - y;
    const Four reach = extents + extent;
    const FourMask within = (dx * dx + dy * dy < reach * reach) & (lanes < std::int64_t{end - c});
    near = keep(&bin_items_[c], within, near);
  }
  return near;
}

void NeighbourPairs::take(std::uint32_t item, std::span<const std::uint32_t> near) {
  if (found_.size() < count_ + near.size()) found_.resize(2 * (count_ + near.size()));
  for (const std::uint32_t other : near) {
    const Pair pair{std::min(item, other), std::max(item, other)};
    found_[count_++] = pair;
    ++start_[pair.first + 1];
    ++by_second_[pair.second + 1];
  }
}

void NeighbourPairs::sort() {
  // By the second, then stably by the first: two counting sorts.
  for (std::size_t i = 1; i < start_.size(); ++i) {
    start_[i] += start_[i - 1];
    by_second_[i] += by_second_[i - 1];
  }
  if (sorted_.size() < count_) sorted_.resize(2 * count_);
  for (std::size_t p = 0; p < count_; ++p) sorted_[by_second_[found_[p].second]++] = found_[p];
  if (first_.size() < count_ + 3) {
    first_.resize(2 * count_ + 3);
    second_.resize(2 * count_ + 3);
  }
  for (std::size_t p = 0; p < count_; ++p) {
    const std::uint32_t at = start_[sorted_[p].first]++;
    first_[at] = sorted_[p].first;
    second_[at] = sorted_[p].second;
  }
  for (std::size_t i = start_.size() - 1; i > 0; --i) start_[i] = start_[i - 1];
  start_[0] = 0;
}

void NeighbourPairs::pad() {
  for (std::size_t p = count_; count_ > 0 && p < count_ + 3; ++p) {
    first_[p] = first_[count_ - 1];
    second_[p] = second_[count_ - 1];
  }
}

}  // namespace somas::model
