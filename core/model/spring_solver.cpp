#include "core/model/spring_solver.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "somas/sdk/math.hpp"

#include "core/model/compress.hpp"

namespace somas::model {

namespace {

// Extra reach of the pairs, half of it for either body: larger means finding pairs less often and
// passing over more of them.
constexpr double skin = 0.15;
constexpr double coincident = 1e-12;

/// For each set of four pairs, the lanes of these first.
alignas(32) constexpr auto pairs_first = [] {
  std::array<std::array<std::uint32_t, 8>, 16> table{};
  for (std::size_t set = 0; set < 16; ++set) {
    std::size_t to = 0;
    for (std::uint32_t pair = 0; pair < 4; ++pair) {
      if ((set >> pair & 1) == 0) continue;
      table[set][to++] = 2 * pair;
      table[set][to++] = 2 * pair + 1;
    }
  }
  return table;
}();

/// Puts those of four pairs that are set one behind another, by place, and returns how many. Writes
/// four.
inline std::size_t put_pairs(std::uint32_t set, const std::uint32_t* first,
                             const std::uint32_t* second, std::uint32_t place, Touching::Pair* to) {
  FourItems firsts, seconds;
  std::memcpy(&firsts, first, sizeof firsts);
  std::memcpy(&seconds, second, sizeof seconds);
  firsts += place;
  seconds += place;
  EightItems pairs = __builtin_shufflevector(firsts, seconds, 0, 4, 1, 5, 2, 6, 3, 7);
  permute(pairs_first[set], pairs);
  std::memcpy(to, &pairs, sizeof pairs);
  return static_cast<std::size_t>(std::popcount(set));
}

/// How the first cells of four pairs lie and move to the second ones; (nx, ny) is the direction
/// towards the first.
struct Geometry {
  Four nx, ny, vx, vy, square, distance;
};

}  // namespace

/// Reads pairs, four at a time.
class SpringSolver::PairReader {
 public:
  explicit PairReader(const SpringSolver& solver)
      : pairs_(solver.pairs_), bodies_(solver.all_.bodies), table_(*solver.table_) {}

  [[nodiscard]] const Body& first(std::size_t pair) const {
    return bodies_[pairs_.first().data()[pair]];
  }
  [[nodiscard]] const Body& second(std::size_t pair) const {
    return bodies_[pairs_.second().data()[pair]];
  }
  [[nodiscard]] const Spring& spring(std::size_t pair) const {
    return table_.between(first(pair).kind, second(pair).kind);
  }

  void geometry(std::size_t p, Geometry& g) const {
    // Differences first: then there is half as much to turn.
    Four of_pair[4], column[4];
    for (std::size_t k = 0; k < 4; ++k) {
      Four a, b;
      std::memcpy(&a, &first(p + k), sizeof a);
      std::memcpy(&b, &second(p + k), sizeof b);
      of_pair[k] = a - b;
    }
    transpose(of_pair, column);
    const Four dx = column[0], dy = column[1];
    g.vx = column[2];
    g.vy = column[3];
    g.square = dx * dx + dy * dy;
    square_root(g.square, g.distance);
    const Four inverse = 1.0 / g.distance;
    g.nx = dx * inverse;
    g.ny = dy * inverse;
  }

  [[nodiscard]] Four radii(std::size_t p) const {
    return Four{first(p).radius, first(p + 1).radius, first(p + 2).radius, first(p + 3).radius} +
           Four{second(p).radius, second(p + 1).radius, second(p + 2).radius, second(p + 3).radius};
  }

  void springs(std::size_t p, FourSprings& four) const {
    Four column[4];
    read_columns(spring(p), spring(p + 1), spring(p + 2), spring(p + 3), column);
    four = {column[0], column[1], column[2], column[3]};
  }

