#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

bool placed(const Body& body) {
  constexpr double absurd = 1e150;
  return std::abs(body.x) < absurd && std::abs(body.y) < absurd;
}

}  // namespace

bool NeighbourPairs::stale(std::span<const Body> bodies, double range) const {
  if (!valid_ || built_.size() != bodies.size() || range > range_) return true;
  // Two bodies approach by at most both displacements, and their reach grows by both growths: a
  // pair is safe while both have drifted less than half the skin. A NaN is never safe.
  std::size_t safe = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double dx = bodies[i].x - built_[i].x, dy = bodies[i].y - built_[i].y;
    const double growth = std::max(0.0, bodies[i].radius - built_[i].radius) * range_;
    const double allowed = 0.5 * skin_ - growth;
    safe += static_cast<std::size_t>(dx * dx + dy * dy < allowed * allowed) &
            static_cast<std::size_t>(allowed > 0);
  }
  return safe != bodies.size();
}

void NeighbourPairs::build(std::span<const Body> bodies, double range, double skin) {
  skin_ = skin;
  range_ = range;
  double radius = 0;
  for (const Body& body : bodies) radius = std::max(radius, body.radius);
  sort_into_bins(bodies, 2.0 * radius * range + skin);

  find();
  sort();
  pad();
  built_.clear();
  for (const Body& body : bodies) built_.push_back({body.x, body.y, body.radius});
  valid_ = true;
}

void NeighbourPairs::sort_into_bins(std::span<const Body> bodies, double reach) {
  // Bodies that an absurd force threw out of all bounds have no neighbours, whatever their bin.
  double right = 0, top = 0;
  left_ = bottom_ = 0;
  bool any = false;
  for (const Body& body : bodies) {
    if (!placed(body)) continue;
    left_ = any ? std::min(left_, body.x) : body.x, right = any ? std::max(right, body.x) : body.x;
    bottom_ = any ? std::min(bottom_, body.y) : body.y, top = any ? std::max(top, body.y) : body.y;
    any = true;
  }
  const double longest = std::max(right - left_, top - bottom_);
  // A body far off must not cost a grid as wide: a few bins a body are enough.
  const double most_bins = 4.0 * static_cast<double>(bodies.size()) + 1024;
  bin_side_ = std::max(
      {reach, longest / most_bins, std::sqrt((right - left_) * (top - bottom_) / most_bins)});
  columns_ = static_cast<std::uint32_t>((right - left_) / bin_side_) + 1;
  rows_ = static_cast<std::uint32_t>((top - bottom_) / bin_side_) + 1;

  // Counting sort that keeps the order within a bin.
  bin_of_.resize(bodies.size());
  bin_start_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bin_of_[i] = 0;
    if (placed(bodies[i])) {
      const auto c = static_cast<std::uint32_t>((bodies[i].x - left_) / bin_side_);
      const auto r = static_cast<std::uint32_t>((bodies[i].y - bottom_) / bin_side_);
      bin_of_[i] = std::min(r, rows_ - 1) * columns_ + std::min(c, columns_ - 1);
    }
    ++bin_start_[bin_of_[i] + 1];
  }
  for (std::size_t b = 1; b < bin_start_.size(); ++b) bin_start_[b] += bin_start_[b - 1];
  bin_items_.resize(bodies.size() + 4);
  for (auto* column : {&bin_x_, &bin_y_, &bin_radius_}) column->resize(bodies.size() + 4);
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t at = bin_start_[bin_of_[i]]++;
    bin_items_[at] = i;
    bin_x_[at] = bodies[i].x;
    bin_y_[at] = bodies[i].y;
    bin_radius_[at] = bodies[i].radius;
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
  const double x = bin_x_[k], y = bin_y_[k], radius = bin_radius_[k];
  Four xs, ys, radii;
  for (std::uint32_t c = begin; c < end; c += 4) {
    read(&bin_x_[c], xs);
    read(&bin_y_[c], ys);
    read(&bin_radius_[c], radii);
    const Four dx = xs - x, dy = ys - y;
    const Four reach = range_ * (radii + radius) + skin_;
    const FourMask within = (dx * dx + dy * dy < reach * reach) & (lanes < std::int64_t{end - c});
    for (std::uint32_t lane = 0; lane < 4; ++lane) {
      *near = bin_items_[c + lane];
      near -= within[lane];
    }
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
