#include "core/model/morphogens.hpp"

#include <algorithm>
#include <cmath>

namespace somas::model {

namespace {

constexpr float negligible = 1e-6f;
constexpr float at_centre = 1e-6f;
constexpr double sqrt_two = 1.4142135623730951;

/// std::max by value: a select that vectorises.
inline float greater(float a, float b) { return a > b ? a : b; }

/// What a sweep multiplies by; none is negative, so scaling the greatest is scaling them all.
struct Factors {
  float keep, straight, diagonal;
};

/// One row of a sweep. Pointers are to the first column; rows are padded on both sides.
void sweep_row(const float* __restrict below, const float* __restrict row,
               const float* __restrict above, float* __restrict out, std::ptrdiff_t count,
               Factors by) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const float ns = greater(below[i], above[i]);
    const float we = greater(row[i - 1], row[i + 1]);
    const float low = greater(below[i - 1], below[i + 1]);
    const float high = greater(above[i - 1], above[i + 1]);
    const float offered = greater(greater(ns, we) * by.keep * by.straight,
                                  greater(low, high) * by.keep * by.diagonal);
    const float kept = greater(row[i] * by.keep, offered);
    out[i] = kept < negligible ? 0.0f : kept;
  }
}

}  // namespace

MorphogenFields::MorphogenFields(const MorphogenGrid& grid)
    : size_(grid.size),
      stride_(grid.size + 2 * padding),
      side_(grid.side),
      low_(-0.5 * grid.side * grid.size),
      now_(grid.kinds.size(), std::vector<float>(stride_ * stride_)),
      next_(now_),
      boxes_(grid.kinds.size()) {}

void MorphogenFields::touch(std::uint32_t left, std::uint32_t right, std::uint32_t bottom,
                            std::uint32_t top, Box& box) const {
  right = std::min(right, size_ - 1);
  top = std::min(top, size_ - 1);
  if (box.left > box.right) {
    box = {left, right, bottom, top};
    return;
  }
  box = {std::min(box.left, left), std::max(box.right, right), std::min(box.bottom, bottom),
         std::max(box.top, top)};
}

void MorphogenFields::set(std::size_t kind, std::uint32_t column, std::uint32_t row, float value) {
  now_[kind][index(column, row)] = value;
  touch(column, column, row, row, boxes_[kind]);
}

void MorphogenFields::evaporate_and_spread(const MorphogenGrid& grid) {
  for (std::size_t kind = 0; kind < now_.size(); ++kind)
    if (boxes_[kind].left <= boxes_[kind].right) sweep(kind, grid.kinds[kind]);
}

void MorphogenFields::sweep(std::size_t kind, const Morphogen& morphogen) {
  Box& box = boxes_[kind];
  std::vector<float>& now = now_[kind];
  // What is there spreads by one square; outside the box both buffers are 0.
  touch(box.left - std::min(box.left, 1u), box.right + 1, box.bottom - std::min(box.bottom, 1u),
        box.top + 1, box);
  const Factors by{static_cast<float>(1.0 - morphogen.evaporation),
                   static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation)),
                   static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation * sqrt_two))};
  for (std::uint32_t row = box.bottom; row <= box.top; ++row) {
    const float* middle = now.data() + index(box.left, row);
    sweep_row(middle - stride_, middle, middle + stride_, next_[kind].data() + index(box.left, row),
              std::ptrdiff_t{box.right} - std::ptrdiff_t{box.left} + 1, by);
  }
  now.swap(next_[kind]);
}

