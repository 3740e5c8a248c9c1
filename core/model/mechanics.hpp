// Mass-spring-damper mechanics of discs (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/model/neighbours.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// Adds the environments' forces for the cells' present positions into fx, fy (zeroed).
using ExternalForces = std::function<void(std::span<double> fx, std::span<double> fy)>;

class MechanicsSolver {
 public:
  /// All substeps of one step, then contacts, pressure and stress at the final positions.
  /// `external` may be empty; when given, positions in `world.cells` are current at each call.
  void run(const Mechanics& constants, WorldState& world, const ExternalForces& external);
  /// The cells were changed behind the solver's back.
  void invalidate() { neighbours_.invalidate(); }
  /// Cells were added, removed or reordered, as Reorganiser::new_index says.
  void remap(std::span<const std::uint32_t> new_index) { neighbours_.remap(new_index); }

 private:
  void load(const WorldState& world);
  void store(CellStore& cells) const;
  void refresh_neighbours(const CellStore& cells);
  void substep(const Mechanics& constants, const WorldState& world);
  void observe(const Mechanics& constants, WorldState& world);

  NeighbourLists neighbours_;
  std::vector<Body> bodies_;
  std::vector<double> inverse_mass_;
  std::vector<double> fx_, fy_;  ///< of springs and dampers
  std::vector<double> external_x_, external_y_;
};

/// Distance at which two resting cells of a state with radius r stay: both springs in balance,
/// (k_c 2r + k_a r) / (k_c + k_a); 2r without springs.
[[nodiscard]] double rest_distance(const State& state);

}  // namespace somas::model
