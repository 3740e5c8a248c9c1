// Nutrients, ambrosia and energy (docs/model.md, section 2).
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/witness.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// A cell's controller outputs are read as shares: clamped to [0, 1], NaN as 0.
[[nodiscard]] inline double share(float output) {
  return output > 0 ? (output < 1 ? static_cast<double>(output) : 1.0) : 0.0;
}

/// Phase 5. Every stage reads what the one before left; sums run in canonical order.
class MetabolismSolver {
 public:
  /// Tells `witness` (may be null) from now on; it must outlive this.
  void tell(Witness* witness) { witness_ = witness; }
  void run(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs);

  /// Uptake: demand = min(share x production, room) of each resource; the demands on a square are
  /// scaled to its content; where several resources yield more than the room, all are taken in
  /// proportion. Throws PluginFailure for a content that is negative or no number.
  void take_up(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs);
  /// Conversion: min(share x ambrosia, 1 - energy), without loss.
  void convert(WorldState& world, const FloatMatrix& outputs);
  /// Diffusion: share x ambrosia, split equally among contacts; offers are computed before any is
  /// received, scaled to the receiver's room (measured before its own gifts), refused parts stay.
  void diffuse(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs);
  /// (Cost of the running action + that of motility) / energy efficiency; energy <= 1e-9 afterwards
  /// is starvation.
  void pay(const Ecosystem& ecosystem, WorldState& world);

 private:
  void book_gifts_to_strangers(WorldState& world) const;
  void tell_of_gifts(const WorldState& world) const;

  std::vector<double> demand_;        // by resource, then cell
  std::vector<std::int64_t> square_;  // of the resource's grid under each cell, -1: none
  std::vector<double> square_demand_;
  std::vector<std::int64_t> squares_of_resource_;  // by resource, then cell
  std::vector<double> offer_;                      // by each cell to each of its contacts
  std::vector<double> gift_;                       // what arrives of it
  std::vector<double> accepted_, gain_;  // share taken of what comes in, and how much that is
  std::vector<double> efficiency_, room_;
  Witness* witness_ = nullptr;
};

/// Energy at or below this is none.
inline constexpr double starving = 1e-9;

}  // namespace somas::model
