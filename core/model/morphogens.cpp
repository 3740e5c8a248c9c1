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

/// The squares of a block from the lower left, as seen from its middle.
constexpr std::array<float, 9> across{-1, 0, 1, -1, 0, 1, -1, 0, 1};
constexpr std::array<float, 9> up{-1, -1, -1, 0, 0, 0, 1, 1, 1};

/// Where the weight of the k-th square stands in a footprint.
constexpr std::size_t spot(std::size_t k) { return k / 3 * 4 + k % 3; }

inline float inverse_distance(float dx, float dy) { return 1.0f / std::sqrt(dx * dx + dy * dy); }

// As many points at a time as a register holds; their rows become columns and columns rows. Only
// three of four matter: a row's fourth value is read with the others, and written as 0.
#ifdef __AVX__

using Points = EightFloats;

inline void square_root(const Points& x, Points& root) {
  root = Points{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3]),
                std::sqrt(x[4]), std::sqrt(x[5]), std::sqrt(x[6]), std::sqrt(x[7])};
}

/// Each half by itself.
inline void turn(const Points (&row)[4], Points (&column)[4]) {
  const auto low01 = __builtin_shufflevector(row[0], row[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const auto high01 = __builtin_shufflevector(row[0], row[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const auto low23 = __builtin_shufflevector(row[2], row[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const auto high23 = __builtin_shufflevector(row[2], row[3], 2, 10, 3, 11, 6, 14, 7, 15);
  column[0] = __builtin_shufflevector(low01, low23, 0, 1, 8, 9, 4, 5, 12, 13);
  column[1] = __builtin_shufflevector(low01, low23, 2, 3, 10, 11, 6, 7, 14, 15);
  column[2] = __builtin_shufflevector(high01, high23, 0, 1, 8, 9, 4, 5, 12, 13);
  column[3] = __builtin_shufflevector(high01, high23, 2, 3, 10, 11, 6, 7, 14, 15);
}

inline void read_columns(const float* values, const std::int32_t (&at)[8], Points (&column)[4]) {
  Points row[4];
  for (std::size_t l = 0; l < 4; ++l) {
    FourFloats first, second;
    std::memcpy(&first, values + at[l], sizeof first);
    std::memcpy(&second, values + at[l + 4], sizeof second);
    row[l] = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  turn(row, column);
}

inline void to_rows(const Points* column, FourFloats (&row)[8]) {
  const Points columns[4] = {column[0], column[1], column[2], Points{}};
  Points rows[4];
  turn(columns, rows);
  for (std::size_t l = 0; l < 4; ++l) {
    row[l] = __builtin_shufflevector(rows[l], rows[l], 0, 1, 2, 3);
    row[l + 4] = __builtin_shufflevector(rows[l], rows[l], 4, 5, 6, 7);
  }
}

#else

using Points = FourFloats;

inline void square_root(const Points& x, Points& root) {
  root = Points{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}

inline void turn(const Points (&row)[4], Points (&column)[4]) {
  const auto low01 = __builtin_shufflevector(row[0], row[1], 0, 4, 1, 5);
  const auto high01 = __builtin_shufflevector(row[0], row[1], 2, 6, 3, 7);
  const auto low23 = __builtin_shufflevector(row[2], row[3], 0, 4, 1, 5);
  const auto high23 = __builtin_shufflevector(row[2], row[3], 2, 6, 3, 7);
  column[0] = __builtin_shufflevector(low01, low23, 0, 1, 4, 5);
  column[1] = __builtin_shufflevector(low01, low23, 2, 3, 6, 7);
  column[2] = __builtin_shufflevector(high01, high23, 0, 1, 4, 5);
  column[3] = __builtin_shufflevector(high01, high23, 2, 3, 6, 7);
}

inline void read_columns(const float* values, const std::int32_t (&at)[4], Points (&column)[4]) {
  Points row[4];
  for (std::size_t l = 0; l < 4; ++l) std::memcpy(&row[l], values + at[l], sizeof row[l]);
  turn(row, column);
}

inline void to_rows(const Points* column, FourFloats (&row)[4]) {
  const Points columns[4] = {column[0], column[1], column[2], Points{}};
  turn(columns, row);
}

#endif

/// std::max by value, of numbers or of lanes.
template <class Floats>
inline Floats greater(Floats a, Floats b) {
  return a > b ? a : b;
}

/// What a sweep multiplies by; none is negative, so scaling the greatest is scaling them all.
struct Factors {
  float keep, straight, diagonal;
};

/// Some squares side by side of some rows of a sweep at once, which share what they read. Pointers
/// are to the first of the first row; rows are `stride` apart and padded on both sides.
template <std::ptrdiff_t Rows, class Floats>
[[gnu::always_inline]] inline void sweep_some(const float* now, float* next, std::ptrdiff_t stride,
                                              Factors by) {
  Floats value[Rows + 2], beside[Rows + 2];  // from the row below to the row above
#pragma GCC unroll 8
  for (std::ptrdiff_t r = 0; r < Rows + 2; ++r) {
    const float* at = now + (r - 1) * stride;
    Floats left, right;
    std::memcpy(&left, at - 1, sizeof left);
    std::memcpy(&value[r], at, sizeof value[r]);
    std::memcpy(&right, at + 1, sizeof right);
    beside[r] = greater(left, right);
  }
#pragma GCC unroll 8
  for (std::ptrdiff_t r = 0; r < Rows; ++r) {
    const Floats straight = greater(greater(value[r], value[r + 2]), beside[r + 1]);
    const Floats diagonal = greater(beside[r], beside[r + 2]);
    const Floats offered =
        greater(straight * by.keep * by.straight, diagonal * by.keep * by.diagonal);
    const Floats kept = greater(value[r + 1] * by.keep, offered);
    const Floats left = kept < negligible ? Floats{} : kept;
    std::memcpy(next + r * stride, &left, sizeof left);
  }
}

/// The same of whole rows.
template <std::ptrdiff_t Rows>
void sweep_rows(const float* now, float* next, std::ptrdiff_t stride, std::ptrdiff_t count,
                Factors by) {
  constexpr std::ptrdiff_t width = sizeof(Points) / sizeof(float);
  std::ptrdiff_t i = 0;
  for (; i + width <= count; i += width) sweep_some<Rows, Points>(now + i, next + i, stride, by);
  if (i == count) return;
  // The last ones once more with those before them: they get the same values.
  if (count >= width)
    return sweep_some<Rows, Points>(now + count - width, next + count - width, stride, by);
  for (; i < count; ++i) sweep_some<Rows, float>(now + i, next + i, stride, by);
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
  const std::ptrdiff_t last = std::ptrdiff_t{rows} - 4;
  std::ptrdiff_t row = 0;
  for (; row <= last; row += 4)
    sweep_rows<4>(now + row * stride, next + row * stride, stride, count, by);
  // As with columns: the last rows once more with those before them, unless there are too few.
  if (row < rows && last >= 0)
    return sweep_rows<4>(now + last * stride, next + last * stride, stride, count, by);
  for (; row < rows; ++row)
    sweep_rows<1>(now + row * stride, next + row * stride, stride, count, by);
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
  static constexpr std::size_t width = sizeof(Points) / sizeof(float);
  const double *x, *y;
  std::int32_t column[width], row[width];  ///< of the middle square
  std::int32_t corner[width];
  Points weight[9];
  Points sum, peak;

  void set(std::size_t lane, const Footprint& print, std::int32_t lower_left) {
    column[lane] = print.column;
    row[lane] = print.row;
    corner[lane] = lower_left;
    for (std::size_t k = 0; k < 9; ++k) weight[k][lane] = print.weight[spot(k)];
    sum[lane] = print.sum;
    peak[lane] = print.peak;
  }
};

void MorphogenFields::survey(std::span<const double> x, std::span<const double> y,
                             std::span<Footprint> prints, Matrix<float> sensed) const {
  Block block;
  const std::size_t full = x.size() / Block::width * Block::width;
  for (std::size_t begin = 0; begin < full; begin += Block::width) {
    block.x = &x[begin], block.y = &y[begin];
    place(block);
    for (std::uint32_t kind = 0; kind < sensed.channels; ++kind)
      sense(kind, block, sensed.data + kind * sensed.stride + begin);
    print(block, prints.subspan(begin, Block::width));
  }
  if (full == x.size()) return;

  // What is left over, with the last point repeated.
  const std::size_t count = x.size() - full;
  double last_x[Block::width], last_y[Block::width];
  for (std::size_t l = 0; l < Block::width; ++l) {
    last_x[l] = x[full + std::min(l, count - 1)];
    last_y[l] = y[full + std::min(l, count - 1)];
  }
  block.x = last_x, block.y = last_y;
  place(block);
  for (std::uint32_t kind = 0; kind < sensed.channels; ++kind) {
    float found[Block::width];
    sense(kind, block, found);
    std::copy_n(found, count, sensed.data + kind * sensed.stride + full);
  }
  print(block, prints.subspan(full));
}

void MorphogenFields::print(const Block& block, std::span<Footprint> prints) const {
  float sum[Block::width], peak[Block::width];
  std::memcpy(sum, &block.sum, sizeof sum);
  std::memcpy(peak, &block.peak, sizeof peak);
  for (std::size_t l = 0; l < prints.size(); ++l) {
    prints[l].column = block.column[l];
    prints[l].row = block.row[l];
    prints[l].sum = sum[l];
    prints[l].peak = peak[l];
  }
  for (std::size_t r = 0; r < 3; ++r) {
    FourFloats row[Block::width];
    to_rows(block.weight + 3 * r, row);
    for (std::size_t l = 0; l < prints.size(); ++l)
      std::memcpy(&prints[l].weight[4 * r], &row[l], sizeof row[l]);
  }
}

void MorphogenFields::place(Block& block) const {
  // As footprint() does it, for points whose block is on the grid and that are at no centre.
  const double low = low_, side = side_, last_inner = static_cast<double>(size_) - 2;
  double sides_x[Block::width], sides_y[Block::width];
  for (std::size_t l = 0; l < Block::width; ++l) {
    sides_x[l] = (block.x[l] - low) / side;
    sides_y[l] = (block.y[l] - low) / side;
  }
  float offset_x[Block::width], offset_y[Block::width];
  std::int32_t plain[Block::width];
  const auto stride = static_cast<std::int32_t>(stride_);
  for (std::size_t l = 0; l < Block::width; ++l) {
    const double column = std::floor(sides_x[l]), row = std::floor(sides_y[l]);
    const bool inside = (column >= 1) & (column <= last_inner) & (row >= 1) & (row <= last_inner);
    offset_x[l] = static_cast<float>(sides_x[l] - (column + 0.5));
    offset_y[l] = static_cast<float>(sides_y[l] - (row + 0.5));
    const float square = offset_x[l] * offset_x[l] + offset_y[l] * offset_y[l];
    plain[l] = inside & !(square < at_centre * at_centre) ? 1 : 0;
    block.column[l] = static_cast<std::int32_t>(inside ? column : 1.0);
    block.row[l] = static_cast<std::int32_t>(inside ? row : 1.0);
    block.corner[l] = (block.row[l] + 1) * stride + block.column[l] + 1;
  }

  Points fx, fy;
  std::memcpy(&fx, offset_x, sizeof fx);
  std::memcpy(&fy, offset_y, sizeof fy);
  Points dx[3], dy[3];  // squared, by column and row
  for (std::size_t k = 0; k < 3; ++k) {
    dx[k] = fx - across[k], dx[k] *= dx[k];
    dy[k] = fy - across[k], dy[k] *= dy[k];
  }
  Points sum{}, peak{};
  for (std::size_t k = 0; k < 9; ++k) {
    Points distance;
    square_root(dx[k % 3] + dy[k / 3], distance);
    const Points weight = 1.0f / distance;
    sum += weight;
    peak = weight > peak ? weight : peak;
    block.weight[k] = weight;
  }
  block.sum = sum;
  block.peak = peak;

  // The others one by one.
  std::int32_t all = 1;
  for (std::size_t l = 0; l < Block::width; ++l) all &= plain[l];
  for (std::size_t l = 0; all == 0 && l < Block::width; ++l) {
    if (plain[l] != 0) continue;
    const Footprint print = footprint(block.x[l], block.y[l]);
    block.set(l, print, static_cast<std::int32_t>(corner(print)));
  }
}

void MorphogenFields::sense(std::size_t kind, const Block& block, float* sensed) const {
  const float* values = now_[kind].data();
  Points total{};
  for (std::size_t r = 0; r < 3; ++r) {
    Points column[4];
    read_columns(values + r * stride_, block.corner, column);
    for (std::size_t k = 0; k < 3; ++k) total += column[k] * block.weight[3 * r + k];
  }
  const Points mean = total / block.sum;
  const Points found = block.sum == 0 ? Points{} : mean;
  std::memcpy(sensed, &found, sizeof found);
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
  const std::size_t stride = stride_;
  for (std::size_t i = 0; i < prints.size(); ++i) {
    const Footprint& at = prints[i];
    if (at.sum == 0 || !(amounts[i] > 0)) continue;
    const float unit = amounts[i] / (rule == Deposit::peak ? at.peak : at.sum);
    // The square behind each row has no weight, and keeps its value.
    float* block = values + corner(at);
    for (std::size_t r = 0; r < 3; ++r) raise(block + r * stride, &at.weight[4 * r], unit);
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
