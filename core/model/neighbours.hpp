// Pairs of neighbours, found in bins, anew only when something moved or grew far enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/model/disc_bins.hpp"
#include "core/model/lanes.hpp"
#include "core/model/parted_counts.hpp"
#include "core/model/team.hpp"

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
  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) {
    team_ = team;
    bins_.use(team);
  }
  /// No margin is wider.
  [[nodiscard]] static double widest_margin(double skin) { return 0.5 * skin + longest_way; }
  void build(std::span<const Body> bodies, double range, double skin, double time = 0);
  /// Whether a pair may have come within reach that was not found. Where not, `drifted` knows of
  /// the bodies' present radii.
  [[nodiscard]] bool stale(std::span<const Body> bodies, double range);
  /// Whether a body that is now at `at` may have come within reach of one that is not its
  /// neighbour: its radius is what it was at the last `build` or `stale`.
  [[nodiscard]] bool drifted(std::uint32_t body, Two at) const {
    const Two way = at - Two{built_[body].x, built_[body].y};
    const Two square = way * way;
    return !(square[0] + square[1] < safe_square_[body]);  // a NaN is never safe
  }

  /// Members of all pairs: (first()[p], second()[p]). The memory goes on to a multiple of four
  /// pairs, repeating the last one.
  [[nodiscard]] std::span<const std::uint32_t> first() const { return {first_.data(), count_}; }
  [[nodiscard]] std::span<const std::uint32_t> second() const { return {second_.data(), count_}; }
  /// The pairs of which `body` is the first are start(body) .. start(body + 1).
  [[nodiscard]] std::uint32_t start(std::uint32_t body) const { return start_[body]; }

  /// The pairs of which `body` is the second, ascending, once `index_by_second` has listed them.
  void index_by_second(unsigned parts);
  [[nodiscard]] std::span<const std::uint32_t> as_second(std::uint32_t body) const {
    return {pairs_by_second_.data() + second_start_[body],
            pairs_by_second_.data() + second_start_[body + 1]};
  }

  /// The bodies as they were when pairs were found, each with its margin: not stale, a body is
  /// within its margin of its place there.
  [[nodiscard]] const DiscBins& bins() const { return bins_; }

 private:
  /// However fast a body is, it must not cost everybody wide bins.
  static constexpr double longest_way = 0.2;

  /// Pairs in the order in which they are found, by one part: no two write to the same cache line.
  struct alignas(64) Found {
    std::size_t count = 0;
    std::vector<std::uint32_t> first, second;
  };
  void find(std::uint32_t begin, std::uint32_t end, Found& found) const;
  void collect(std::uint32_t k, std::uint32_t begin, std::uint32_t end, Found& found) const;
  void drop_distant(std::size_t from, Found& found) const;
  void sort(const Found& found);
  void find_in_parts(unsigned parts);
  void sort_seconds(Stretch bodies);
  void make_room();
  void pad();

  bool valid_ = false;
  double range_ = 1;
  std::size_t count_ = 0;
  std::vector<std::uint32_t> first_, second_, start_;
  std::vector<std::uint32_t> unsorted_;  ///< seconds, those of each first together
  std::vector<Found> found_{1};          ///< by part
  std::vector<Disc> built_;              ///< bodies as they were when pairs were found
  std::vector<double> safe_square_;      ///< of the way from there within which no pair is missed
  DiscBins bins_;
  Team* team_ = nullptr;
  PartedCounts counts_;
  bool indexed_ = false;
  std::vector<std::uint32_t> second_start_, pairs_by_second_;
};

}  // namespace somas::model
