// Pairs of neighbours, found on a counting-sort grid, anew only when something moved or grew far
// enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace somas::model {

/// What mechanics needs of a cell, packed into a cache line.
struct alignas(64) Body {
  double x, y, vx, vy;
  double radius;
  double inverse_mass;
  std::uint32_t kind;  ///< of springs
};

/// Two bodies interact at most when nearer than range x (r1 + r2). Each has a margin, half the
/// `skin` and what it covers in `time` with its speed. The pairs are all those within that reach
/// plus both margins, each once, the lower index first, in ascending order of both: with bodies in
/// canonical order, results do not depend on when pairs were found.
class NeighbourPairs {
 public:
  void build(std::span<const Body> bodies, double range, double skin, double time = 0);
  /// Whether a pair may have come within reach that was not found.
  [[nodiscard]] bool stale(std::span<const Body> bodies, double range) const;

  /// Members of all pairs: (first()[p], second()[p]). The memory goes on to a multiple of four
  /// pairs, repeating the last one.
  [[nodiscard]] std::span<const std::uint32_t> first() const { return {first_.data(), count_}; }
  [[nodiscard]] std::span<const std::uint32_t> second() const { return {second_.data(), count_}; }
  /// The pairs of which `body` is the first are start(body) .. start(body + 1).
  [[nodiscard]] std::uint32_t start(std::uint32_t body) const { return start_[body]; }

 private:
  /// A body as it was when pairs were found.
  struct Disc {
    double x, y, radius, margin;
  };
  struct Pair {
    std::uint32_t first, second;
  };
  void sort_into_bins(double reach);
  void find();
  [[nodiscard]] std::uint32_t* collect(std::uint32_t k, std::uint32_t begin, std::uint32_t end,
                                       std::uint32_t* near) const;
  void take(std::uint32_t item, std::span<const std::uint32_t> near);
  void sort();
  void pad();

  bool valid_ = false;
  double range_ = 1;
  std::size_t count_ = 0;
  std::vector<std::uint32_t> first_, second_, start_;
  std::vector<Pair> found_, sorted_;
  std::vector<std::uint32_t> by_second_, near_;
  std::vector<Disc> built_;
  // The grid of bins: those of bin b are bin_items_[bin_start_[b]] .. bin_items_[bin_start_[b+1]],
  // with room to read four at a time.
  double left_ = 0, bottom_ = 0, bin_side_ = 1;
  std::uint32_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> bin_of_, bin_start_, bin_items_;
  std::vector<double> bin_x_, bin_y_, bin_extent_;  ///< extent: its part of the greatest distance
};

}  // namespace somas::model
