// Neighbour lists on a counting-sort grid, rebuilt only when something moved or grew far enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace somas::model {

/// What mechanics needs of a cell, packed into a cache line.
struct alignas(64) Body {
  double x, y, vx, vy;
  double radius;
  double stiffness, adhesion;
  double range;  ///< activation distance / (r1 + r2)
};

/// A pair interacts at most when nearer than max(1, mean range) x (r1 + r2). Lists hold all pairs
/// within that reach plus `skin`, each neighbour in canonical order, so that results do not depend
/// on when lists were built.
class NeighbourLists {
 public:
  /// Lists for `bodies`; `order` gives canonical order as indices into bodies.
  void build(std::span<const Body> bodies, std::span<const std::uint32_t> order, double skin);
  /// Whether a pair may have come within reach that the lists do not hold.
  [[nodiscard]] bool stale(std::span<const Body> bodies) const;
  void invalidate() { valid_ = false; }
  /// Bodies were removed, reordered or added; canonical order among those that stay is as it was.
  /// `new_index` by old index, `gone` if removed; old indices past the lists' end are newcomers,
  /// which make the lists stale.
  void remap(std::span<const std::uint32_t> new_index);
  /// Makes the lists good for `bodies` again, if they are stale: when a few bodies moved (a mother
  /// and her daughter) by mending their lists alone, else by building all anew. `rank` is the place
  /// of each body in `order`.
  void refresh(std::span<const Body> bodies, std::span<const std::uint32_t> order,
               std::span<const std::uint32_t> rank, double skin);

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t body) const {
    return {slots_.data() + body * capacity_, counts_[body]};
  }

 private:
  struct Built {
    double x, y, radius;
  };
  [[nodiscard]] bool usable(std::span<const Body> bodies) const;
  [[nodiscard]] double drift(const Body& body, const Built& built) const;
  [[nodiscard]] bool within(const Built& a, const Built& b) const;
  void erase(std::uint32_t body, std::uint32_t neighbour);
  [[nodiscard]] bool insert(std::uint32_t body, std::uint32_t neighbour,
                            std::span<const std::uint32_t> rank);
  [[nodiscard]] bool mend(std::uint32_t body, std::span<const Body> bodies,
                          std::span<const std::uint32_t> order,
                          std::span<const std::uint32_t> rank);
  void sort_into_bins(std::span<const Body> bodies, std::span<const std::uint32_t> order,
                      double reach);
  [[nodiscard]] bool fill(std::span<const Body> bodies, std::span<const std::uint32_t> order,
                          double skin);

  bool valid_ = false;
  double skin_ = 0, growth_reach_ = 1;
  std::size_t capacity_ = 16;
  std::vector<std::uint32_t> slots_, counts_;
  std::vector<Built> built_;  ///< as they were when last listed
  std::vector<std::uint32_t> movers_;
  std::vector<std::uint32_t> other_slots_, other_counts_;  ///< where `remap` copies to
  std::vector<Built> other_built_;
  // The grid of bins: bodies of bin b are bin_items_[bin_start_[b]] .. bin_items_[bin_start_[b+1]].
  double left_ = 0, bottom_ = 0, bin_side_ = 1;
  std::uint32_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> bin_of_, bin_start_, bin_items_, found_;
  std::vector<Built> bin_bodies_;
};

}  // namespace somas::model
