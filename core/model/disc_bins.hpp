// Discs sorted into square bins by their centres, to find those near a place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/model/lanes.hpp"
#include "core/model/team.hpp"

namespace somas::model {

/// A disc that reaches range x radius + margin, the range being that of all.
struct Disc {
  double x, y, radius, margin;
};

/// Columns of single precision, so that eight discs are looked at together: a disc found too far
/// off is so, one found near may not be. Discs that are nowhere (no numbers, or beyond 1e30) are
/// near nothing.
class DiscBins {
 public:
  /// Shares the sorting with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) { team_ = team; }
  /// Sorts the discs; their order stays within a bin.
  void sort(std::span<const Disc> discs, double range);

  /// The grid: bins of this side, at least twice the greatest reach, row by row from the lower
  /// left corner. The last column and the last row are empty, so that bins beside each other are
  /// neighbours, or one of them is empty.
  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] double bottom() const { return bottom_; }
  [[nodiscard]] double side() const { return side_; }
  /// 1 / side: a place (x, y) from the lower left corner is in column x * per_length().
  [[nodiscard]] double per_length() const { return per_length_; }
  [[nodiscard]] std::uint32_t columns() const { return columns_; }
  [[nodiscard]] std::uint32_t rows() const { return rows_; }
  /// How far any disc reaches from its centre.
  [[nodiscard]] double widest() const { return widest_; }
  /// The error of single precision is so great here that discs far from each other may seem near.
  [[nodiscard]] bool coarse() const { return coarse_; }

  /// Of bin b: places start(b) .. start(b + 1) of the columns. Bins of a row follow each other.
  [[nodiscard]] std::uint32_t start(std::size_t bin) const { return start_[bin]; }
  /// The bin that a place of the columns belongs to.
  [[nodiscard]] std::uint32_t bin_at(std::uint32_t place) const { return bin_at_[place]; }
  /// Columns, with room to read eight at a time: which disc, its centre from the lower left corner,
  /// and its reach, widened by the error of all three.
  [[nodiscard]] const std::uint32_t* items() const { return items_.data(); }
  [[nodiscard]] const float* x() const { return x_.data(); }
  [[nodiscard]] const float* y() const { return y_.data(); }
  [[nodiscard]] const float* reach() const { return reach_.data(); }

  /// More than the error of single precision for each unit of a length.
  static constexpr double rounding = 0x1p-21;
  /// A seeming reach wider by more than this lets too many pass.
  static constexpr double coarse_error = 0.01;

 private:
  struct Bounds {
    Two low, high;
    double radius, margin;  ///< the greatest
  };
  [[nodiscard]] static Bounds bounds_of(std::span<const Disc> discs);
  [[nodiscard]] Bounds bounds_of(std::span<const Disc> discs, unsigned parts);
  void lay_out(const Bounds& bounds, std::size_t count, double range);
  [[nodiscard]] std::uint32_t bin_of(const Disc& disc) const;
  void put(std::uint32_t item, const Disc& disc, double range, double error, std::uint32_t at);
  void sort_in_parts(std::span<const Disc> discs, double range, double error, unsigned parts);

  double left_ = 0, bottom_ = 0, side_ = 1, per_length_ = 1, widest_ = 0;
  std::uint32_t columns_ = 0, rows_ = 0;
  bool coarse_ = false;
  std::vector<std::uint32_t> bin_of_, bin_at_, start_, items_;
  std::vector<float> x_, y_, reach_;
  Team* team_ = nullptr;
  // By part:
  std::vector<Bounds> bounds_;
  std::vector<std::uint32_t> dealt_;        ///< its discs, by the part that has their bins
  std::vector<std::uint32_t> dealt_start_;  ///< where those of each part begin
};

}  // namespace somas::model
