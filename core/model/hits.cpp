#include "core/model/hits.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

constexpr std::int32_t most_bins_per_side = 1024;
constexpr double absurd = 1e150;

}  // namespace

double meeting(const Segment& s, double x, double y, double radius) {
  const double fx = s.x0 - x, fy = s.y0 - y;
  const double outside = fx * fx + fy * fy - radius * radius;
  if (outside <= 0) return 0;
  const double dx = s.x1 - s.x0, dy = s.y1 - s.y0;
  const double towards = fx * dx + fy * dy;
  if (towards >= 0) return -1;
  const double square = dx * dx + dy * dy;
  const double discriminant = towards * towards - square * outside;
  if (discriminant < 0) return -1;
  const double t = (-towards - std::sqrt(discriminant)) / square;
  return t <= 1 ? t : -1;
}

void HitFinder::prepare(const CellStore& cells) {
  // Cells that an absurd force threw out of all bounds cannot be met; the step buries them.
  placed_.clear();
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    if (std::abs(cells.x[i]) < absurd && std::abs(cells.y[i]) < absurd) placed_.push_back(i);
  widest_ = 0;
  left_ = bottom_ = std::numeric_limits<double>::infinity();
  right_ = top_ = -std::numeric_limits<double>::infinity();
  if (placed_.empty()) return;
  for (const std::uint32_t i : placed_) {
    widest_ = std::max(widest_, cells.radius[i]);
    left_ = std::min(left_, cells.x[i]), right_ = std::max(right_, cells.x[i]);
    bottom_ = std::min(bottom_, cells.y[i]), top_ = std::max(top_, cells.y[i]);
  }
  left_ -= widest_, right_ += widest_;
  bottom_ -= widest_, top_ += widest_;
  side_ = std::max(2.0 * widest_, std::max(right_ - left_, top_ - bottom_) / most_bins_per_side);
  columns_ = static_cast<std::int32_t>((right_ - left_) / side_) + 1;
  rows_ = static_cast<std::int32_t>((top_ - bottom_) / side_) + 1;

  // Counting sort by the bin of the centre.
  bin_.resize(cells.size());
  items_.resize(placed_.size());
  start_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const std::uint32_t i : placed_) {
    const auto c = static_cast<std::int32_t>((cells.x[i] - left_) / side_);
    const auto r = static_cast<std::int32_t>((cells.y[i] - bottom_) / side_);
    bin_[i] = static_cast<std::uint32_t>(r * columns_ + c);
    ++start_[bin_[i] + 1];
  }
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  for (auto* column : {&x_, &y_, &radius_}) column->resize(placed_.size() + 3);
  for (const std::uint32_t i : placed_) {
    const std::uint32_t at = start_[bin_[i]]++;
    items_[at] = i;
    x_[at] = cells.x[i];
    y_[at] = cells.y[i];
    radius_[at] = cells.radius[i];
  }
  for (std::size_t b = start_.size() - 1; b > 0; --b) start_[b] = start_[b - 1];
  start_[0] = 0;
  mark_inhabited();
}

void HitFinder::mark_inhabited() {
  // A bin counts when it or one of the eight round it holds a cell: first along rows, with a bin on
  // either side that is not there, then along columns.
  const auto columns = static_cast<std::size_t>(columns_), rows = static_cast<std::size_t>(rows_);
  const std::size_t bins = columns * rows;
  inhabited_.assign(columns + 2, 0);
  around_.assign(bins, 0);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c)
      inhabited_[c + 1] = start_[r * columns + c] != start_[r * columns + c + 1] ? 1 : 0;
    const std::uint8_t* here = inhabited_.data();
    for (std::size_t near = r > 0 ? r - 1 : 0; near < std::min(r + 2, rows); ++near)
      for (std::size_t c = 0; c < columns; ++c)
        around_[near * columns + c] |= here[c] | here[c + 1] | here[c + 2];
  }
}

