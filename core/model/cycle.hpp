// The cell cycle: choosing actions, carrying them through, and what they do when they end
// (docs/model.md, section 4).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/model/team.hpp"
#include "core/model/witness.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// The winner among the candidates by unclamped output; ties go to quiescence, division,
/// specialization (lowest state first), apoptosis. An action whose clamped output is below the
/// state's threshold is no candidate; without candidates the cell is quiescent.
struct Choice {
  Action action = Action::quiescence;
  std::uint16_t target = no_state;
};
[[nodiscard]] Choice strongest(const State& state, const OutputChannels& channels,
                               const FloatMatrix& outputs, std::uint32_t cell);

/// Unit vector perpendicular to the most compressed axis of a stress tensor. False when its
/// eigenvalues are within 1e-9: then every axis is as good.
[[nodiscard]] bool division_axis(double xx, double xy, double yy, double& ax, double& ay);

class CycleSolver {
 public:
  /// Tells `witness` (may be null) from now on; it must outlive this.
  void tell(Witness* witness) { witness_ = witness; }
  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) { team_ = team; }
  /// Phase 4: cells with no running action choose one; ascending id, for the cap on cells.
  void decide(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs);
  /// Phase 6: actions advance; those that end take effect, all apoptoses first, then all
  /// specializations, then all divisions. Cells that starve this step do not take part.
  /// Returns true when cells were born or changed state (the storage must be reorganised).
  bool advance(const Ecosystem& ecosystem, WorldState& world);
  /// Those that have divided in this step, ascending (organism, id).
  [[nodiscard]] std::span<const std::uint32_t> mothers() const { return dividing_; }

 private:
  void decide(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs,
              const CellRange& range);
  void advance(const Cycle& cycle, WorldState& world, const CellRange& range);
  void release(WorldState& world);
  void specialize(const Ecosystem& ecosystem, WorldState& world);
  void divide(const Ecosystem& ecosystem, WorldState& world);

  std::vector<std::uint32_t> dying_, specializing_, dividing_;
  std::vector<std::uint8_t> marks_;  ///< by canonical place: who wants to divide; what has ended
  std::vector<double> received_;     ///< of the dying; 0 between steps
  std::vector<std::uint32_t> receivers_;
  std::vector<std::uint32_t> dividing_count_;  ///< by organism
  Team* team_ = nullptr;
  Witness* witness_ = nullptr;
};

}  // namespace somas::model
