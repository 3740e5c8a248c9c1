#include "bench/step_costs.hpp"

#include <array>

namespace somas::bench {

// The counts of operations stand here and nowhere else. They follow the code of each phase: change
// one with the other. Index arithmetic, branches and shuffles are not counted, nor what is read a
// second time while it is still in the first cache. A double is 8 bytes, an index 4, a float 4.
namespace {

/// A running sum that keeps the error of its additions (Sum): an addition, a comparison of absolute
/// values, two subtractions, two additions.
constexpr double ledger = 6;
/// What mechanics has of a cell: Body, a cache line.
constexpr double body = 64;
/// An ordered pair of places.
constexpr double pair_of_indices = 8;
/// The sum of radii and the spring of a pair of different kinds: five doubles.
constexpr double pair_constants = 40;

/// NutrientField::regenerate: a comparison with what all patches hold at most; content in. Most are
/// full, which is all that is done to them.
Work of_patch() { return {.flops64 = 1, .bytes = 8}; }
/// NutrientField::sense: patch of (x, y), content / capacity to a float.
Work sense_nutrients() { return {.flops64 = 2, .divisions64 = 3, .bytes = 16 + 16 + 4}; }

/// sweep_rows, a square: the own value times a factor, two candidates times two factors each; one
/// maximum along the row, two of the straight and one of the diagonal ones, one of both, one with
/// the own, one comparison with what is negligible. Read once, written once.
Work of_square() { return {.flops32 = 5 + 6 + 1, .bytes = 8}; }

/// MorphogenFields::survey, the footprint: place in squares (2 divisions, 6 operations), nine times
/// 1 / sqrt(dx dx + dy dy) with two differences, their sum and greatest; x and y in, 64 bytes out.
Work footprint() {
  return {.flops64 = 6,
          .flops32 = 9 * 5 + 18,
          .divisions64 = 2,
          .divisions32 = 9,
          .roots32 = 9,
          .bytes = 16 + 64};
}
/// For each kind. Sensing: nine products and sums, one division; nine squares in, an input out.
/// Depositing: one division, twelve products and maxima (rows of three are handled as four); an
/// output in, twelve squares there and back.
Work of_kind() { return {.flops32 = 18 + 24, .divisions32 = 2, .bytes = 9 * 4 + 4 + 4 + 2 * 48}; }
/// Pressure, energy and ambrosia / capacity as inputs; the footprint again when depositing.
Work other_inputs() { return {.divisions64 = 1, .bytes = 3 * (8 + 4) + 64}; }

/// One step of the network: a product and a sum for each input or regulator of each target, then
/// clamping; inputs in, memory there and back, outputs out after they were set to NaN.
Work network(const Items& n) {
  const double regulators = n.targets - n.outputs;
  return {.flops32 = n.targets * (2 * (n.inputs + regulators) + 3),
          .bytes = 4 * n.inputs + 8 * n.targets + 8 * n.outputs};
}

/// Decide and advance, a cell: order (twice), action (twice), organism, dead, remaining there and
/// back.
Work each_cell_of_the_cycle() { return {.bytes = 8 + 2 + 2 + 1 + 8}; }
/// A choice among four outputs and the children's: clamped and compared; action, target, remaining.
Work choice() { return {.flops32 = 5 * 4, .bytes = 5 * 4 + 1 + 2 + 4}; }
/// radius = r sqrt(1 + done / steps).
Work growth() { return {.flops64 = 3, .divisions64 = 1, .roots64 = 1, .bytes = 8}; }
/// Reorganiser::run without its columns: state, new_index out and in, order there and back, rank.
constexpr double places_bytes = 2 + 8 + 8 + 4;
/// After births columns move towards the back in place. (After changes of state they go to a
/// scratch area and back.) Half of the cells stand behind the first that moves.
Work storage_after_births(const Items& n) {
  return {.bytes = 0.5 * 2 * n.column_bytes + places_bytes};
}
/// After deaths they move up in place; then the contacts follow.
Work storage_after_deaths(const Items& n) {
  return {.bytes = 0.5 * 2 * n.column_bytes + places_bytes + 2 * (4 + 8 * n.touching)};
}
/// The distance from the centre; position, order, dead.
Work bury() { return {.flops64 = 4, .bytes = 16 + 4 + 1}; }

/// ask: room (2), share (2), wish and demand (2), the square (2 and 2 divisions); ambrosia, room
/// there and back, output, position, rank, demand, square.
Work ask() { return {.flops64 = 8, .divisions64 = 2, .bytes = 8 + 16 + 4 + 16 + 4 + 8 + 4}; }
/// sum_demands: demand, square, demand of the square there and back.
Work sum_demand() { return {.flops64 = 1, .bytes = 8 + 4 + 16}; }
/// take_up: two comparisons with the content and the demand of the square, yield, part (1), taken
/// (2); rank, square, demand there and back, both of the square, room, ambrosia there and back.
Work take_up() { return {.flops64 = 6, .bytes = 4 + 4 + 16 + 16 + 8 + 16}; }
/// convert: share (2), product, two differences, minimum, sum; output, ambrosia, energy, burnt.
Work convert() { return {.flops64 = 7, .bytes = 4 + 16 + 16 + 8}; }
/// offer, accept and diffuse, a cell: share (2), offer (1 and a division), gift; room (2), what is
/// taken (2); what is lost and left (5). Output, ambrosia, start, offer, gift; ambrosia, start,
/// accepted, gain; offer, start, ambrosia there and back, gain, lost.
Work diffuse() { return {.flops64 = 4 + 4 + 5, .divisions64 = 1, .bytes = 36 + 32 + 48}; }
/// A contact, from either side: a gift added; an offer times what is accepted of it added. Items
/// and gift, items and accepted.
Work contact() { return {.flops64 = 3, .bytes = 24}; }
/// pay: sum, division by the efficiency, minimum, difference, comparison; action, energy, spent.
Work pay() { return {.flops64 = 4, .divisions64 = 1, .bytes = 1 + 16 + 8}; }
/// keep_books and empty_squares: taken, burnt, spent and lost in canonical order; content there and
/// back, its square and what is taken, the square's demand cleared.
Work books() { return {.flops64 = 4 * ledger + 2, .bytes = 4 * 8 + 4 + 2 + 16 + 4 + 8 + 8}; }

/// NeighbourPairs::build and DiscBins::sort, a cell: speed (3 and a root), margin (4), bounds (4),
/// reach (2), bin (2 divisions); Body, disc out and twice in, the square of the margin, bin there
/// and back, item, x, y and reach as floats there and back, two counters cleared and summed.
Work bins() {
  return {.flops64 = 13, .divisions64 = 2, .roots64 = 1, .bytes = body + 96 + 8 + 8 + 32 + 32};
}
/// collect, a candidate: two differences, their squares and sum, reach and its square, a
/// comparison. What it reads has just been read for the cell before.
Work candidate() { return {.flops32 = 8}; }
/// A pair that is found: out; its first in for counting, a counter; placed by the first, the second
/// out and a counter; the second in to be sorted, both out. Then its radii and springs are listed
/// (1 operation).
Work found_pair() {
  return {.flops64 = 1,
          .bytes = pair_of_indices + 4 + 8 + pair_of_indices + 4 + 8 + 4 + pair_of_indices +
                   pair_of_indices + pair_constants};
}

/// compute_forces, a pair: differences of places and speeds (4), square of the distance (3), root,
/// inverse, direction (2), reach (2), overlap and collision (3), pull (3), approach (3), total (3
/// and a comparison, a selection), along x and y (2); summed for both cells (4). Indices,
/// constants, the force out; both indices and the force in.
Work pair_force() {
  return {.flops64 = 4 + 3 + 2 + 2 + 3 + 3 + 3 + 5 + 2 + 4,
          .divisions64 = 1,
          .roots64 = 1,
          .bytes = pair_of_indices + pair_constants + 16 + pair_of_indices + 16};
}
/// A cell in a substep: drag (4), semi-implicit Euler (10), whether it has drifted (6). Body for
/// the pairs, for drag, there and back to move; force out, there and back, in; disc and margin.
Work cell_substep() { return {.flops64 = 4 + 10 + 6, .bytes = 4 * body + 16 + 32 + 16 + 40}; }

/// compute_stresses, a pair: as a force up to the collision (14), four products (5), comparisons
/// (2); summed for both cells (8). Indices, constants, stress out; index of the second and the
/// stress in. Constants are listed once a step (1): indices in, constants out.
Work pair_stress() {
  return {
      .flops64 = 4 + 3 + 2 + 2 + 3 + 5 + 2 + 8 + 1,
      .divisions64 = 1,
      .roots64 = 1,
      .bytes = pair_of_indices + pair_constants + 32 + 4 + 32 + pair_of_indices + pair_constants};
}
/// A pair in contact: out; in for counting, where its first's end and a counter; in to be placed on
/// both sides, two counters, who remains of both and two items.
Work touching_pair() {
  return {.bytes = pair_of_indices + pair_of_indices + 4 + 8 + pair_of_indices + 4 + 8 + 8 + 8};
}
/// A cell comes to mechanics and goes back: x, y, vx, vy, radius, rank, Body out, Body in, x, y,
/// vx, vy, order; stress cleared, there and back, and in by place; pressure (1 and a division) and
/// stress out; contacts: two counters cleared, there and back, and where they are.
Work to_and_fro() {
  return {.flops64 = 1,
          .divisions64 = 2,
          .bytes = 40 + 4 + body + body + 32 + 4 + 4 * 32 + 4 + 32 + 24 + 4 + 8};
}

/// ParticleAggression::advance, a particle: its next place (2), bounds of its path (4) against
/// those of all cells (4), beyond and outwards (8). x, y, vx, vy in; x and y out. Those that leave,
/// and the last ones that take their places, are few.
Work particle() { return {.flops64 = 2 + 4 + 4 + 8, .bytes = 32 + 16}; }
/// HitFinder::prepare, a cell: bounds (5), bin (2 divisions), a disc of floats (5); x, y, radius
/// twice, bin there and back, index, disc there and back.
Work cell_into_bins() { return {.flops64 = 10, .divisions64 = 2, .bytes = 48 + 8 + 4 + 32}; }

}  // namespace

Work& Work::operator+=(const Work& other) {
  flops64 += other.flops64, flops32 += other.flops32;
  divisions64 += other.divisions64, divisions32 += other.divisions32;
  roots64 += other.roots64, roots32 += other.roots32;
  bytes += other.bytes;
  return *this;
}

Work operator*(double times, Work work) {
  return {times * work.flops64,     times * work.flops32, times * work.divisions64,
          times * work.divisions32, times * work.roots64, times * work.roots32,
          times * work.bytes};
}

Work operator+(Work a, const Work& b) { return a += b; }

const char* name_of(Part part) {
  static constexpr std::array<const char*, parts> names{"nutrients",
                                                        "morphogens, sweep",
                                                        "morphogens, sense and deposit",
                                                        "control",
                                                        "decide, cycle, births in the storage",
                                                        "uptake, conversion, diffusion, cost",
                                                        "finding pairs",
                                                        "mechanics, substeps",
                                                        "contacts, pressure and stress",
                                                        "particles",
                                                        "deaths in the storage"};
  return names[static_cast<std::size_t>(part)];
}

Work work_of(Part part, const Items& n) {
  switch (part) {
    case Part::nutrients:
      return n.patches * of_patch() + sense_nutrients();
    case Part::sweep:
      return n.squares * of_square();
    case Part::sense_deposit:
      return footprint() + n.kinds * of_kind() + other_inputs();
    case Part::control:
      return network(n);
    case Part::cycle:
      return each_cell_of_the_cycle() + n.deciding * choice() + n.dividing * growth() +
             n.births_storage * storage_after_births(n);
    case Part::metabolism:
      return ask() + sum_demand() + take_up() + convert() + diffuse() +
             (2 * n.touching) * contact() + pay() + books();
    case Part::find_pairs:
      return n.builds * (bins() + n.candidates * candidate() + n.pairs * found_pair());
    case Part::substeps:
      return n.substeps * (n.pairs * pair_force() + cell_substep());
    case Part::contacts:
      return n.pairs * pair_stress() + n.touching * touching_pair() + to_and_fro();
    case Part::particles:
      return n.particles * particle() + cell_into_bins();
    case Part::deaths:
      return bury() + n.deaths_storage * storage_after_deaths(n);
  }
  return {};
}

}  // namespace somas::bench
