// Constants of a simulation: the world's part of an experiment, fixed before the first step.
// Section numbers refer to docs/model.md.
#pragma once

#include <cstdint>
#include <vector>

namespace somas::model {

/// Section 1. Range follows from both: see docs/model.md.
struct Morphogen {
  double attenuation = 0.1;   ///< R in [0, 1]: share lost per grid side
  double evaporation = 0.05;  ///< E in [0, 1]: share lost per step
};

/// How a cell's production is spread over the 3x3 block around it.
enum class Deposit { peak, share };

struct MorphogenGrid {
  std::uint32_t size =
      65;           ///< squares along an edge; odd, so that a square is centred on the origin
  double side = 2;  ///< of one square
  Deposit deposit = Deposit::peak;
  std::vector<Morphogen> kinds = {{0.05, 0.05}, {0.1, 0.05}, {0.2, 0.1}};
};

/// Section 3.
struct Mechanics {
  std::uint32_t substeps = 3;
  double time_step = 1.0 / 30.0;  ///< of a substep
  double damping = 3;             ///< normal damper of a pair
  double drag = 1;                ///< of a cell against the medium
  double pressure_scale = 10;     ///< the summed force that reads as pressure 1/2
};

/// Section 2; costs are energy a step before division by energy efficiency.
struct Metabolism {
  double quiescence_cost = 0.03;
  double division_cost = 0.12;
  double apoptosis_cost = 0.05;
  double specialization_cost = 0.08;
  double motility_cost = 0;  ///< of a motile state's cell, per unit of its force
  double founder_energy = 1;
  double founder_ambrosia = 5;  ///< at most the founder's capacity
};

/// Cells of different organisms always collide (sections 2 and 3).
struct Strangers {
  bool adhere = false;  ///< they also stick to each other, as kin do
  bool feed = false;    ///< ambrosia passes between those in touch
};

/// Section 4; durations in steps, at least 1.
struct Cycle {
  std::uint32_t quiescence_steps = 5;
  std::uint32_t division_steps = 20;
  std::uint32_t apoptosis_steps = 5;
  std::uint32_t specialization_steps = 10;
  double division_energy = 0.6;    ///< least energy to begin
  double division_pressure = 0.7;  ///< greatest pressure to begin
};

struct Config {
  double radius = 60;  ///< cells beyond it are removed
  std::uint64_t max_steps = 3000;
  std::uint32_t max_cells = 250;     ///< live + dividing, per organism
  std::uint32_t warm_up_steps = 25;  ///< controller steps of a founder before step 0
  MorphogenGrid morphogens{};
  Mechanics mechanics{};
  Metabolism metabolism{};
  Strangers strangers{};
  Cycle cycle{};
};

}  // namespace somas::model