Footprint MorphogenFields::footprint(double x, double y) const {
  // Offsets in sides from the centre of the square that holds the point.
  const double sides_x = (x - low_) / side_, sides_y = (y - low_) / side_;
  const double column = std::floor(sides_x), row = std::floor(sides_y);
  const double last = static_cast<double>(size_);
  Footprint print;
  if (!(column >= -1 && column <= last && row >= -1 && row <= last)) return print;
  const auto fx = static_cast<float>(sides_x - (column + 0.5));
  const auto fy = static_cast<float>(sides_y - (row + 0.5));
  const auto c = static_cast<std::int32_t>(column);
  const auto r = static_cast<std::int32_t>(row);

  static constexpr std::array<float, 9> across{-1, 0, 1, -1, 0, 1, -1, 0, 1};
  static constexpr std::array<float, 9> up{-1, -1, -1, 0, 0, 0, 1, 1, 1};
  for (std::size_t k = 0; k < 9; ++k) {
    const float dx = fx - across[k], dy = fy - up[k];
    print.weight[k] = 1.0f / std::sqrt(dx * dx + dy * dy);
  }
  if (fx * fx + fy * fy < at_centre * at_centre) {
    print.weight = {};
    print.weight[4] = 1.0f;
  }
  // The block may hang over the edge: such squares do not count, and stay in the padding.
  const auto size = static_cast<std::int32_t>(size_);
  if (c < 1 || r < 1 || c > size - 2 || r > size - 2) {
    for (int k = 0; k < 9; ++k) {
      const int cc = c + k % 3 - 1, rr = r + k / 3 - 1;
      if (cc < 0 || rr < 0 || cc >= size || rr >= size)
        print.weight[static_cast<std::size_t>(k)] = 0;
    }
  }
  for (const float w : print.weight) {
    print.sum += w;
    print.peak = std::max(print.peak, w);
  }
  print.column = c;
  print.row = r;
  return print;
}

float MorphogenFields::sense(std::size_t kind, const Footprint& at) const {
  if (at.sum == 0) return 0;
  const float* values = now_[kind].data();
  float total = 0;
  for (std::size_t k = 0; k < 9; ++k) total += values[square(at, k)] * at.weight[k];
  return total / at.sum;
}

Gradient MorphogenFields::gradient(std::size_t kind, double x, double y) const {
  const double column = std::floor((x - low_) / side_), row = std::floor((y - low_) / side_);
  const double last = static_cast<double>(size_);
  if (!(column >= -1 && column <= last && row >= -1 && row <= last)) return {};

  // The block's edges, clipped to the grid.
  const auto low = [](double middle) {
    return static_cast<std::uint32_t>(std::max(middle, 1.0) - 1);
  };
  const auto high = [&](double middle) {
    return static_cast<std::uint32_t>(std::min(middle + 1, last - 1));
  };
  const std::uint32_t left = low(column), right = high(column), bottom = low(row), top = high(row);
  const std::uint32_t columns = right - left + 1, rows = top - bottom + 1;

  Gradient slope;
  for (std::uint32_t r = bottom; r <= top; ++r)
    slope.x += static_cast<double>(value(kind, right, r)) - value(kind, left, r);
  for (std::uint32_t c = left; c <= right; ++c)
    slope.y += static_cast<double>(value(kind, c, top)) - value(kind, c, bottom);
  if (columns > 1) slope.x /= rows * (columns - 1) * side_;
  if (rows > 1) slope.y /= columns * (rows - 1) * side_;
  return slope;
}

void MorphogenFields::deposit(std::size_t kind, const Footprint& at, float amount, Deposit rule) {
  if (at.sum == 0 || !(amount > 0)) return;
  const float unit = amount / (rule == Deposit::peak ? at.peak : at.sum);
  float* values = now_[kind].data();
  for (std::size_t k = 0; k < 9; ++k) {
    float& held = values[square(at, k)];
    held = std::max(held, at.weight[k] * unit);
  }
  const auto clip = [&](std::int32_t i) {
    return static_cast<std::uint32_t>(std::clamp(i, 0, static_cast<std::int32_t>(size_) - 1));
  };
  touch(clip(at.column - 1), clip(at.column + 1), clip(at.row - 1), clip(at.row + 1), boxes_[kind]);
}

}  // namespace somas::model
