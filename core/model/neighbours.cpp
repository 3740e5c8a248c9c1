#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>

namespace somas::model {

namespace {

constexpr std::uint32_t most_bins_per_side = 4096;

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
  bin_side_ = std::max(reach, longest / most_bins_per_side);
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
    const std::uint32_t first_column = column - std::min(column, 1u);
    const std::uint32_t last_column = std::min(column + 1, columns_ - 1);
    for (std::uint32_t r = row - std::min(row, 1u); r <= std::min(row + 1, rows_ - 1); ++r) {
      const std::uint32_t begin = bin_start_[r * columns_ + first_column];
      const std::uint32_t end = bin_start_[r * columns_ + last_column + 1];
      for (std::uint32_t k = begin; k < end; ++k) {
        const double dx = bin_bodies_[k].x - body.x, dy = bin_bodies_[k].y - body.y;
        const double reach = growth_reach_ * (bin_bodies_[k].radius + body.radius) + skin;
        if (dx * dx + dy * dy >= reach * reach) continue;
        const std::uint32_t i = bin_items_[k];
        if (i == j) continue;
        if (counts_[i] == capacity_) return false;
        slots_[i * capacity_ + counts_[i]++] = j;
      }
    }
  }
  return true;
}

}  // namespace somas::model