  /// Calls visit(pair) for all pairs of which the first and second cell are at the same place.
  template <class Visit>
  void each_coincident(Visit&& visit) const {
    for (std::size_t p = 0; p < pairs_.first().size(); ++p) {
      const double dx = first(p).x - second(p).x, dy = first(p).y - second(p).y;
      if (std::sqrt(dx * dx + dy * dy) <= coincident) visit(p);
    }
  }

 private:
  const NeighbourPairs& pairs_;
  std::span<const Body> bodies_;
  const SpringTable& table_;
};

void SpringSolver::use(Team* team) {
  team_ = team;
  pairs_.use(team);
}

double SpringSolver::longest_drift() { return NeighbourPairs::widest_margin(skin); }

void SpringSolver::begin(const Mechanics& constants, const SpringTable& table,
                         const WorldState& world, const SpringBodies& bodies) {
  constants_ = &constants;
  table_ = &table;
  world_ = &world;
  all_ = bodies;
  const auto count = static_cast<std::uint32_t>(all_.bodies.size());
  parts_ = team_ == nullptr ? 1 : team_->parts(count);
  if (force_.size() < count) force_.resize(count);
  if (pairs_.stale(all_.bodies, table.range())) find_pairs();
  if (in_parts()) pairs_.index_by_second(parts_);
  list_constants();  // radii and states may have changed
}

bool SpringSolver::move(std::span<const Two> external) {
  compute_forces();
  const auto count = static_cast<std::uint32_t>(all_.bodies.size());
  std::atomic<bool> drifted = false;
  if (in_parts()) {
    share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t k = begin; k < end; ++k) force_[k] = summed_force(external, k);
      if (advance({begin, end})) drifted = true;
    });
  } else {
    sum_forces(external);
    drifted = advance({0, count});
  }
  if (!drifted) return false;
  find_pairs();
  list_constants();
  return true;
}

void SpringSolver::finish(Touching& touching) {
  compute_stresses(touching);
  sum_stresses();
}

/// A direction for the cells of a pair that are at the very same place, from their names, towards
/// the first one.
std::pair<double, double> SpringSolver::arbitrary_direction(std::size_t pair) const {
  const CellStore& cells = world_->cells;
  const std::uint32_t first = all_.cells[pairs_.first()[pair]];
  const std::uint32_t second = all_.cells[pairs_.second()[pair]];
  Rng rng(stable_key("core.coincident"), world_->organisms[cells.organism[first]].key,
          world_->organisms[cells.organism[second]].key, cells.id[first], cells.id[second]);
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  return {angle.cos, angle.sin};
}

void SpringSolver::find_pairs() {
  // Twice the way of the step, for those who are being pushed.
  pairs_.build(all_.bodies, table_->range(), skin,
               2.0 * constants_->substeps * constants_->time_step);
  if (in_parts()) pairs_.index_by_second(parts_);
  const std::size_t room = pairs_.first().size() + 3;
  if (pair_force_.size() >= room) return;
  pair_force_.resize(2 * room);
  pair_stress_.resize(2 * room);
  touching_.resize(2 * room);
  pair_radii_.resize(2 * room / 4 + 1);
  pair_springs_.resize(2 * room / 4 + 1);
}

/// Calls work(begin, end) for fours of pairs that make up all, at once.
template <class Work>
void SpringSolver::share_pairs(const Work& work) {
  const std::size_t count = pairs_.first().size();
  share(team_, static_cast<std::uint32_t>((count + 3) / 4), all_.bodies.size(), work);
}

void SpringSolver::list_constants() {
  const PairReader reader(*this);
  const std::size_t count = pairs_.first().size();
  const Spring* common = table_->common();
  springs_stride_ = common == nullptr ? 1 : 0;
  if (count == 0) return;
  if (common != nullptr)
    pair_springs_[0] = {common->stiffness + Four{}, common->adhesion + Four{},
                        common->range + Four{}, common->contact + Four{}};
  share_pairs([this](std::size_t begin, std::size_t end) { list_constants(begin, end); });
}

