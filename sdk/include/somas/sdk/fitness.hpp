/// @file
/// Fitness definitions: when to stop, and how well an organism did.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/world.hpp"

namespace somas {

/// What became of one organism in one simulation.
struct Outcome {
  std::uint64_t survival = 0;   ///< steps; the step of the last death, or max_steps if censored
  bool censored = false;        ///< still alive when the run was stopped
  std::uint64_t divisions = 0;  ///< that took place
  std::uint64_t specializations = 0;    ///< changes of state
  std::uint64_t refused_divisions = 0;  ///< by the cap on cells
  std::uint32_t final_cells = 0;        ///< alive at the end; 0 unless censored
  std::uint32_t peak_cells = 0;         ///< most alive at the end of a step
  double cell_steps = 0;                ///< live cells summed over steps
  /// Own live cells over those of all organisms in the world, averaged over the steps that somebody
  /// ended alive; 1 for an organism alone, 0 without such a step.
  double biomass_share = 0;
};

/// A plugin class has `about`, `Parameters` and a constructor from them. Life: constructor ->
/// declare, once (no phases, no sensors) -> observe at the end of every step and score at the end
/// of every simulation, from several threads at once. Exceptions become an error that names
/// fitness, call and step; the run ends.
class Fitness : public Extensible {
 public:
  /// What it wants to look at besides the cells. The argument is valid during the call.
  virtual void declare(Declare&) {}
  /// Name of the objective, for tables and progress ("survival"); larger is better.
  [[nodiscard]] virtual std::string_view objective() const = 0;
  /// At the end of every step, which it must not change; true stops the simulation (the living are
  /// then censored).
  [[nodiscard]] virtual bool observe(World&) const { return false; }
  /// The fitness of one organism in one trial; never NaN. The host averages over trials.
  [[nodiscard]] virtual double score(const Outcome& outcome) const = 0;
};

}  // namespace somas
