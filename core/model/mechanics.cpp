#include "core/model/mechanics.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "somas/sdk/math.hpp"

#include "core/model/ranges.hpp"

namespace somas::model {

namespace {

// Extra reach of the pairs, half of it for either cell: larger means finding pairs less often and
// passing over more of them.
constexpr double skin = 0.15;
constexpr double coincident = 1e-12;

/// A direction for two cells at the very same place, from their names, towards the first one.
/// `first` and `second` are in canonical order.
std::pair<double, double> arbitrary_direction(const WorldState& world, std::uint32_t first,
                                              std::uint32_t second) {
  const CellStore& cells = world.cells;
  Rng rng(stable_key("core.coincident"), world.organisms[cells.organism[first]].key,
          world.organisms[cells.organism[second]].key, cells.id[first], cells.id[second]);
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  return {angle.cos, angle.sin};
}

/// How the first cells of four pairs lie and move to the second ones; (nx, ny) is the direction
/// towards the first.
struct Geometry {
  Four nx, ny, vx, vy, square, distance;
};

/// Reads pairs, four at a time.
class PairReader {
 public:
  PairReader(const NeighbourPairs& pairs, std::span<const Body> bodies, const SpringTable& table)
      : pairs_(pairs), bodies_(bodies), table_(table) {}

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
    Four a[4], b[4];
    read_columns(first(p), first(p + 1), first(p + 2), first(p + 3), a);
    read_columns(second(p), second(p + 1), second(p + 2), second(p + 3), b);
    const Four dx = a[0] - b[0], dy = a[1] - b[1];
    g.vx = a[2] - b[2];
    g.vy = a[3] - b[3];
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

}  // namespace

double rest_distance(const State& state) {
  const double springs = state.stiffness + state.adhesion;
  if (springs == 0) return 2.0 * state.radius;
  return (state.stiffness * 2.0 * state.radius + state.adhesion * state.radius) / springs;
}

void MechanicsSolver::run(const Mechanics& constants, WorldState& world,
                          const ExternalForces& external) {
  CellStore& cells = world.cells;
  parts_ = team_ == nullptr ? 1 : team_->parts(cells.size());
  load(world);
  if (pairs_.stale(bodies_, table_.range())) find_pairs(constants, cells);
  if (parts_ > 1) pairs_.index_by_second(parts_);
  list_constants();  // radii and states may have changed
  for (std::uint32_t s = 0; s < constants.substeps; ++s) {
    if (external && s > 0) store(cells);
    if (external || s == 0) load_external(external, cells);
    compute_forces(constants.damping, world);
    if (!move(constants)) continue;
    find_pairs(constants, cells);
    list_constants();
  }
  store(cells);
  compute_stresses(world);
  sum_stresses(constants.pressure_scale, cells);
  remains_ = cell_;
}

/// Calls work(begin, end) for fours of pairs that make up all, at once.
template <class Work>
void MechanicsSolver::share_pairs(const Work& work) {
  const std::size_t count = pairs_.first().size();
  share(team_, static_cast<std::uint32_t>((count + 3) / 4), bodies_.size(), work);
}

void MechanicsSolver::load(const WorldState& world) {
  const CellStore& cells = world.cells;
  table_.prepare(world);
  bodies_.resize(cells.size());
  force_.resize(cells.size());
  sum_.resize(cells.size());
  motility_.prepare(world);
  number(cells);
  share_ranges(team_, cells, [&](const CellRange& range) {
    const double inverse_mass = 1.0 / world.state_of(range.begin).mass;
    const std::uint32_t kind = table_.kind(range.organism, range.state);
    for (std::uint32_t i = range.begin; i < range.end; ++i)
      bodies_[place_of_[i]] = {cells.x[i],      cells.y[i],   cells.vx[i], cells.vy[i],
                               cells.radius[i], inverse_mass, kind};
  });
}

void MechanicsSolver::load_external(const ExternalForces& external, const CellStore& cells) {
  external_.clear();
  if (!external && motility_.resting()) return;
  external_x_.assign(bodies_.size(), 0.0);
  external_y_.assign(bodies_.size(), 0.0);
  if (external) external(external_x_, external_y_);
  motility_.add(external_x_, external_y_);
  external_.resize(bodies_.size());
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k)
      external_[k] = Two{external_x_[cell_[k]], external_y_[cell_[k]]};
  });
}

