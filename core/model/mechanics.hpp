// Mass-spring-damper mechanics of discs (docs/model.md, section 3).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/model/islands.hpp"
#include "core/model/motility.hpp"
#include "core/model/spring_solver.hpp"
#include "core/model/springs.hpp"
#include "core/model/team.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// Adds the environments' forces for the cells' present positions into fx, fy (zeroed).
using ExternalForces = std::function<void(std::span<double> fx, std::span<double> fy)>;

class MechanicsSolver {
 public:
  explicit MechanicsSolver(Strangers strangers = {}) : table_(strangers) {}

  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team);
  /// Where there are so many cells, islands that cannot touch each other within a step are moved
  /// block by block, of a sixteenth as many cells at least; fewer are in a near cache in any order.
  void by_island_from(std::uint32_t cells) { least_by_island_ = cells; }
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
  [[nodiscard]] const DiscBins& bins();
  /// The cell at each place, by its index during the last `run`.
  [[nodiscard]] std::span<const std::uint32_t> cells() const { return cell_; }

 private:
  /// By one thread at a time.
  struct alignas(64) BlockSolver {
    std::atomic<bool> busy = false;
    SpringSolver solver;
  };
  struct Release {
    void operator()(BlockSolver* solver) const {
      solver->busy.store(false, std::memory_order_release);
    }
  };
  using Borrowed = std::unique_ptr<BlockSolver, Release>;
  /// What one thread moves at a time: no two write to the same cache line.
  struct alignas(64) Piece {
    Stretch places;
    Touching touching;
    bool escaped = false;
    std::uint32_t first_item = 0;  ///< of its contacts
  };
  [[nodiscard]] bool list_blocks(const CellStore& cells);
  void place(const CellStore& cells);
  void take_pieces(unsigned pieces);
  [[nodiscard]] Borrowed free_solver(unsigned piece, unsigned pieces);
  [[nodiscard]] bool run_blocks(const Mechanics& constants, const WorldState& world);
  [[nodiscard]] bool run_block(const Mechanics& constants, const WorldState& world, Stretch block,
                               SpringSolver& solver, Touching& touching);
  [[nodiscard]] bool gone_far(const CellStore& cells, Stretch block) const;
  void run_whole(const Mechanics& constants, WorldState& world, const ExternalForces& external);
  void load(const WorldState& world);
  void load_external(const ExternalForces& external, const CellStore& cells);
  void store(CellStore& cells) const;
  void store_stresses(double pressure_scale, CellStore& cells) const;
  void drop_lost(Touching& touching) const;
  void list_contacts(const Piece& piece, Contacts& contacts);
  void list_contacts_in_parts(Contacts& contacts);
  template <class Visit>
  void each_contact(std::uint32_t place, Visit&& visit) const;

  SpringTable table_;
  Motility motility_;
  SpringSolver whole_;  ///< of all cells, where these are not moved by island
  // By island. Of two cells of a pair the lower in canonical order has the lower place, so sums are
  // taken in canonical order.
  Islands islands_;
  std::uint32_t least_by_island_ = 4096;
  bool by_island_ = false;                  ///< in the last run
  unsigned steps_as_whole_ = 0;             ///< that are still to come
  std::vector<std::uint32_t> number_;       ///< by canonical order: place
  std::vector<std::uint32_t> block_start_;  ///< places, and the end
  std::vector<BlockSolver> block_solvers_;  ///< one for each thread
  std::vector<Piece> pieces_;               ///< the first `taken_` of the last run
  unsigned taken_ = 0;
  bool binned_ = false;  ///< since then
  std::vector<Disc> discs_;
  DiscBins bins_;

  std::vector<std::uint32_t> cell_;              ///< by place: index
  std::vector<std::uint32_t> place_of_;          ///< by index: place
  std::vector<Body> bodies_;                     ///< by place
  std::vector<Four> stress_;                     ///< by place: of collisions; and stress xx, xy, yy
  std::vector<double> external_x_, external_y_;  ///< in storage order
  std::vector<Two> external_;                    ///< by place; empty: there are none
  std::vector<std::uint32_t> remains_;           ///< by place: the cell's index by now, or `gone`
  // By place: where the next contact goes that comes before the cell; and what takes a pair of
  // which it is the first to where the other goes.
  std::vector<std::uint32_t> next_lower_, higher_;
  Team* team_ = nullptr;
};

/// Distance at which two resting cells of a state with radius r stay: both springs in balance,
/// (k_c 2r + k_a r) / (k_c + k_a); 2r without springs.
[[nodiscard]] double rest_distance(const State& state);

}  // namespace somas::model
