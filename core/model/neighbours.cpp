#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/cells.hpp"

namespace somas::model {

namespace {

constexpr std::uint32_t most_bins_per_side = 4096;
// Bins finer than the reach waste fewer candidates in the corners.
constexpr std::uint32_t bins_per_reach = 2;

}  // namespace

bool NeighbourLists::stale(std::span<const Body> bodies) const {
  if (!valid_ || built_.size() != bodies.size()) return true;
  // Two cells approach by at most both displacements, and their reach grows by both growths.
  double greatest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double dx = bodies[i].x - built_[i].x, dy = bodies[i].y - built_[i].y;
    const double growth = std::max(0.0, bodies[i].radius - built_[i].radius) * growth_reach_;
    greatest = std::max(greatest, std::sqrt(dx * dx + dy * dy) + growth);
  }
  return !(2.0 * greatest < skin_);  // also true for a NaN position
}

void NeighbourLists::remap(std::span<const std::uint32_t> new_index) {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < built_.size(); ++i) {
    if (new_index[i] == gone) continue;
    std::uint32_t count = 0;
    for (const std::uint32_t j : of(i))
      if (new_index[j] != gone) slots_[kept * capacity_ + count++] = new_index[j];
    counts_[kept] = count;
    built_[kept] = built_[i];
    ++kept;
  }
  counts_.resize(kept);
  built_.resize(kept);
}

void NeighbourLists::build(std::span<const Body> bodies, std::span<const std::uint32_t> order,
                           double skin) {
  skin_ = skin;
  double radius = 0, range = 1;
  for (const Body& body : bodies) {
    radius = std::max(radius, body.radius);
    range = std::max(range, body.range);
  }
  growth_reach_ = range;
  sort_into_bins(bodies, order, 2.0 * radius * range + skin);

  counts_.resize(bodies.size());
  slots_.resize(bodies.size() * capacity_);
  while (!fill(bodies, order, skin)) {
    capacity_ *= 2;
    slots_.resize(bodies.size() * capacity_);
  }
  built_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    built_[i] = {bodies[i].x, bodies[i].y, bodies[i].radius};
  valid_ = true;
}

void NeighbourLists::sort_into_bins(std::span<const Body> bodies,
                                    std::span<const std::uint32_t> order, double reach) {
  double right = bodies.empty() ? 0 : bodies[0].x, top = bodies.empty() ? 0 : bodies[0].y;
  left_ = right, bottom_ = top;
  for (const Body& body : bodies) {
    left_ = std::min(left_, body.x), right = std::max(right, body.x);
    bottom_ = std::min(bottom_, body.y), top = std::max(top, body.y);
  }
  const double longest = std::max(right - left_, top - bottom_);
  bin_side_ = std::max(reach / bins_per_reach, longest / most_bins_per_side);
  columns_ = static_cast<std::uint32_t>((right - left_) / bin_side_) + 1;
  rows_ = static_cast<std::uint32_t>((top - bottom_) / bin_side_) + 1;

  // Counting sort that keeps the canonical order within a bin.
  bin_of_.resize(bodies.size());
  bin_start_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto c = static_cast<std::uint32_t>((bodies[i].x - left_) / bin_side_);
    const auto r = static_cast<std::uint32_t>((bodies[i].y - bottom_) / bin_side_);
    bin_of_[i] = std::min(r, rows_ - 1) * columns_ + std::min(c, columns_ - 1);
    ++bin_start_[bin_of_[i] + 1];
  }
  for (std::size_t b = 1; b < bin_start_.size(); ++b) bin_start_[b] += bin_start_[b - 1];
  bin_items_.resize(bodies.size());
  bin_bodies_.resize(bodies.size());
  for (const std::uint32_t i : order) {
    const std::uint32_t at = bin_start_[bin_of_[i]]++;
    bin_items_[at] = i;
    bin_bodies_[at] = {bodies[i].x, bodies[i].y, bodies[i].radius};
  }
  for (std::size_t b = bin_start_.size() - 1; b > 0; --b) bin_start_[b] = bin_start_[b - 1];
  bin_start_[0] = 0;
}

bool NeighbourLists::fill(std::span<const Body> bodies, std::span<const std::uint32_t> order,
                          double skin) {
  std::fill(counts_.begin(), counts_.end(), 0u);
  // Visiting the giver in canonical order makes every receiver's list come out in that order.
  for (const std::uint32_t j : order) {
    const Body& body = bodies[j];
    const std::uint32_t column = bin_of_[j] % columns_, row = bin_of_[j] / columns_;
    const std::uint32_t first_column = column - std::min(column, bins_per_reach);
    const std::uint32_t last_column = std::min(column + bins_per_reach, columns_ - 1);
    const std::uint32_t last_row = std::min(row + bins_per_reach, rows_ - 1);
    for (std::uint32_t r = row - std::min(row, bins_per_reach); r <= last_row; ++r) {
      const std::uint32_t begin = bin_start_[r * columns_ + first_column];
      const std::uint32_t end = bin_start_[r * columns_ + last_column + 1];
      // Most candidates fail: collect the others without branching on each.
      found_.resize(std::max<std::size_t>(found_.size(), end - begin));
      std::size_t found = 0;
      for (std::uint32_t k = begin; k < end; ++k) {
        const double dx = bin_bodies_[k].x - body.x, dy = bin_bodies_[k].y - body.y;
        const double reach = growth_reach_ * (bin_bodies_[k].radius + body.radius) + skin;
        found_[found] = bin_items_[k];
        found += dx * dx + dy * dy < reach * reach ? 1 : 0;
      }
      for (std::size_t f = 0; f < found; ++f) {
        const std::uint32_t i = found_[f];
        if (i == j) continue;
        if (counts_[i] == capacity_) return false;
        slots_[i * capacity_ + counts_[i]++] = j;
      }
    }
  }
  return true;
}

}  // namespace somas::model
