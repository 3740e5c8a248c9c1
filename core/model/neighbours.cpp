#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/cells.hpp"

namespace somas::model {

namespace {

// Bins finer than the reach waste fewer candidates in the corners.
constexpr std::uint32_t bins_per_reach = 2;
// Mending a list looks at every body: beyond so many, building all lists is cheaper.
constexpr std::size_t most_mended = 32;

bool placed(const Body& body) {
  constexpr double absurd = 1e150;
  return std::abs(body.x) < absurd && std::abs(body.y) < absurd;
}

}  // namespace

double NeighbourLists::drift(const Body& body, const Built& built) const {
  const double dx = body.x - built.x, dy = body.y - built.y;
  const double growth = std::max(0.0, body.radius - built.radius) * growth_reach_;
  return std::sqrt(dx * dx + dy * dy) + growth;
}

bool NeighbourLists::usable(std::span<const Body> bodies) const {
  if (!valid_ || built_.size() != bodies.size()) return false;
  double range = 1;
  for (const Body& body : bodies) range = std::max(range, body.range);
  return range <= growth_reach_;
}

bool NeighbourLists::stale(std::span<const Body> bodies) const {
  if (!usable(bodies)) return true;
  // Two cells approach by at most both displacements, and their reach grows by both growths: a pair
  // is safe while both have drifted less than half the skin. A newcomer's drift is NaN.
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!(2.0 * drift(bodies[i], built_[i]) < skin_)) return true;
  return false;
}

void NeighbourLists::remap(std::span<const std::uint32_t> new_index) {
  if (!valid_) return;
  const auto count = static_cast<std::size_t>(
      std::count_if(new_index.begin(), new_index.end(), [](std::uint32_t n) { return n != gone; }));
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  other_slots_.resize(count * capacity_);
  other_counts_.assign(count, 0);
  other_built_.assign(count, Built{unknown, unknown, unknown});
  for (std::uint32_t i = 0; i < built_.size(); ++i) {
    const std::uint32_t to = new_index[i];
    if (to == gone) continue;
    for (const std::uint32_t j : of(i))
      if (new_index[j] != gone) other_slots_[to * capacity_ + other_counts_[to]++] = new_index[j];
    other_built_[to] = built_[i];
  }
  slots_.swap(other_slots_);
  counts_.swap(other_counts_);
  built_.swap(other_built_);
}

void NeighbourLists::refresh(std::span<const Body> bodies, std::span<const std::uint32_t> order,
                             std::span<const std::uint32_t> rank, double skin) {
  if (skin != skin_ || !usable(bodies)) return build(bodies, order, skin);

  movers_.clear();
  for (std::uint32_t i = 0; i < bodies.size(); ++i)
    if (!(2.0 * drift(bodies[i], built_[i]) < skin_)) movers_.push_back(i);
  const std::size_t few = std::min<std::size_t>(most_mended, bodies.size() / 16 + 1);
  if (movers_.size() > few) return build(bodies, order, skin);
  for (const std::uint32_t i : movers_)
    if (!mend(i, bodies, order, rank)) return build(bodies, order, skin);
}

bool NeighbourLists::within(const Built& a, const Built& b) const {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double reach = growth_reach_ * (b.radius + a.radius) + skin_;
  return dx * dx + dy * dy < reach * reach;
}

void NeighbourLists::erase(std::uint32_t body, std::uint32_t neighbour) {
  std::uint32_t* list = slots_.data() + body * capacity_;
  std::uint32_t* end = std::remove(list, list + counts_[body], neighbour);
  counts_[body] = static_cast<std::uint32_t>(end - list);
}

bool NeighbourLists::insert(std::uint32_t body, std::uint32_t neighbour,
                            std::span<const std::uint32_t> rank) {
  if (counts_[body] == capacity_) return false;
  std::uint32_t* list = slots_.data() + body * capacity_;
  std::uint32_t at = counts_[body]++;
  for (; at > 0 && rank[list[at - 1]] > rank[neighbour]; --at) list[at] = list[at - 1];
  list[at] = neighbour;
  return true;
}

bool NeighbourLists::mend(std::uint32_t body, std::span<const Body> bodies,
                          std::span<const std::uint32_t> order,
                          std::span<const std::uint32_t> rank) {
  for (const std::uint32_t j : of(body)) erase(j, body);
  counts_[body] = 0;
  built_[body] = {bodies[body].x, bodies[body].y, bodies[body].radius};
  // The others stand where they stood when they were listed: that is what drifts are measured from.
  // Most are far off: collect the rest without branching on each.
  found_.resize(std::max(found_.size(), order.size()));
  std::size_t found = 0;
  for (const std::uint32_t j : order) {
    found_[found] = j;
    found += within(built_[body], built_[j]) ? 1 : 0;
  }
  for (std::size_t f = 0; f < found; ++f) {
    const std::uint32_t j = found_[f];
    if (j == body) continue;
    if (counts_[body] == capacity_ || !insert(j, body, rank)) return false;
    slots_[body * capacity_ + counts_[body]++] = j;
  }
  return true;
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
  bin_side_ = std::max({reach / bins_per_reach, longest / most_bins,
                        std::sqrt((right - left_) * (top - bottom_) / most_bins)});
  columns_ = static_cast<std::uint32_t>((right - left_) / bin_side_) + 1;
  rows_ = static_cast<std::uint32_t>((top - bottom_) / bin_side_) + 1;

  // Counting sort that keeps the canonical order within a bin.
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
