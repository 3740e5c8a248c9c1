#include "core/model/mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "somas/sdk/math.hpp"

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

  /// What stays the same while the pairs and the radii do.
  void constants(std::size_t p, PairConstants& constants) const {
    // Stiffness, adhesion, range and contact.
    Four spring[4];
    const Spring* common = table_.common();
    if (common == nullptr) {
      read_columns(this->spring(p), this->spring(p + 1), this->spring(p + 2), this->spring(p + 3),
                   spring);
    } else {
      spring[0] = common->stiffness + Four{};
      spring[1] = common->adhesion + Four{};
      spring[2] = common->range + Four{};
      spring[3] = common->contact + Four{};
    }
    constants.radii =
        Four{first(p).radius, first(p + 1).radius, first(p + 2).radius, first(p + 3).radius} +
        Four{second(p).radius, second(p + 1).radius, second(p + 2).radius, second(p + 3).radius};
    const Four reach = spring[2] * constants.radii;
    constants.reach_square = reach * reach;
    constants.stiffness = spring[0];
    constants.adhesion = spring[1];
    constants.contact = spring[3];
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
  load(world);
  if (pairs_.stale(bodies_, table_.range())) find_pairs(constants);
  list_constants();  // radii and states may have changed
  for (std::uint32_t s = 0; s < constants.substeps; ++s) {
    if (external && s > 0) store(cells);
    if (external || s == 0) load_external(external);
    substep(constants, world);
    if (!pairs_.stale(bodies_, table_.range())) continue;
    find_pairs(constants);
    list_constants();
  }
  store(cells);
  compute_stresses(world);
  sum_stresses(constants.pressure_scale, cells);
  list_contacts(world);
}

void MechanicsSolver::load(const WorldState& world) {
  const CellStore& cells = world.cells;
  table_.prepare(world);
  bodies_.resize(cells.size());
  force_.resize(cells.size());
  sum_.resize(cells.size());
  motility_.prepare(world);
  for (const CellRange& range : cells.ranges) {
    const double inverse_mass = 1.0 / world.state_of(range.begin).mass;
    const std::uint32_t kind = table_.kind(range.organism, range.state);
    for (std::uint32_t i = range.begin; i < range.end; ++i)
      bodies_[cells.rank[i]] = {cells.x[i],      cells.y[i],   cells.vx[i], cells.vy[i],
                                cells.radius[i], inverse_mass, kind};
  }
}

void MechanicsSolver::load_external(const ExternalForces& external) {
  external_x_.assign(bodies_.size(), 0.0);
  external_y_.assign(bodies_.size(), 0.0);
  if (external) external(external_x_, external_y_);
  motility_.add(external_x_, external_y_);
}

void MechanicsSolver::store(CellStore& cells) const {
  for (std::uint32_t k = 0; k < bodies_.size(); ++k) {
    const std::uint32_t i = cells.order[k];
    cells.x[i] = bodies_[k].x;
    cells.y[i] = bodies_[k].y;
    cells.vx[i] = bodies_[k].vx;
    cells.vy[i] = bodies_[k].vy;
  }
}

void MechanicsSolver::find_pairs(const Mechanics& constants) {
  // Twice the way of the step, for those who are being pushed.
  pairs_.build(bodies_, table_.range(), skin, 2.0 * constants.substeps * constants.time_step);
  const std::size_t room = pairs_.first().size() + 3;
  if (touching_first_.size() >= room) return;
  pair_force_.resize(2 * room);
  pair_stress_.resize(2 * room);
  touching_first_.resize(2 * room);
  touching_second_.resize(2 * room);
  pair_constants_.resize(2 * room / 4 + 1);
}

void MechanicsSolver::list_constants() {
  const PairReader reader(pairs_, bodies_, table_);
  for (std::size_t p = 0; p < pairs_.first().size(); p += 4)
    reader.constants(p, pair_constants_[p / 4]);
}

void MechanicsSolver::substep(const Mechanics& constants, const WorldState& world) {
  compute_forces(constants.damping, world);
  sum_forces(constants.drag, world);
  // Semi-implicit Euler.
  const double h = constants.time_step;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& body = bodies_[k];
    body.vx += h * (force_[k][0] * body.inverse_mass);
    body.vy += h * (force_[k][1] * body.inverse_mass);
    body.x += h * body.vx;
    body.y += h * body.vy;
  }
}

