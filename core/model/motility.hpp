// Crawling along the gradient of a morphogen (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/model/world_state.hpp"

namespace somas::model {

/// Gradients below this, in concentration per length, show no direction.
inline constexpr double flat_gradient = 1e-6;

/// Forces of the live cells of motile states: motility g / |g|, g the gradient of the state's
/// signal in the organism's own field at the cell; 0 where |g| < flat_gradient.
class Motility {
 public:
  /// Finds the forces for the cells' present positions and the present fields.
  void prepare(const WorldState& world);
  /// Whether nobody crawls.
  [[nodiscard]] bool resting() const { return crawls_.empty(); }
  /// Adds them; both spans have an element a cell, in storage order.
  void add(std::span<double> fx, std::span<double> fy) const;

 private:
  struct Crawl {
    std::uint32_t cell;
    double fx, fy;
  };
  std::vector<Crawl> crawls_;
};

}  // namespace somas::model
