#include "core/model/morphogens.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

constexpr float negligible = 1e-6f;
constexpr float at_centre = 1e-6f;
constexpr double sqrt_two = 1.4142135623730951;

/// std::max by value: a select that vectorises.
inline float greater(float a, float b) { return a > b ? a : b; }

/// The squares of a block from the lower left, as seen from its middle.
constexpr std::array<float, 9> across{-1, 0, 1, -1, 0, 1, -1, 0, 1};
constexpr std::array<float, 9> up{-1, -1, -1, 0, 0, 0, 1, 1, 1};

/// Where the weight of the k-th square stands in a footprint.
constexpr std::size_t spot(std::size_t k) { return k / 3 * 4 + k % 3; }

inline float inverse_distance(float dx, float dy) { return 1.0f / std::sqrt(dx * dx + dy * dy); }

/// What a sweep multiplies by; none is negative, so scaling the greatest is scaling them all.
struct Factors {
  float keep, straight, diagonal;
};

/// Some rows of a sweep at once, which share what they read. Pointers are to the first column of
/// the first row; rows are `stride` apart and padded on both sides.
template <std::ptrdiff_t Rows>
void sweep_rows(const float* __restrict now, float* __restrict next, std::ptrdiff_t stride,
                std::ptrdiff_t count, Factors by) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    float value[Rows + 2], beside[Rows + 2];  // from the row below to the row above
    for (std::ptrdiff_t r = 0; r < Rows + 2; ++r) {
      const float* at = now + (r - 1) * stride + i;
      value[r] = at[0];
      beside[r] = greater(at[-1], at[1]);
    }
    for (std::ptrdiff_t r = 0; r < Rows; ++r) {
      const float straight = greater(greater(value[r], value[r + 2]), beside[r + 1]);
      const float diagonal = greater(beside[r], beside[r + 2]);
      const float offered =
          greater(straight * by.keep * by.straight, diagonal * by.keep * by.diagonal);
      const float kept = greater(value[r + 1] * by.keep, offered);
      next[r * stride + i] = kept < negligible ? 0.0f : kept;
    }
  }
}

/// Four squares of a row keep the maximum of their value and what they are offered.
inline void raise(float* values, const float* weights, float unit) {
  FourFloats held, weight;
  std::memcpy(&held, values, sizeof held);
  std::memcpy(&weight, weights, sizeof weight);
  const FourFloats offered = weight * unit;
  held = held < offered ? offered : held;
  std::memcpy(values, &held, sizeof held);
}

}  // namespace

MorphogenFields::MorphogenFields(const MorphogenGrid& grid)
    : size_(grid.size),
      stride_(grid.size + 2 * padding),
      side_(grid.side),
      low_(-0.5 * grid.side * grid.size),
      now_(grid.kinds.size(), std::vector<float>(stride_ * stride_ + slack)),
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
  for (std::size_t kind = 0; kind < now_.size(); ++kind) {
    const std::uint32_t rows = begin_sweep(kind);
    if (rows == 0) continue;
    sweep(kind, grid.kinds[kind], 0, rows);
    end_sweep(kind);
  }
}

std::uint32_t MorphogenFields::begin_sweep(std::size_t kind) {
  Box& box = boxes_[kind];
  if (box.left > box.right) return 0;
  // What is there spreads by one square; outside the box both buffers are 0.
  touch(box.left - std::min(box.left, 1u), box.right + 1, box.bottom - std::min(box.bottom, 1u),
        box.top + 1, box);
  return box.top - box.bottom + 1;
}

