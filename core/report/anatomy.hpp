// The shape of an organism over its life: clusters, who lies outside whom, where it drifts, what
// its cells die of. Read from the state between steps; never changes it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/model/simulation.hpp"

namespace somas::report {

/// Connected components of the contact graph: a label per cell, counted from 0 in canonical order
/// of each cluster's first cell.
struct Clusters {
  std::vector<std::uint32_t> label;
  std::uint32_t count = 0;
};
[[nodiscard]] Clusters clusters_of(const model::WorldState& world);

/// Of all pairs of one `outer` and one `inner` cell in the same cluster, how many have the outer
/// one farther from the cluster's centroid (ties count half); labels are by cell.
struct PairCount {
  double farther = 0;
  double pairs = 0;
};
[[nodiscard]] PairCount count_farther(std::span<const double> distance,
                                      std::span<const std::uint32_t> cluster,
                                      std::span<const std::uint16_t> state, std::uint16_t outer,
                                      std::uint16_t inner);

/// P(an `outer` cell is farther from its cluster's centroid than an `inner` one), averaged over the
/// steps with at least 20 outer cells and a pair to compare; beside it the same with the states
/// shuffled among each cluster's cells.
struct Segregation {
  std::uint16_t outer = 0, inner = 0;
  std::uint64_t steps = 0;
  double observed = 0;
  double shuffled = 0, shuffled_low = 0, shuffled_high = 0;  ///< mean and range over shufflings
};

/// Watches one organism alone in its world.
class Anatomy {
 public:
  static constexpr std::uint32_t least_outer_cells = 20;
  static constexpr std::uint32_t shufflings = 20;

  /// Call after every step.
  void observe(const model::Simulation& simulation);

  /// For every state but the root: outside its parent?
  [[nodiscard]] std::vector<Segregation> segregation() const;
  [[nodiscard]] std::string to_text() const;
  /// A line a step: cells and mean distance from the centroid by state, clusters, centroid, energy,
  /// ambrosia, deaths so far by cause.
  [[nodiscard]] std::string to_csv() const;

 private:
  struct Step {
    std::uint64_t step = 0;
    std::vector<std::uint32_t> cells;  // by state
    std::vector<double> distance;      // mean from the cluster's centroid, by state
    std::uint32_t clusters = 0, largest = 0;
    double x = 0, y = 0;  // centroid of all cells
    double energy = 0, ambrosia = 0;
    std::vector<std::uint64_t> deaths;  // so far, by cause
  };
  struct PairSum {
    std::uint16_t outer = 0, inner = 0;
    std::uint64_t steps = 0;
    double observed = 0;
    std::array<double, shufflings> shuffled{};
  };

  void describe(const model::Simulation& simulation);
  void compare(const model::WorldState& world, const Clusters& clusters,
               std::span<const double> distance);

  std::vector<std::string> states_, causes_;
  std::vector<Step> steps_;
  std::vector<PairSum> pairs_;
  std::uint64_t divisions_ = 0, specializations_ = 0;
};

}  // namespace somas::report