bool HitFinder::overlaps(const Segment& s) const {
  // Two coordinates at a time, and no branch: most segments are far from all cells.
  Two from, to;
  std::memcpy(&from, &s.x0, sizeof from);
  std::memcpy(&to, &s.x1, sizeof to);
  const Two high = from < to ? to : from, low = to < from ? to : from;
  const TwoMask within = (high >= Two{left_, bottom_}) & (low <= Two{right_, top_});
  return (within[0] & within[1]) != 0;
}

void HitFinder::first(const CellStore& cells, std::span<const Segment> segments,
                      std::span<std::int32_t> hits) {
  // Most are far from all cells: collect the others without branching on each.
  near_.resize(std::max(near_.size(), segments.size()));
  std::size_t near = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    hits[i] = -1;
    near_[near] = static_cast<std::uint32_t>(i);
    near += overlaps(segments[i]) ? 1 : 0;
  }
  for (std::size_t k = 0; k < near; ++k) hits[near_[k]] = nearest(cells, segments[near_[k]]);
}

std::int32_t HitFinder::first(const CellStore& cells, const Segment& segment) const {
  return overlaps(segment) ? nearest(cells, segment) : -1;
}

std::int32_t HitFinder::nearest(const CellStore& cells, const Segment& s) const {
  const double x_low = std::min(s.x0, s.x1), x_high = std::max(s.x0, s.x1);
  const double y_low = std::min(s.y0, s.y1), y_high = std::max(s.y0, s.y1);
  // Only discs whose centre lies within the widest radius of the path's bounds can be met.
  const auto clip = [](double v, std::int32_t last) {
    return static_cast<std::int32_t>(std::clamp(v, 0.0, static_cast<double>(last)));
  };
  const double length = (x_high - x_low) + (y_high - y_low);  // at least the path's
  // A short path meets only cells of the bins round its start.
  if (length + widest_ < 0.999 * side_) {
    const std::int32_t c = clip((s.x0 - left_) / side_, columns_ - 1);
    const std::int32_t r = clip((s.y0 - bottom_) / side_, rows_ - 1);
    if (around_[static_cast<std::size_t>(r * columns_ + c)] == 0) return -1;
  }
  const std::int32_t c0 = clip((x_low - widest_ - left_) / side_, columns_ - 1);
  const std::int32_t c1 = clip((x_high + widest_ - left_) / side_, columns_ - 1);
  const std::int32_t r0 = clip((y_low - widest_ - bottom_) / side_, rows_ - 1);
  const std::int32_t r1 = clip((y_high + widest_ - bottom_) / side_, rows_ - 1);
  std::int32_t best = -1;
  double best_distance = 2;
  for (std::int32_t r = r0; r <= r1; ++r) {
    const std::size_t row = static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_);
    const std::uint32_t begin = start_[row + static_cast<std::size_t>(c0)];
    const std::uint32_t end = start_[row + static_cast<std::size_t>(c1) + 1];
    for (std::uint32_t k = begin; k < end; k += 4) {
      // Most candidates are too far off to be met at all.
      constexpr FourMask lanes{0, 1, 2, 3};
      Four x, y, radius;
      read(&x_[k], x);
      read(&y_[k], y);
      read(&radius_[k], radius);
      const Four fx = s.x0 - x, fy = s.y0 - y, reach = length + radius;
      const FourMask far = (fx * fx + fy * fy > reach * reach) | (lanes >= std::int64_t{end - k});
      if ((far[0] & far[1] & far[2] & far[3]) != 0) continue;
      for (std::uint32_t lane = 0; lane < 4; ++lane) {
        if (far[lane] != 0) continue;
        const std::uint32_t i = items_[k + lane];
        const double t = meeting(s, x[lane], y[lane], radius[lane]);
        if (t < 0 || t > best_distance) continue;
        if (t == best_distance && cells.rank[i] > cells.rank[static_cast<std::size_t>(best)])
          continue;
        best = static_cast<std::int32_t>(i);
        best_distance = t;
      }
    }
  }
  return best;
}

}  // namespace somas::model