void MorphogenFields::sweep(std::size_t kind, const Morphogen& morphogen, std::uint32_t first,
                            std::uint32_t rows) {
  const Box& box = boxes_[kind];
  const Factors by{static_cast<float>(1.0 - morphogen.evaporation),
                   static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation)),
                   static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation * sqrt_two))};
  const std::ptrdiff_t count = std::ptrdiff_t{box.right} - std::ptrdiff_t{box.left} + 1;
  const auto stride = static_cast<std::ptrdiff_t>(stride_);
  const std::size_t begin = index(box.left, box.bottom + first);
  const float* now = now_[kind].data() + begin;
  float* next = next_[kind].data() + begin;
  for (; rows >= 4; rows -= 4, now += 4 * stride, next += 4 * stride)
    sweep_rows<4>(now, next, stride, count, by);
  for (; rows > 0; --rows, now += stride, next += stride)
    sweep_rows<1>(now, next, stride, count, by);
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

  for (std::size_t k = 0; k < 9; ++k)
    print.weight[spot(k)] = inverse_distance(fx - across[k], fy - up[k]);
  if (fx * fx + fy * fy < at_centre * at_centre) {
    print.weight = {};
    print.weight[spot(4)] = 1.0f;
  }
  // The block may hang over the edge: such squares do not count, and stay in the padding.
  const auto size = static_cast<std::int32_t>(size_);
  if (c < 1 || r < 1 || c > size - 2 || r > size - 2) {
    for (int k = 0; k < 9; ++k) {
      const int cc = c + k % 3 - 1, rr = r + k / 3 - 1;
      if (cc < 0 || rr < 0 || cc >= size || rr >= size)
        print.weight[spot(static_cast<std::size_t>(k))] = 0;
    }
  }
  for (std::size_t k = 0; k < 9; ++k) {
    print.sum += print.weight[spot(k)];
    print.peak = std::max(print.peak, print.weight[spot(k)]);
  }
  print.column = c;
  print.row = r;
  return print;
}

float MorphogenFields::sense(std::size_t kind, const Footprint& at) const {
  if (at.sum == 0) return 0;
  const float* values = now_[kind].data() + corner(at);
  float total = 0;
  for (std::size_t k = 0; k < 9; ++k) total += values[k / 3 * stride_ + k % 3] * at.weight[spot(k)];
  return total / at.sum;
}

/// Points side by side, each a lane: a lane sees the same operations in the same order whatever its
/// place.
struct MorphogenFields::Block {
  static constexpr std::size_t width = 32;
  std::size_t lanes = 0;  ///< in use; a multiple of eight, the last point repeated
  double x[width], y[width];
  std::int32_t column[width], row[width];  ///< of the middle square
  std::int32_t corner[width];
  float weight[9][width];
  float sum[width], peak[width];
};

void MorphogenFields::survey(std::span<const double> x, std::span<const double> y,
                             std::span<Footprint> prints, Matrix<float> sensed) const {
  Block block;
  for (std::size_t begin = 0; begin < x.size(); begin += Block::width) {
    const std::size_t count = std::min(Block::width, x.size() - begin);
    block.lanes = (count + 7) / 8 * 8;
    for (std::size_t l = 0; l < block.lanes; ++l) {
      block.x[l] = x[begin + std::min(l, count - 1)];
      block.y[l] = y[begin + std::min(l, count - 1)];
    }
    place(block);
    for (std::uint32_t kind = 0; kind < sensed.channels; ++kind) {
      float found[Block::width];
      sense(kind, block, found);
      std::copy_n(found, count, sensed.channel(kind).data() + begin);
    }
    print(block, prints.subspan(begin, count));
  }
}

void MorphogenFields::print(const Block& block, std::span<Footprint> prints) const {
  for (std::size_t l = 0; l < prints.size(); ++l) {
    Footprint& print = prints[l];
    print.column = block.column[l];
    print.row = block.row[l];
    for (std::size_t k = 0; k < 9; ++k) print.weight[spot(k)] = block.weight[k][l];
    print.sum = block.sum[l];
    print.peak = block.peak[l];
  }
}

