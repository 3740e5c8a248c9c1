// Bodies that springs hold together and apart (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/model/lanes.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/springs.hpp"
#include "core/model/team.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// The springs of four pairs of cells.
struct FourSprings {
  Four stiffness, adhesion, range, contact;
};

/// Bodies at places `first_place` and on of all those of a world, in the order in which sums are
/// taken; and by body:
struct SpringBodies {
  std::uint32_t first_place;
  std::span<Body> bodies;
  std::span<Four> stress;                ///< of collisions; and stress xx, xy, yy
  std::span<const std::uint32_t> cells;  ///< which cell it is, in storage
};

/// Pairs of bodies in contact, by place, in order.
struct Touching {
  struct Pair {
    std::uint32_t first, second;
  };
  std::size_t count = 0;
  std::vector<Pair> pairs;

  /// For so many more, and four that are written behind the last one.
  void make_room(std::size_t more) {
    if (pairs.size() < count + more + 4) pairs.resize(2 * (count + more + 4));
  }
};

/// Moves some bodies of a world, those that no others can touch: all, or those of some islands.
class SpringSolver {
 public:
  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team);
  /// Takes up bodies for a step; all that is given must outlive it. Pairs that are still good are
  /// kept when the bodies are the same as before.
  void begin(const Mechanics& constants, const SpringTable& table, const WorldState& world,
             const SpringBodies& bodies);
  /// A substep; `external` holds by body the forces from outside, or nothing. Returns whether pairs
  /// were found anew at its end.
  bool move(std::span<const Two> external);
  /// The stress at the present positions; and, unless it is in parts, which touch, at the end of a
  /// list.
  void finish(Touching& touching);

  /// How far a body may be at most from where it was when pairs were last found.
  [[nodiscard]] static double longest_drift();
  /// The bodies as they were when pairs were last found, or within their margins of it.
  [[nodiscard]] const DiscBins& bins() const { return pairs_.bins(); }
  /// Whether several sum into cells of their own, from both kinds of pairs: those of which a cell
  /// is the second one, then those of which it is the first; so does a pass over all pairs.
  [[nodiscard]] bool in_parts() const { return parts_ > 1; }
  /// In parts: calls visit(place) for the bodies that touch the one at a place, in order.
  template <class Visit>
  void each_contact(std::uint32_t place, Visit&& visit) const {
    for (const std::uint32_t p : pairs_.as_second(place))
      if (touching_[p] != 0) visit(pairs_.first()[p]);
    for (std::uint32_t p = pairs_.start(place); p < pairs_.start(place + 1); ++p)
      if (touching_[p] != 0) visit(pairs_.second()[p]);
  }

 private:
  class PairReader;

  void find_pairs();
  [[nodiscard]] std::pair<double, double> arbitrary_direction(std::size_t pair) const;
  void list_constants();
  void list_constants(std::size_t begin, std::size_t end);
  template <class Work>
  void share_pairs(const Work& work);
  void compute_forces();
  [[nodiscard]] bool compute_forces(std::size_t begin, std::size_t end);
  void sum_forces(std::span<const Two> external);
  [[nodiscard]] Two summed_force(std::span<const Two> external, std::uint32_t body) const;
  [[nodiscard]] bool advance(Stretch bodies);
  void compute_stresses(Touching& touching);
  [[nodiscard]] bool compute_stresses(std::size_t begin, std::size_t end, Touching& touching);
  void sum_stresses();
  [[nodiscard]] Four summed_stress(std::uint32_t body) const;

  const Mechanics* constants_ = nullptr;
  const SpringTable* table_ = nullptr;
  const WorldState* world_ = nullptr;
  SpringBodies all_{};
  NeighbourPairs pairs_;
  std::vector<Two> force_;  ///< by body
  // Of pairs, with room to a multiple of four.
  std::vector<Four> pair_radii_;           ///< sums of both, of four pairs each
  std::vector<FourSprings> pair_springs_;  ///< of four pairs each; the first, where all alike
  std::size_t springs_stride_ = 0;         ///< 0 where all are alike, else 1
  std::vector<Two> pair_force_;            ///< what the second body does to the first
  std::vector<Four> pair_stress_;          ///< collision, and what it adds to stress xx, xy, yy
  std::vector<std::uint32_t> touching_;    ///< in parts: whether it is in contact
  Team* team_ = nullptr;
  unsigned parts_ = 1;  ///< of the present step
};

}  // namespace somas::model