void MechanicsSolver::store(CellStore& cells) const {
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const Body& body = bodies_[place_of_[i]];
      cells.x[i] = body.x;
      cells.y[i] = body.y;
      cells.vx[i] = body.vx;
      cells.vy[i] = body.vy;
    }
  });
}

/// Numbers cells that are more or fewer than before island by island, so that neighbours stand
/// close together in memory; and finds which cell has which place. A numbering holds until pairs
/// are found anew: whoever has the places of a pair is near enough.
void MechanicsSolver::number(const CellStore& cells) {
  if (numbered_ != cells.size()) {
    numbered_ = cells.size();
    const Sites sites{cells.x.data(), cells.y.data(), cells.size(), 1, cells.order};
    if (!number_islands(sites, cells, number_)) number_.clear();
    just_numbered_ = true;
  }
  cell_ = cells.order;
  place_of_ = cells.rank;
  if (!number_.empty()) place(cells);
}

void MechanicsSolver::place(const CellStore& cells) {
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = cells.order[k];
      place_of_[i] = number_[k];
      cell_[number_[k]] = i;
    }
  });
}

bool MechanicsSolver::number_islands(const Sites& sites, const CellStore& cells,
                                     std::vector<std::uint32_t>& numbers) {
  if (sites.count < least_numbered_) return false;
  const double widest = *std::max_element(cells.radius.begin(), cells.radius.end());
  return islands_.number(sites, NeighbourPairs::longest(widest, table_.range(), skin), numbers);
}

/// Cells of different islands may have met.
void MechanicsSolver::renumber(const CellStore& cells) {
  const Sites sites{&bodies_.data()->x, &bodies_.data()->y, bodies_.size(),
                    sizeof(Body) / sizeof(double), number_};
  if (!number_islands(sites, cells, next_number_)) {
    if (number_.empty()) return;
    next_number_.resize(bodies_.size());
    std::iota(next_number_.begin(), next_number_.end(), 0u);
  }
  renumbered_.resize(bodies_.size());
  const bool pushed = !external_.empty();
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t from = number_.empty() ? k : number_[k], to = next_number_[k];
      renumbered_[to] = bodies_[from];
      if (pushed) force_[to] = external_[from];
    }
  });
  bodies_.swap(renumbered_);
  if (pushed) external_.swap(force_);
  number_.swap(next_number_);
  place(cells);
}

void MechanicsSolver::find_pairs(const Mechanics& constants, const CellStore& cells) {
  if (!std::exchange(just_numbered_, false)) renumber(cells);
  // Twice the way of the step, for those who are being pushed.
  pairs_.build(bodies_, table_.range(), skin, 2.0 * constants.substeps * constants.time_step);
  if (parts_ > 1) pairs_.index_by_second(parts_);
  const std::size_t room = pairs_.first().size() + 3;
  if (touching_first_.size() >= room) return;
  pair_force_.resize(2 * room);
  pair_stress_.resize(2 * room);
  touching_.resize(2 * room);
  touching_first_.resize(2 * room);
  touching_second_.resize(2 * room);
  pair_radii_.resize(2 * room / 4 + 1);
  pair_springs_.resize(2 * room / 4 + 1);
}

void MechanicsSolver::list_constants() {
  const PairReader reader(pairs_, bodies_, table_);
  const std::size_t count = pairs_.first().size();
  const Spring* common = table_.common();
  springs_stride_ = common == nullptr ? 1 : 0;
  if (count == 0) return;
  if (common != nullptr)
    pair_springs_[0] = {common->stiffness + Four{}, common->adhesion + Four{},
                        common->range + Four{}, common->contact + Four{}};
  share_pairs([this](std::size_t begin, std::size_t end) { list_constants(begin, end); });
}

void MechanicsSolver::list_constants(std::size_t begin, std::size_t end) {
  const PairReader reader(pairs_, bodies_, table_);
  for (std::size_t four = begin; four < end; ++four) pair_radii_[four] = reader.radii(4 * four);
  if (springs_stride_ == 0) return;
  for (std::size_t four = begin; four < end; ++four) reader.springs(4 * four, pair_springs_[four]);
}