void MechanicsSolver::compute_forces(double damping, const WorldState& world) {
  const PairReader reader(pairs_, bodies_, table_);
  FourMask together{};
  Geometry g;
  for (std::size_t p = 0; p < pairs_.first().size(); p += 4) {
    const PairConstants& pair = pair_constants_[p / 4];
    reader.geometry(p, g);
    const Four overlap = pair.radii - g.distance;
    const Four collision = overlap > 0 ? pair.stiffness * overlap : Four{};
    const Four pull = pair.adhesion * (g.distance - 0.5 * pair.radii);
    const Four approach = g.vx * g.nx + g.vy * g.ny;
    const Four total =
        pair.reach_square - g.square > 0 ? collision - pull - damping * approach : Four{};
    write_interleaved(total * g.nx, total * g.ny, &pair_force_[p]);
    together |= g.distance <= coincident;
  }
  if (!any(together)) return;

  reader.each_coincident([&](std::size_t p) {
    const Body &a = reader.first(p), &b = reader.second(p);
    const Spring& s = reader.spring(p);
    const auto [nx, ny] = arbitrary_direction(world, world.cells.order[pairs_.first()[p]],
                                              world.cells.order[pairs_.second()[p]]);
    const double dx = a.x - b.x, dy = a.y - b.y;
    const double distance = std::sqrt(dx * dx + dy * dy), radii = a.radius + b.radius;
    const double collision = s.stiffness * std::max(0.0, radii - distance);
    const double pull = s.adhesion * (distance - 0.5 * radii);
    const double approach = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny;
    const double total = collision - pull - damping * approach;
    pair_force_[p] = Two{total * nx, total * ny};
  });
}

void MechanicsSolver::sum_forces(double drag, const WorldState& world) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t i = world.cells.order[k];
    force_[k] = Two{external_x_[i] - drag * bodies_[k].vx, external_y_[i] - drag * bodies_[k].vy};
  }
  // What the first does to the second is exactly the opposite.
  const std::uint32_t* second = pairs_.second().data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Two own = force_[k];
    for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) {
      own += pair_force_[p];
      force_[second[p]] -= pair_force_[p];
    }
    force_[k] = own;
  }
}

void MechanicsSolver::compute_stresses(const WorldState& world) {
  const PairReader reader(pairs_, bodies_, table_);
  FourMask together{};
  Geometry g;
  std::size_t touching = 0;
  const std::uint32_t* first = pairs_.first().data();
  const std::uint32_t* second = pairs_.second().data();
  const std::size_t count = pairs_.first().size();
  for (std::size_t p = 0; p < count; p += 4) {
    const PairConstants& pair = pair_constants_[p / 4];
    reader.geometry(p, g);
    const Four overlap = pair.radii - g.distance;
    const Four collision = overlap > 0 ? pair.stiffness * overlap : Four{};
    const Four along_x = collision * g.nx, along_y = collision * g.ny;
    const Four parts[4] = {collision, along_x * g.nx, along_x * g.ny, along_y * g.ny};
    transpose(parts, *reinterpret_cast<Four(*)[4]>(&pair_stress_[p]));
    // The last four may go on past the end.
    constexpr FourMask lanes{0, 1, 2, 3};
    const FourMask contact = (pair.reach_square - g.square > 0) & (pair.contact > 0) &
                             (lanes < static_cast<std::int64_t>(count - p));
    for (std::size_t k = 0; k < 4; ++k) {
      touching_first_[touching] = first[p + k];
      touching_second_[touching] = second[p + k];
      touching -= static_cast<std::size_t>(contact[k]);
    }
    together |= g.distance <= coincident;
  }
  touching_count_ = touching;
  if (!any(together)) return;

  reader.each_coincident([&](std::size_t p) {
    const auto [nx, ny] = arbitrary_direction(world, world.cells.order[pairs_.first()[p]],
                                              world.cells.order[pairs_.second()[p]]);
    const double collision = pair_stress_[p][0];
    pair_stress_[p] =
        Four{collision, collision * nx * nx, collision * nx * ny, collision * ny * ny};
  });
}

void MechanicsSolver::sum_stresses(double pressure_scale, CellStore& cells) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  std::fill(sum_.begin(), sum_.end(), Four{});
  const std::uint32_t* second = pairs_.second().data();
  for (std::uint32_t k = 0; k < count; ++k) {
    Four own = sum_[k];
    for (std::uint32_t p = pairs_.start(k); p < pairs_.start(k + 1); ++p) {
      own += pair_stress_[p];
      sum_[second[p]] += pair_stress_[p];
    }
    const std::uint32_t i = cells.order[k];
    cells.pressure[i] = own[0] / (own[0] + pressure_scale);
    cells.stress_xx[i] = own[1];
    cells.stress_xy[i] = own[2];
    cells.stress_yy[i] = own[3];
  }
}

void MechanicsSolver::list_contacts(WorldState& world) {
  const std::vector<std::uint32_t>&order = world.cells.order, &rank = world.cells.rank;
  Contacts& contacts = world.contacts;
  // Count, then place: pair after pair, so each cell's contacts come in canonical order.
  cursor_.assign(bodies_.size(), 0);
  for (std::size_t t = 0; t < touching_count_; ++t) {
    ++cursor_[touching_first_[t]];
    ++cursor_[touching_second_[t]];
  }
  contacts.start.resize(bodies_.size() + 1);
  std::uint32_t start = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    contacts.start[i] = start;
    start += std::exchange(cursor_[rank[i]], start);
  }
  contacts.start[bodies_.size()] = start;
  contacts.items.resize(start);
  for (std::size_t t = 0; t < touching_count_; ++t) {
    const std::uint32_t a = touching_first_[t], b = touching_second_[t];
    contacts.items[cursor_[a]++] = order[b];
    contacts.items[cursor_[b]++] = order[a];
  }
}

}  // namespace somas::model
