// Mass-spring-damper mechanics of discs (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/model/islands.hpp"
#include "core/model/lanes.hpp"
#include "core/model/motility.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/springs.hpp"
#include "core/model/team.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// Adds the environments' forces for the cells' present positions into fx, fy (zeroed).
using ExternalForces = std::function<void(std::span<double> fx, std::span<double> fy)>;

/// The springs of four pairs of cells.
struct FourSprings {
  Four stiffness, adhesion, range, contact;
};

class MechanicsSolver {
 public:
  explicit MechanicsSolver(Strangers strangers = {}) : table_(strangers) {}

  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) {
    team_ = team;
    pairs_.use(team);
    islands_.use(team);
  }
  /// Where there are so many cells, those of an island stand side by side; fewer are in a near
  /// cache in any order.
  void order_by_islands_from(std::size_t cells) { least_numbered_ = cells; }
  /// All substeps of one step, then pressure and stress at the final positions.
  /// `external` may be empty; when given, positions in `world.cells` are current at each call.
  /// Motile cells crawl with forces found once, at the positions at the start.
  void run(const Mechanics& constants, WorldState& world, const ExternalForces& external);
  /// The contacts at the positions that the last `run` left. Cells may have been removed since
  /// then: `new_index` is by the index during the run (core/model/cells.hpp), or empty when none
  /// were.
  void list_contacts(Contacts& contacts, std::span<const std::uint32_t> new_index = {});

  /// The cells as the last `run` left them, by place: island by island, in canonical order within
  /// each, or simply in canonical order.
  [[nodiscard]] std::span<const Body> bodies() const { return bodies_; }
  /// The cells, by place, where the last `run` left them or within their margins of it.
  [[nodiscard]] const DiscBins& bins() const { return pairs_.bins(); }
  /// The cell at each place, by its index during the last `run`.
  [[nodiscard]] std::span<const std::uint32_t> cells() const { return cell_; }

 private:
  void load(const WorldState& world);
  void store(CellStore& cells) const;
  void load_external(const ExternalForces& external, const CellStore& cells);
  void find_pairs(const Mechanics& constants, const CellStore& cells);
  void number(const CellStore& cells);
  [[nodiscard]] bool number_islands(const Sites& sites, const CellStore& cells,
                                    std::vector<std::uint32_t>& numbers);
  void renumber(const CellStore& cells);
  void place(const CellStore& cells);
  void list_constants();
  template <class Work>
  void share_pairs(const Work& work);
  void list_constants(std::size_t begin, std::size_t end);
  void compute_forces(double damping, const WorldState& world);
  [[nodiscard]] bool compute_forces(double damping, std::size_t begin, std::size_t end);
  void sum_forces(double drag);
  [[nodiscard]] bool move(const Mechanics& constants);
  [[nodiscard]] bool move(const Mechanics& constants, Stretch cells);
  [[nodiscard]] Two summed_force(double drag, std::uint32_t cell) const;
  void compute_stresses(const WorldState& world);
  [[nodiscard]] bool compute_stresses(std::size_t begin, std::size_t end);
  void sum_stresses(double pressure_scale, CellStore& cells);
  [[nodiscard]] Four summed_stress(std::uint32_t cell) const;
  void list_contacts_in_parts(Contacts& contacts, std::size_t count);
  template <class Visit>
  void each_contact(std::uint32_t cell, Visit&& visit) const;

  SpringTable table_;
  NeighbourPairs pairs_;
  Motility motility_;
  Islands islands_;
  /// Of each cell, in canonical order, its place; empty: that order. Of two cells of a pair the
  /// lower has the lower place, so taking pair after pair sums in canonical order.
  std::vector<std::uint32_t> number_, next_number_;
  std::size_t least_numbered_ = 4096;
  std::size_t numbered_ = 0;             ///< so many cells
  bool just_numbered_ = false;           ///< where they are now
  std::vector<std::uint32_t> cell_;      ///< by place: index
  std::vector<std::uint32_t> place_of_;  ///< by index: place
  // By place.
  std::vector<Body> bodies_, renumbered_;
  std::vector<Two> force_;
  std::vector<Four> sum_;                        ///< of collisions, and stress xx, xy, yy
  std::vector<double> external_x_, external_y_;  ///< in storage order
  std::vector<Two> external_;                    ///< by place; empty: there are none
  std::vector<Four> pair_radii_;                 ///< sums of both radii, of four pairs each
  std::vector<FourSprings> pair_springs_;        ///< of four pairs each; the first, where all alike
  std::size_t springs_stride_ = 0;               ///< 0 where all are alike, else 1
  /// Of pairs, with room to a multiple of four: what the second cell does to the first.
  std::vector<Two> pair_force_;
  std::vector<Four> pair_stress_;  ///< collision, and what it adds to stress xx, xy, yy
  /// Of pairs in contact, the first `touching_count_`: both places.
  std::vector<std::uint32_t> touching_first_, touching_second_;
  std::size_t touching_count_ = 0;
  // In parts: of each pair whether it is in contact; of each cell, by index, how many contacts.
  std::vector<std::uint32_t> touching_, contact_count_;
  std::vector<std::uint32_t> lower_, higher_;  ///< by index: contacts that come before and after it
  std::vector<std::uint32_t> remains_;         ///< by place: the cell's index by now, or `gone`
  Team* team_ = nullptr;
  /// Of the present step. In several, each sums into cells of its own, from both kinds of pairs:
  /// those of which a cell is the second one, then those of which it is the first; so does a pass
  /// over all pairs.
  unsigned parts_ = 1;
};

/// Distance at which two resting cells of a state with radius r stay: both springs in balance,
/// (k_c 2r + k_a r) / (k_c + k_a); 2r without springs.
[[nodiscard]] double rest_distance(const State& state);

}  // namespace somas::model
