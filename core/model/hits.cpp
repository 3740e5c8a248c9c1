#include "core/model/hits.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

constexpr std::uint32_t nobody = 0xFFFFFFFFu;

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

void HitFinder::prepare(std::span<const Body> bodies, const DiscBins& bins,
                        std::span<const std::uint32_t> cells, std::span<const std::uint32_t> rank) {
  bodies_ = bodies;
  cells_ = cells;
  rank_ = rank;
  bins_ = &bins;
  mark_inhabited();
}

void HitFinder::mark_inhabited() {
  // A bin counts when it or one of the eight round it holds a cell. There is one bin more on every
  // side, so that what starts in it needs no other question.
  const std::size_t columns = bins_->columns(), rows = bins_->rows();
  const std::size_t stride = columns + 2;
  around_.assign(stride * (rows + 2), 0);
  inhabited_.assign(columns + 4, 0);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c)
      inhabited_[c + 2] =
          bins_->start(r * columns + c) != bins_->start(r * columns + c + 1) ? 1 : 0;
    const std::uint8_t* here = inhabited_.data();
    for (std::size_t near = r; near < r + 3; ++near)
      for (std::size_t c = 0; c < stride; ++c)
        around_[near * stride + c] |= here[c] | here[c + 1] | here[c + 2];
  }
}

void HitFinder::first(std::span<const Segment> segments, std::span<std::int32_t> hits) const {
  for (std::size_t i = 0; i < segments.size(); ++i) hits[i] = first(segments[i]);
}

/// Of a path no longer than a bin's side: only cells of the bins round its start can be met.
bool HitFinder::far_from_all(const Segment& s, double length) const {
  if (!(length + bins_->widest() < 0.999 * bins_->side())) return false;
  const double column = (s.x0 - bins_->left()) * bins_->per_length() + 1;
  const double row = (s.y0 - bins_->bottom()) * bins_->per_length() + 1;
  const std::uint32_t columns = bins_->columns() + 2, rows = bins_->rows() + 2;
  if (!((column >= 0) & (column < columns) & (row >= 0) & (row < rows))) return true;
  return around_[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column)] == 0;
}

std::int32_t HitFinder::first(const Segment& s) const {
  const double x_low = std::min(s.x0, s.x1) - bins_->left();
  const double x_high = std::max(s.x0, s.x1) - bins_->left();
  const double y_low = std::min(s.y0, s.y1) - bins_->bottom();
  const double y_high = std::max(s.y0, s.y1) - bins_->bottom();
  const double length = (x_high - x_low) + (y_high - y_low);  // at least the path's
  if (!(length >= 0) || far_from_all(s, length)) return -1;
  // Only discs whose centre lies within the widest reach of the path's bounds can be met.
  const auto bin = [this](double v, std::uint32_t bins) {
    return static_cast<std::size_t>(std::clamp(v * bins_->per_length(), 0.0, double(bins - 1)));
  };
  const double widest = bins_->widest();
  const std::size_t c0 = bin(x_low - widest, bins_->columns());
  const std::size_t c1 = bin(x_high + widest, bins_->columns());
  const std::size_t r0 = bin(y_low - widest, bins_->rows());
  const std::size_t r1 = bin(y_high + widest, bins_->rows());
  const auto x = static_cast<float>(s.x0 - bins_->left());
  const auto y = static_cast<float>(s.y0 - bins_->bottom());
  const auto way = static_cast<float>(length * (1 + 4 * DiscBins::rounding));
  std::uint32_t best = nobody;
  double best_distance = 2;
  for (std::size_t r = r0; r <= r1; ++r) {
    const std::uint32_t begin = bins_->start(r * bins_->columns() + c0);
    const std::uint32_t end = bins_->start(r * bins_->columns() + c1 + 1);
    for (std::uint32_t k = begin; k < end; k += 8) {
      // Most candidates are too far off to be met at all.
      constexpr EightMask lanes{0, 1, 2, 3, 4, 5, 6, 7};
      EightFloats xs, ys, reach;
      std::memcpy(&xs, bins_->x() + k, sizeof xs);
      std::memcpy(&ys, bins_->y() + k, sizeof ys);
      std::memcpy(&reach, bins_->reach() + k, sizeof reach);
      const EightFloats dx = xs - x, dy = ys - y;
      reach += way;
      const EightMask near =
          (dx * dx + dy * dy <= reach * reach) & (lanes < static_cast<std::int32_t>(end - k));
      for (std::uint32_t set = bits_of(near); set != 0; set &= set - 1) {
        const std::uint32_t place =
            bins_->items()[k + static_cast<std::uint32_t>(std::countr_zero(set))];
        const Body& body = bodies_[place];
        const double t = meeting(s, body.x, body.y, body.radius);
        if (t < 0 || t > best_distance || (t == best_distance && is_later(place, best))) continue;
        best = place;
        best_distance = t;
      }
    }
  }
  return best == nobody ? -1 : static_cast<std::int32_t>(cells_[best]);
}

}  // namespace somas::model
