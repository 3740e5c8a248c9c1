// Morphogen grids of one organism (docs/model.md, section 1).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "somas/sdk/types.hpp"

#include "core/model/config.hpp"

namespace somas::model {

/// The 3x3 block of squares round a point with inverse-distance weights; squares off the grid have
/// weight 0. At a centre (nearer than 1e-6 sides) that square has all the weight.
struct Footprint {
  std::int32_t column = 0, row = 0;  ///< of the block's middle square; may lie one off the grid
  std::array<float, 12> weight{};    ///< rows from the lower left, each followed by a 0
  float sum = 0, peak = 0;           ///< of the weights
};

/// Bounds of the middle squares of blocks; none at first.
struct Middles {
  std::int32_t left = std::numeric_limits<std::int32_t>::max();
  std::int32_t right = std::numeric_limits<std::int32_t>::min();
  std::int32_t bottom = left, top = right;

  void add(const Footprint& at) {
    left = std::min(left, at.column), right = std::max(right, at.column);
    bottom = std::min(bottom, at.row), top = std::max(top, at.row);
  }
};

/// Change of a concentration per length, along x and y.
struct Gradient {
  double x = 0, y = 0;
};

class MorphogenFields {
 public:
  /// Squares of a kind that may hold anything, inclusive; empty when left > right.
  struct Box {
    std::uint32_t left = 1, right = 0, bottom = 1, top = 0;
    friend bool operator==(const Box&, const Box&) = default;
  };

  MorphogenFields() = default;
  explicit MorphogenFields(const MorphogenGrid& grid);

  /// One step: C <- C (1 - E), then one double-buffered sweep in which every square keeps the
  /// maximum of its own value and C_s max(0, 1 - R d) of its 8 neighbours; below 1e-6 becomes 0.
  void evaporate_and_spread(const MorphogenGrid& grid);
  /// The same of one kind in parts, which may run at once. `begin` returns how many rows there are
  /// to sweep (0: all is over), `sweep` sweeps some of these, and `end` follows when all are swept.
  std::uint32_t begin_sweep(std::size_t kind);
  void sweep(std::size_t kind, const Morphogen& morphogen, std::uint32_t first,
             std::uint32_t count);
  void end_sweep(std::size_t kind) { now_[kind].swap(next_[kind]); }

  [[nodiscard]] Footprint footprint(double x, double y) const;
  /// sum(C_i / d_i) / sum(1 / d_i) over the block; 0 off the grid.
  [[nodiscard]] float sense(std::size_t kind, const Footprint& at) const;
  /// The same of many points at once, to the last bit: prints[i] is the footprint of (x[i], y[i]),
  /// and lane i of sensed.channel(kind) what is sensed there. All are as long.
  void survey(std::span<const double> x, std::span<const double> y, std::span<Footprint> prints,
              Matrix<float> sensed) const;
  /// Slope of the plane that fits the squares of the 3x3 block round a point best (least squares):
  /// along x the mean over the rows of (right - left) / distance, along y likewise. Exact for a
  /// linear field. Squares off the grid do not count; 0 along an axis on which one square is left.
  [[nodiscard]] Gradient gradient(std::size_t kind, double x, double y) const;
  /// Every square of the block keeps the maximum of its value and its share of `amount`.
  void deposit(std::size_t kind, const Footprint& at, float amount, Deposit rule);
  /// The same of many points: amounts[i] at prints[i], both as long. Kinds may be at work at once.
  void deposit(std::size_t kind, std::span<const Footprint> prints, std::span<const float> amounts,
               Deposit rule);

  [[nodiscard]] std::uint32_t size() const { return size_; }
  [[nodiscard]] std::size_t kinds() const { return now_.size(); }
  [[nodiscard]] float value(std::size_t kind, std::uint32_t column, std::uint32_t row) const {
    return now_[kind][index(column, row)];
  }
  void set(std::size_t kind, std::uint32_t column, std::uint32_t row, float value);
  /// Every square outside it is 0.
  [[nodiscard]] const Box& box(std::size_t kind) const { return boxes_[kind]; }
  /// Square centres along either axis.
  [[nodiscard]] double centre(std::uint32_t i) const {
    return (static_cast<double>(i) + 0.5) * side_ + low_;
  }
  /// The padded storage of a kind, for hashing: a border of zeros round the grid.
  [[nodiscard]] std::span<const float> raw(std::size_t kind) const {
    return {now_[kind].data(), stride_ * stride_};
  }

 private:
  /// Zeros round the grid: a block whose middle lies one off it stays within the storage.
  static constexpr std::uint32_t padding = 2;
  /// Room behind the storage: the three squares of a row are handled as four.
  static constexpr std::size_t slack = 1;
  struct Block;

  [[nodiscard]] std::size_t index(std::uint32_t column, std::uint32_t row) const {
    return static_cast<std::size_t>(row + padding) * stride_ + column + padding;
  }
  /// Storage index of the lower left square of a block.
  [[nodiscard]] std::size_t corner(const Footprint& at) const {
    return static_cast<std::size_t>(at.row + 1) * stride_ + static_cast<std::size_t>(at.column + 1);
  }
  void place(Block& block) const;
  void sense(std::size_t kind, const Block& block, float* sensed) const;
  void print(const Block& block, std::span<Footprint> prints) const;
  /// The blocks round these squares may hold something from now on.
  void cover(std::size_t kind, const Middles& middles);
  void touch(std::uint32_t left, std::uint32_t right, std::uint32_t bottom, std::uint32_t top,
             Box& box) const;

  std::uint32_t size_ = 0;
  std::size_t stride_ = 0;
  double side_ = 1, low_ = 0;
  std::vector<std::vector<float>> now_, next_;
  std::vector<Box> boxes_;
};

}  // namespace somas::model