/// Of fours of pairs; returns whether cells of some are at the same place.
bool MechanicsSolver::compute_forces(double damping, std::size_t begin, std::size_t end) {
  const PairReader reader(pairs_, bodies_, table_);
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

void MechanicsSolver::compute_forces(double damping, const WorldState& world) {
  std::atomic<bool> together = false;
  share_pairs([&](std::size_t begin, std::size_t end) {
    if (compute_forces(damping, begin, end)) together = true;
  });
  if (!together) return;

  const PairReader reader(pairs_, bodies_, table_);
  reader.each_coincident([&](std::size_t p) {
    const Body &a = reader.first(p), &b = reader.second(p);
    const Spring& s = reader.spring(p);
    const auto [nx, ny] =
        arbitrary_direction(world, cell_[pairs_.first()[p]], cell_[pairs_.second()[p]]);
    const double dx = a.x - b.x, dy = a.y - b.y;
    const double distance = std::sqrt(dx * dx + dy * dy), radii = a.radius + b.radius;
    const double collision = s.stiffness * std::max(0.0, radii - distance);
    const double pull = s.adhesion * (distance - 0.5 * radii);
    const double approach = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny;
    const double total = collision - pull - damping * approach;
    pair_force_[p] = Two{total * nx, total * ny};
  });
}

/// In the canonical order.
void MechanicsSolver::sum_forces(double drag) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  for (std::uint32_t k = 0; k < count; ++k) {
    const Two velocity{bodies_[k].vx, bodies_[k].vy};
    force_[k] = (external_.empty() ? Two{} : external_[k]) - drag * velocity;
  }
  // What the first does to the second is exactly the opposite.
  const std::uint32_t* second = pairs_.second().data();
  const Two* between = pair_force_.data();
  Two* force = force_.data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Two own = force[k];
    for (std::uint32_t p = pairs_.start(k), end = pairs_.start(k + 1); p < end; ++p) {
      own += between[p];
      force[second[p]] -= between[p];
    }
    force[k] = own;
  }
}

/// The same sum, of one cell.
inline Two MechanicsSolver::summed_force(double drag, std::uint32_t k) const {
  const Two velocity{bodies_[k].vx, bodies_[k].vy};
  Two force = (external_.empty() ? Two{} : external_[k]) - drag * velocity;
  for (const std::uint32_t p : pairs_.as_second(k)) force -= pair_force_[p];
  for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) force += pair_force_[p];
  return force;
}

/// Moves everybody by semi-implicit Euler. Returns whether pairs must be found anew.
bool MechanicsSolver::move(const Mechanics& constants) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  if (parts_ == 1) {
    sum_forces(constants.drag);
    return move(constants, {0, count});
  }
  std::atomic<bool> drifted = false;
  share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) force_[k] = summed_force(constants.drag, k);
    if (move(constants, {begin, end})) drifted = true;
  });
  return drifted;
}

bool MechanicsSolver::move(const Mechanics& constants, Stretch cells) {
  const Two* force = force_.data();
  const double h = constants.time_step;
  bool drifted = false;
  for (std::uint32_t k = cells.begin; k < cells.end; ++k) {
    Body& body = bodies_[k];
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
bool MechanicsSolver::compute_stresses(std::size_t begin, std::size_t end) {
  const PairReader reader(pairs_, bodies_, table_);
  const bool in_parts = parts_ > 1;
  FourMask together{};
  Geometry g;
  std::size_t touching = 0;
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
    for (std::size_t k = 0; !in_parts && k < 4; ++k) {
      touching_first_[touching] = first[p + k];
      touching_second_[touching] = second[p + k];
      touching -= static_cast<std::size_t>(contact[k]);
    }
    together |= g.distance <= coincident;
  }
  if (!in_parts) touching_count_ = touching;
  return any(together);
}

void MechanicsSolver::compute_stresses(const WorldState& world) {
  std::atomic<bool> together = false;
  share_pairs([&](std::size_t begin, std::size_t end) {
    if (compute_stresses(begin, end)) together = true;
  });
  if (!together) return;

  const PairReader reader(pairs_, bodies_, table_);
  reader.each_coincident([&](std::size_t p) {
    const auto [nx, ny] =
        arbitrary_direction(world, cell_[pairs_.first()[p]], cell_[pairs_.second()[p]]);
    const double collision = pair_stress_[p][0];
    pair_stress_[p] =
        Four{collision, collision * nx * nx, collision * nx * ny, collision * ny * ny};
  });
}

inline Four MechanicsSolver::summed_stress(std::uint32_t k) const {
  Four stress{};
  for (const std::uint32_t p : pairs_.as_second(k)) stress += pair_stress_[p];
  for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) stress += pair_stress_[p];
  return stress;
}