void SpringSolver::list_constants(std::size_t begin, std::size_t end) {
  const PairReader reader(*this);
  for (std::size_t four = begin; four < end; ++four) pair_radii_[four] = reader.radii(4 * four);
  if (springs_stride_ == 0) return;
  for (std::size_t four = begin; four < end; ++four) reader.springs(4 * four, pair_springs_[four]);
}

/// Of fours of pairs; returns whether cells of some are at the same place.
bool SpringSolver::compute_forces(std::size_t begin, std::size_t end) {
  const double damping = constants_->damping;
  const PairReader reader(*this);
  const std::size_t stride = springs_stride_;
  const Four* radii_of = pair_radii_.data();
  const FourSprings* springs_of = pair_springs_.data();
  Two* force = pair_force_.data();
  FourMask together{};
  Geometry g;
  for (std::size_t four = begin; four < end; ++four) {
    const FourSprings& spring = springs_of[four * stride];
    reader.geometry(4 * four, g);
    const Four radii = radii_of[four], reach = spring.range * radii;
    const Four overlap = radii - g.distance;
    const Four collision = overlap > 0 ? spring.stiffness * overlap : Four{};
    const Four pull = spring.adhesion * (g.distance - 0.5 * radii);
    const Four approach = g.vx * g.nx + g.vy * g.ny;
    const Four total =
        reach * reach - g.square > 0 ? collision - pull - damping * approach : Four{};
    write_interleaved(total * g.nx, total * g.ny, &force[4 * four]);
    together |= g.distance <= coincident;
  }
  return any(together);
}

void SpringSolver::compute_forces() {
  std::atomic<bool> together = false;
  share_pairs([&](std::size_t begin, std::size_t end) {
    if (compute_forces(begin, end)) together = true;
  });
  if (!together) return;

  const PairReader reader(*this);
  reader.each_coincident([&](std::size_t p) {
    const Body &a = reader.first(p), &b = reader.second(p);
    const Spring& s = reader.spring(p);
    const auto [nx, ny] = arbitrary_direction(p);
    const double dx = a.x - b.x, dy = a.y - b.y;
    const double distance = std::sqrt(dx * dx + dy * dy), radii = a.radius + b.radius;
    const double collision = s.stiffness * std::max(0.0, radii - distance);
    const double pull = s.adhesion * (distance - 0.5 * radii);
    const double approach = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny;
    const double total = collision - pull - constants_->damping * approach;
    pair_force_[p] = Two{total * nx, total * ny};
  });
}

/// In the order of the bodies.
void SpringSolver::sum_forces(std::span<const Two> external) {
  const auto count = static_cast<std::uint32_t>(all_.bodies.size());
  const Body* bodies = all_.bodies.data();
  Two* force = force_.data();
  for (std::uint32_t k = 0; k < count; ++k) {
    const Two velocity{bodies[k].vx, bodies[k].vy};
    force[k] = (external.empty() ? Two{} : external[k]) - constants_->drag * velocity;
  }
  // What the first does to the second is exactly the opposite.
  const std::uint32_t* second = pairs_.second().data();
  const Two* between = pair_force_.data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Two own = force[k];
    for (std::uint32_t p = pairs_.start(k), end = pairs_.start(k + 1); p < end; ++p) {
      own += between[p];
      force[second[p]] -= between[p];
    }
    force[k] = own;
  }
}

/// The same sum, of one body.
inline Two SpringSolver::summed_force(std::span<const Two> external, std::uint32_t k) const {
  const Two velocity{all_.bodies[k].vx, all_.bodies[k].vy};
  Two force = (external.empty() ? Two{} : external[k]) - constants_->drag * velocity;
  for (const std::uint32_t p : pairs_.as_second(k)) force -= pair_force_[p];
  for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) force += pair_force_[p];
  return force;
}