void MorphogenFields::place(Block& block) const {
  // As footprint() does it, for points whose block is on the grid and that are at no centre.
  float fx[Block::width], fy[Block::width];
  bool plain[Block::width];
  const double last_inner = static_cast<double>(size_) - 2;
  for (std::size_t l = 0; l < block.lanes; ++l) {
    const double sides_x = (block.x[l] - low_) / side_, sides_y = (block.y[l] - low_) / side_;
    const double column = std::floor(sides_x), row = std::floor(sides_y);
    const bool inside = (column >= 1) & (column <= last_inner) & (row >= 1) & (row <= last_inner);
    fx[l] = static_cast<float>(sides_x - (column + 0.5));
    fy[l] = static_cast<float>(sides_y - (row + 0.5));
    plain[l] = inside & !(fx[l] * fx[l] + fy[l] * fy[l] < at_centre * at_centre);
    block.column[l] = static_cast<std::int32_t>(inside ? column : 1.0);
    block.row[l] = static_cast<std::int32_t>(inside ? row : 1.0);
  }
  for (std::size_t k = 0; k < 9; ++k)
    for (std::size_t l = 0; l < block.lanes; ++l)
      block.weight[k][l] = inverse_distance(fx[l] - across[k], fy[l] - up[k]);
  for (std::size_t l = 0; l < block.lanes; ++l) {
    float sum = 0, peak = 0;
    for (std::size_t k = 0; k < 9; ++k) {
      sum += block.weight[k][l];
      peak = greater(block.weight[k][l], peak);
    }
    block.sum[l] = sum;
    block.peak[l] = peak;
  }

  // The others one by one.
  for (std::size_t l = 0; l < block.lanes; ++l) {
    if (plain[l]) continue;
    const Footprint print = footprint(block.x[l], block.y[l]);
    block.column[l] = print.column;
    block.row[l] = print.row;
    for (std::size_t k = 0; k < 9; ++k) block.weight[k][l] = print.weight[spot(k)];
    block.sum[l] = print.sum;
    block.peak[l] = print.peak;
  }
  const auto stride = static_cast<std::int32_t>(stride_);
  for (std::size_t l = 0; l < block.lanes; ++l)
    block.corner[l] = (block.row[l] + 1) * stride + block.column[l] + 1;
}

void MorphogenFields::sense(std::size_t kind, const Block& block, float* sensed) const {
  const float* values = now_[kind].data();
  const auto stride = static_cast<std::int32_t>(stride_);
  for (std::size_t l = 0; l < block.lanes; ++l) {
    float total = 0;
    for (std::int32_t k = 0; k < 9; ++k)
      total += values[block.corner[l] + k / 3 * stride + k % 3] * block.weight[k][l];
    const float mean = total / block.sum[l];
    sensed[l] = block.sum[l] == 0 ? 0.0f : mean;
  }
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
  deposit(kind, {&at, 1}, {&amount, 1}, rule);
}

void MorphogenFields::deposit(std::size_t kind, std::span<const Footprint> prints,
                              std::span<const float> amounts, Deposit rule) {
  Middles middles;
  float* values = now_[kind].data();
  for (std::size_t i = 0; i < prints.size(); ++i) {
    const Footprint& at = prints[i];
    if (at.sum == 0 || !(amounts[i] > 0)) continue;
    const float unit = amounts[i] / (rule == Deposit::peak ? at.peak : at.sum);
    // The square behind each row has no weight, and keeps its value.
    float* block = values + corner(at);
    for (std::size_t r = 0; r < 3; ++r) raise(block + r * stride_, &at.weight[4 * r], unit);
    middles.add(at);
  }
  cover(kind, middles);
}

void MorphogenFields::cover(std::size_t kind, const Middles& middles) {
  if (middles.left > middles.right) return;
  const auto clip = [&](std::int32_t i) {
    return static_cast<std::uint32_t>(std::clamp(i, 0, static_cast<std::int32_t>(size_) - 1));
  };
  touch(clip(middles.left - 1), clip(middles.right + 1), clip(middles.bottom - 1),
        clip(middles.top + 1), boxes_[kind]);
}

}  // namespace somas::model