void MechanicsSolver::sum_stresses(double pressure_scale, CellStore& cells) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  const auto keep = [&](std::uint32_t k, const Four& stress) {
    const std::uint32_t i = cell_[k];
    cells.pressure[i] = stress[0] / (stress[0] + pressure_scale);
    cells.stress_xx[i] = stress[1];
    cells.stress_xy[i] = stress[2];
    cells.stress_yy[i] = stress[3];
  };
  if (parts_ > 1)
    return share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t k = begin; k < end; ++k) keep(k, summed_stress(k));
    });
  std::fill(sum_.begin(), sum_.end(), Four{});
  const std::uint32_t* second = pairs_.second().data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Four own = sum_[k];
    for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) {
      own += pair_stress_[p];
      sum_[second[p]] += pair_stress_[p];
    }
    keep(k, own);
  }
}

void MechanicsSolver::list_contacts(Contacts& contacts, std::span<const std::uint32_t> new_index) {
  if (!new_index.empty())
    share(team_, static_cast<std::uint32_t>(remains_.size()),
          [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t& cell : std::span(remains_).subspan(begin, end - begin))
              cell = new_index[cell];
          });
  const auto lost = new_index.empty() ? 0 : std::count(remains_.begin(), remains_.end(), gone);
  const std::size_t count = remains_.size() - static_cast<std::size_t>(lost);
  if (parts_ > 1) return list_contacts_in_parts(contacts, count);
  // Count, then place: pair after pair, so each cell's contacts come in canonical order, the lower
  // before the higher. Pairs with the same first follow each other: these are counted without going
  // through memory.
  lower_.assign(count, 0);
  higher_.assign(count, 0);
  std::size_t kept = 0;
  std::uint32_t run = 0, last = gone;
  for (std::size_t t = 0; t < touching_count_; ++t) {
    const std::uint32_t a = remains_[touching_first_[t]], b = remains_[touching_second_[t]];
    if (a == gone || b == gone) continue;
    touching_first_[kept] = a;
    touching_second_[kept++] = b;
    run = a == last ? run + 1 : 1;
    last = a;
    higher_[a] = run;
    ++lower_[b];
  }
  // From counts to where the next one goes.
  contacts.start.resize(count + 1);
  std::uint32_t start = 0;
  for (std::size_t i = 0; i < count; ++i) {
    contacts.start[i] = start;
    const std::uint32_t middle = start + std::exchange(lower_[i], start);
    start = middle + std::exchange(higher_[i], middle);
  }
  contacts.start[count] = start;
  contacts.items.resize(start);
  std::uint32_t* items = contacts.items.data();
  std::uint32_t to = 0;
  last = gone;
  for (std::size_t t = 0; t < kept; ++t) {
    const std::uint32_t a = touching_first_[t], b = touching_second_[t];
    to = a == last ? to + 1 : higher_[a];
    last = a;
    items[to] = b;
    items[lower_[b]++] = a;
  }
  touching_count_ = 0;
}

/// Calls visit(index) for the contacts of a cell in canonical order: the lower, then the higher.
template <class Visit>
void MechanicsSolver::each_contact(std::uint32_t cell, Visit&& visit) const {
  const auto look = [&](std::uint32_t p, std::uint32_t other) {
    if (touching_[p] != 0 && remains_[other] != gone) visit(remains_[other]);
  };
  for (const std::uint32_t p : pairs_.as_second(cell)) look(p, pairs_.first()[p]);
  for (std::uint32_t p = pairs_.start(cell); p < pairs_.start(cell + 1); ++p)
    look(p, pairs_.second()[p]);
}

void MechanicsSolver::list_contacts_in_parts(Contacts& contacts, std::size_t count) {
  const auto cells = static_cast<std::uint32_t>(remains_.size());
  contact_count_.resize(std::max(contact_count_.size(), count));
  share(team_, cells, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) {
      if (remains_[k] == gone) continue;
      std::uint32_t contacts_of_it = 0;
      each_contact(k, [&](std::uint32_t) { ++contacts_of_it; });
      contact_count_[remains_[k]] = contacts_of_it;
    }
  });
  contacts.start.resize(count + 1);
  std::uint32_t start = 0;
  for (std::size_t i = 0; i < count; ++i) {
    contacts.start[i] = start;
    start += contact_count_[i];
  }
  contacts.start[count] = start;
  contacts.items.resize(start);
  share(team_, cells, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) {
      if (remains_[k] == gone) continue;
      std::uint32_t* to = contacts.items.data() + contacts.start[remains_[k]];
      each_contact(k, [&](std::uint32_t other) { *to++ = other; });
    }
  });
}

}  // namespace somas::model