/// Semi-implicit Euler. Returns whether pairs must be found anew.
bool SpringSolver::advance(Stretch own) {
  Body* bodies = all_.bodies.data();
  const Two* force = force_.data();
  const double h = constants_->time_step;
  bool drifted = false;
  for (std::uint32_t k = own.begin; k < own.end; ++k) {
    Body& body = bodies[k];
    Two at{body.x, body.y}, velocity{body.vx, body.vy};
    velocity += h * (force[k] * body.inverse_mass);
    at += h * velocity;
    // In one store: the next to look reads all four.
    const Four moved = __builtin_shufflevector(at, velocity, 0, 1, 2, 3);
    std::memcpy(&body.x, &moved, sizeof moved);
    drifted |= pairs_.drifted(k, at);
  }
  return drifted;
}

/// Of fours of pairs, all of them or, in parts, some; returns whether cells of some are at the same
/// place.
bool SpringSolver::compute_stresses(std::size_t begin, std::size_t end, Touching& list) {
  const PairReader reader(*this);
  const bool in_parts = this->in_parts();
  FourMask together{};
  Geometry g;
  std::size_t touching = list.count;
  const std::uint32_t place = all_.first_place;
  const std::uint32_t* first = pairs_.first().data();
  const std::uint32_t* second = pairs_.second().data();
  const std::size_t count = pairs_.first().size();
  for (std::size_t p = 4 * begin; p < 4 * end; p += 4) {
    const FourSprings& spring = pair_springs_[p / 4 * springs_stride_];
    reader.geometry(p, g);
    const Four radii = pair_radii_[p / 4], reach = spring.range * radii;
    const Four overlap = radii - g.distance;
    const Four collision = overlap > 0 ? spring.stiffness * overlap : Four{};
    const Four along_x = collision * g.nx, along_y = collision * g.ny;
    const Four parts[4] = {collision, along_x * g.nx, along_x * g.ny, along_y * g.ny};
    transpose(parts, *reinterpret_cast<Four(*)[4]>(&pair_stress_[p]));
    // The last four may go on past the end.
    constexpr FourMask lanes{0, 1, 2, 3};
    const FourMask contact = (reach * reach - g.square > 0) & (spring.contact > 0) &
                             (lanes < static_cast<std::int64_t>(count - p));
    for (std::size_t k = 0; in_parts && k < 4; ++k)
      touching_[p + k] = static_cast<std::uint32_t>(-contact[k]);
    if (!in_parts)
      touching +=
          put_pairs(bits_of(contact), first + p, second + p, place, list.pairs.data() + touching);
    together |= g.distance <= coincident;
  }
  if (!in_parts) list.count = touching;
  return any(together);
}

void SpringSolver::compute_stresses(Touching& touching) {
  if (!in_parts()) touching.make_room(pairs_.first().size());
  std::atomic<bool> together = false;
  share_pairs([&](std::size_t begin, std::size_t end) {
    if (compute_stresses(begin, end, touching)) together = true;
  });
  if (!together) return;

  const PairReader reader(*this);
  reader.each_coincident([&](std::size_t p) {
    const auto [nx, ny] = arbitrary_direction(p);
    const double collision = pair_stress_[p][0];
    pair_stress_[p] =
        Four{collision, collision * nx * nx, collision * nx * ny, collision * ny * ny};
  });
}

inline Four SpringSolver::summed_stress(std::uint32_t k) const {
  Four stress{};
  for (const std::uint32_t p : pairs_.as_second(k)) stress += pair_stress_[p];
  for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) stress += pair_stress_[p];
  return stress;
}

void SpringSolver::sum_stresses() {
  const auto count = static_cast<std::uint32_t>(all_.bodies.size());
  Four* const stress = all_.stress.data();
  if (in_parts())
    return share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t k = begin; k < end; ++k) stress[k] = summed_stress(k);
    });
  std::fill_n(stress, count, Four{});
  const std::uint32_t* second = pairs_.second().data();
  const Four* between = pair_stress_.data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Four own = stress[k];
    for (std::uint32_t p = pairs_.start(k), end = pairs_.start(k + 1); p < end; ++p) {
      own += between[p];
      stress[second[p]] += between[p];
    }
    stress[k] = own;
  }
}

}  // namespace somas::model
