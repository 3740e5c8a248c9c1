// Mass-spring-damper mechanics of discs (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/model/lanes.hpp"
#include "core/model/motility.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/springs.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// Adds the environments' forces for the cells' present positions into fx, fy (zeroed).
using ExternalForces = std::function<void(std::span<double> fx, std::span<double> fy)>;

/// Of four pairs of cells while neither their radii nor their states change.
struct PairConstants {
  Four radii, reach_square;  ///< sum of the radii; distance of activation
  Four stiffness, adhesion, contact;
};

class MechanicsSolver {
 public:
  explicit MechanicsSolver(Strangers strangers = {}) : table_(strangers) {}

  /// All substeps of one step, then contacts, pressure and stress at the final positions.
  /// `external` may be empty; when given, positions in `world.cells` are current at each call.
  /// Motile cells crawl with forces found once, at the positions at the start.
  void run(const Mechanics& constants, WorldState& world, const ExternalForces& external);

 private:
  void load(const WorldState& world);
  void store(CellStore& cells) const;
  void load_external(const ExternalForces& external);
  void find_pairs(const Mechanics& constants);
  void list_constants();
  void substep(const Mechanics& constants, const WorldState& world);
  void compute_forces(double damping, const WorldState& world);
  void sum_forces(double drag, const WorldState& world);
  void compute_stresses(const WorldState& world);
  void sum_stresses(double pressure_scale, CellStore& cells);
  void list_contacts(WorldState& world);

  SpringTable table_;
  NeighbourPairs pairs_;
  Motility motility_;
  /// Of cells, in canonical order: taking pair after pair then sums in that order.
  std::vector<Body> bodies_;
  std::vector<Two> force_;
  std::vector<Four> sum_;                        ///< of collisions, and stress xx, xy, yy
  std::vector<double> external_x_, external_y_;  ///< in storage order
  std::vector<PairConstants> pair_constants_;    ///< of four pairs each
  /// Of pairs, with room to a multiple of four: what the second cell does to the first.
  std::vector<Two> pair_force_;
  std::vector<Four> pair_stress_;  ///< collision, and what it adds to stress xx, xy, yy
  /// Of pairs in contact, the first `touching_count_`: both places in canonical order.
  std::vector<std::uint32_t> touching_first_, touching_second_;
  std::size_t touching_count_ = 0;
  std::vector<std::uint32_t> cursor_;  ///< of each cell, in canonical order
};

/// Distance at which two resting cells of a state with radius r stay: both springs in balance,
/// (k_c 2r + k_a r) / (k_c + k_a); 2r without springs.
[[nodiscard]] double rest_distance(const State& state);

}  // namespace somas::model
