// One simulation: a roster of organisms in one world, from the founders to the last death.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "somas/sdk/fitness.hpp"

#include "core/model/cycle.hpp"
#include "core/model/ecosystem.hpp"
#include "core/model/mechanics.hpp"
#include "core/model/metabolism.hpp"
#include "core/model/profile.hpp"
#include "core/model/team.hpp"
#include "core/model/witness.hpp"
#include "core/model/world_state.hpp"
#include "core/model/world_view.hpp"

namespace somas::model {

/// A place in the roster. The key names the organism's random streams and its place in the order
/// of sums; it must be unique in a roster. (x, y) is where the founder appears.
struct RosterEntry {
  const Phenotype* phenotype = nullptr;
  std::uint64_t key = 0;
  double x = 0, y = 0;
};

/// A disc in the plane.
struct Wound {
  double x = 0, y = 0, radius = 0;
};

class Simulation {
 public:
  /// The ecosystem and phenotypes must outlive the simulation. Throws PluginFailure, or
  /// std::invalid_argument for an empty roster or repeated keys.
  Simulation(const Ecosystem& ecosystem, std::span<const RosterEntry> roster, std::uint64_t seed);
  /// Goes on where `save` (core/model/snapshot.hpp) left off; phenotypes in roster order. Lives on
  /// as the saved simulation does, to the last bit. Throws SnapshotError, saying what differs, for
  /// bytes of another experiment or roster, and for damaged ones.
  Simulation(const Ecosystem& ecosystem, std::span<const Phenotype* const> phenotypes,
             std::span<const std::byte> snapshot);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One pass of section 0. Returns false when the run is over: everybody dead, max_steps reached,
  /// or stopped by the fitness. Throws PluginFailure.
  bool step();
  /// Steps until the end (true), or until `stop` says so (false; asked before every step).
  bool run(const std::function<bool()>& stop = {});

  [[nodiscard]] bool finished() const { return state_.finished; }
  [[nodiscard]] std::uint64_t steps_done() const { return state_.step; }
  [[nodiscard]] const WorldState& state() const { return state_; }
  [[nodiscard]] const Ecosystem& ecosystem() const { return ecosystem_; }
  /// For tests and what-if studies, between steps only. After adding, removing or respecializing
  /// cells call `restructured`.
  [[nodiscard]] WorldState& mutable_state() { return state_; }
  void restructured();
  /// Takes away the live cells whose centre lies in a disc (on its edge, too), between steps; what
  /// they held counts as lost with the dead, but under no cause. Returns how many. An organism that
  /// loses its last cell ends here: its survival is the step that would come next.
  std::uint32_t wound(const Wound& wound);

  /// Tells `witness` (null: nobody) what happens from now on; it must outlive the simulation or be
  /// replaced. Never changes what happens.
  void tell(Witness* witness);
  /// Shares the work of steps with `team` (null: nobody) from now on; it must outlive this or be
  /// replaced, and helps one simulation at a time. Never changes what happens. Plugins' calls but
  /// Program::step stay with the calling thread, except for what they share (somas::Workers).
  void use(Team* team);
  /// Mechanics keeps at least so many cells (core/model/mechanics.hpp) island by island. Never
  /// changes what happens.
  void move_by_island_from(std::uint32_t cells) { mechanics_.by_island_from(cells); }
  /// Measures every step from now on into `profile` (null: no more), which must outlive it.
  void measure(Profile* profile);

  /// One per roster entry, in roster order.
  [[nodiscard]] std::vector<Outcome> outcomes() const;
  /// XXH3-64 of everything that the next step depends on, in canonical order.
  [[nodiscard]] std::uint64_t hash() const;
  /// Live cells of a roster entry by state.
  [[nodiscard]] std::vector<std::uint32_t> census(std::size_t roster_index) const;

 private:
  void found(std::span<const RosterEntry> roster);
  template <class Part>
  void timed(StepPhase phase, Part&& part);
  void update_fields();
  void sense();
  void sense(const CellRange& range);
  void control();
  void run_programs();
  void run_program(const CellRange& range);
  void deposit(std::uint32_t count);
  /// Every so many-th kind of morphogen, from the first on.
  struct Kinds {
    unsigned first = 0, every = 1;
  };
  void deposit(const CellRange& range, Kinds kinds);
  void reorganise();
  void move();
  [[nodiscard]] bool bury();
  void lose(std::uint32_t cell, Sum Ledger::*lost);
  void end_step();
  void finish();

  const Ecosystem& ecosystem_;
  WorldState state_;
  FloatMatrix inputs_, outputs_;
  WorldView view_;
  MetabolismSolver metabolism_;
  CycleSolver cycle_;
  MechanicsSolver mechanics_;
  Reorganiser reorganiser_;
  std::vector<Footprint> footprints_;
  /// A morphogen to be swept, and the rows of all that come before it.
  struct Sweep {
    MorphogenFields* fields;
    std::size_t kind;
    std::uint32_t rows, before;
  };
  std::vector<Sweep> sweeps_;
  std::vector<std::uint8_t> dead_;  ///< by canonical place
  Team* team_ = nullptr;
  Witness* witness_ = nullptr;
  Profile* profile_ = nullptr;
};

}  // namespace somas::model
