#include "core/model/mechanics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "somas/sdk/math.hpp"

namespace somas::model {

namespace {

// Extra reach of the lists: larger means fewer rebuilds and more pairs to pass over.
constexpr double skin = 0.3;
constexpr double coincident = 1e-12;

/// A direction for cells at the very same place, from their two names; opposite for the other one.
std::pair<double, double> arbitrary_direction(const WorldState& world, std::uint32_t i,
                                              std::uint32_t j) {
  const CellStore& cells = world.cells;
  const bool first = cells.rank[i] < cells.rank[j];
  const std::uint32_t a = first ? i : j, b = first ? j : i;
  Rng rng(stable_key("core.coincident"), world.organisms[cells.organism[a]].key,
          world.organisms[cells.organism[b]].key, cells.id[a], cells.id[b]);
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  return first ? std::pair(angle.cos, angle.sin) : std::pair(-angle.cos, -angle.sin);
}

/// Four doubles that the compiler keeps in one register where there is one so wide.
using Four = double __attribute__((vector_size(32)));
using Mask = std::int64_t __attribute__((vector_size(32)));

/// Springs and dampers between one cell and a block of its neighbours, as they act on that cell.
/// Pairs are worked out four at a time and summed by the caller one after another, so the order of
/// sums stays the lists' own. What i feels from j is exactly the opposite of what j feels from i.
class PairBlock {
 public:
  static constexpr std::uint32_t capacity = 32;

  PairBlock(const WorldState& world, std::span<const Body> bodies, double damping)
      : world_(world),
        bodies_(bodies),
        damping_(damping),
        one_organism_(world.organisms.size() == 1),
        uniform_(alike(bodies)) {}

  /// Precondition: 1 to `capacity` neighbours.
  void compute(std::uint32_t i, std::span<const std::uint32_t> neighbours) {
    const std::size_t last = neighbours.size() - 1;
    Mask together{};
    for (std::size_t k = 0; k <= last; k += 4) {
      // The last group repeats its last pair, which nobody reads twice.
      const std::array<std::uint32_t, 4> four{neighbours[k], neighbours[std::min(k + 1, last)],
                                              neighbours[std::min(k + 2, last)],
                                              neighbours[std::min(k + 3, last)]};
      together |= interact(i, four, k / 4);
    }
    if ((together[0] | together[1] | together[2] | together[3]) != 0) separate(i, neighbours);
  }

  [[nodiscard]] bool kin(std::uint32_t i, std::uint32_t j) const {
    return one_organism_ || world_.cells.organism[i] == world_.cells.organism[j];
  }
  [[nodiscard]] bool near(std::size_t k) const { return gap_[k / 4][k % 4] > 0; }
  [[nodiscard]] double collision(std::size_t k) const { return collision_[k / 4][k % 4]; }
  /// Force on the cell; 0 out of reach.
  [[nodiscard]] double fx(std::size_t k) const { return fx_[k / 4][k % 4]; }
  [[nodiscard]] double fy(std::size_t k) const { return fy_[k / 4][k % 4]; }
  [[nodiscard]] double nx(std::size_t k) const { return nx_[k / 4][k % 4]; }
  [[nodiscard]] double ny(std::size_t k) const { return ny_[k / 4][k % 4]; }

 private:
  /// Works out group `g`; not 0 where a pair is at the very same place.
  Mask interact(std::uint32_t i, const std::array<std::uint32_t, 4>& four, std::size_t g) {
    const Body& a = bodies_[i];
    const Body &b0 = bodies_[four[0]], &b1 = bodies_[four[1]], &b2 = bodies_[four[2]],
               &b3 = bodies_[four[3]];
    const Four dx = a.x - Four{b0.x, b1.x, b2.x, b3.x};
    const Four dy = a.y - Four{b0.y, b1.y, b2.y, b3.y};
    const Four square = dx * dx + dy * dy;
    const Four distance{std::sqrt(square[0]), std::sqrt(square[1]), std::sqrt(square[2]),
                        std::sqrt(square[3])};
    const Four inverse = 1.0 / distance;
    const Four nx = dx * inverse, ny = dy * inverse;

    const Four radii = a.radius + Four{b0.radius, b1.radius, b2.radius, b3.radius};
    Four range = a.range + Four{}, stiffness = a.stiffness + Four{}, adhesion = a.adhesion + Four{};
    if (!uniform_) {
      range = 0.5 * (a.range + Four{b0.range, b1.range, b2.range, b3.range});
      stiffness =
          0.5 * (a.stiffness + Four{b0.stiffness, b1.stiffness, b2.stiffness, b3.stiffness});
      adhesion = 0.5 * (a.adhesion + Four{b0.adhesion, b1.adhesion, b2.adhesion, b3.adhesion});
    }
    Four reach = range * radii;
    if (!one_organism_) {
      // Strangers collide but do not adhere.
      for (std::size_t k = 0; k < 4; ++k) {
        if (kin(i, four[k])) continue;
        adhesion[k] = 0;
        reach[k] = radii[k];
      }
    }

    const Four overlap = radii - distance;
    const Four collision = overlap > 0 ? stiffness * overlap : Four{};
    const Four pull = adhesion * (distance - 0.5 * radii);
    const Four approach = (a.vx - Four{b0.vx, b1.vx, b2.vx, b3.vx}) * nx +
                          (a.vy - Four{b0.vy, b1.vy, b2.vy, b3.vy}) * ny;
    gap_[g] = reach * reach - square;
    nx_[g] = nx;
    ny_[g] = ny;
    collision_[g] = collision;
    const Four total = gap_[g] > 0 ? collision - pull - damping_ * approach : Four{};
    fx_[g] = total * nx;
    fy_[g] = total * ny;
    return distance <= coincident;
  }

  void separate(std::uint32_t i, std::span<const std::uint32_t> neighbours) {
    const Body& a = bodies_[i];
    for (std::size_t k = 0; k < neighbours.size(); ++k) {
      const Body& b = bodies_[neighbours[k]];
      const double dx = a.x - b.x, dy = a.y - b.y;
      const double distance = std::sqrt(dx * dx + dy * dy);
      if (distance > coincident) continue;
      const auto [nx, ny] = arbitrary_direction(world_, i, neighbours[k]);
      const double adhesion = kin(i, neighbours[k]) ? 0.5 * (a.adhesion + b.adhesion) : 0.0;
      const double pull = adhesion * (distance - 0.5 * (a.radius + b.radius));
      const double approach = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny;
      nx_[k / 4][k % 4] = nx;
      ny_[k / 4][k % 4] = ny;
      const double total = collision_[k / 4][k % 4] - pull - damping_ * approach;
      fx_[k / 4][k % 4] = total * nx;
      fy_[k / 4][k % 4] = total * ny;
    }
  }

  static bool alike(std::span<const Body> bodies) {
    return std::all_of(bodies.begin(), bodies.end(), [&](const Body& b) {
      const Body& first = bodies.front();
      return b.stiffness == first.stiffness && b.adhesion == first.adhesion &&
             b.range == first.range;
    });
  }

  const WorldState& world_;
  std::span<const Body> bodies_;
  double damping_;
  bool one_organism_;
  bool uniform_;  ///< every mean of two cells' springs is the value of either, exactly
  std::array<Four, capacity / 4> gap_, nx_, ny_, collision_, fx_, fy_;
};

/// Calls visit(block, first) for all neighbours of a cell, a block at a time, in order.
template <class Visit>
void for_each_block(PairBlock& block, std::uint32_t i, std::span<const std::uint32_t> neighbours,
                    Visit&& visit) {
  for (std::size_t first = 0; first < neighbours.size(); first += PairBlock::capacity) {
    const std::size_t count = std::min<std::size_t>(PairBlock::capacity, neighbours.size() - first);
    const std::span<const std::uint32_t> part = neighbours.subspan(first, count);
    block.compute(i, part);
    visit(part);
  }
}

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
  for (std::uint32_t s = 0; s < constants.substeps; ++s) {
    if (external) {
      if (s > 0) store(cells);
      external_x_.assign(cells.size(), 0.0);
      external_y_.assign(cells.size(), 0.0);
      external(external_x_, external_y_);
    }
    refresh_neighbours(cells);
    substep(constants, world);
  }
  store(cells);
  refresh_neighbours(cells);
  observe(constants, world);
}

void MechanicsSolver::load(const WorldState& world) {
  const CellStore& cells = world.cells;
  bodies_.resize(cells.size());
  inverse_mass_.resize(cells.size());
  fx_.resize(cells.size());
  fy_.resize(cells.size());
  external_x_.assign(cells.size(), 0.0);
  external_y_.assign(cells.size(), 0.0);
  for (const CellRange& range : cells.ranges) {
    const State& state = world.state_of(range.begin);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      bodies_[i] = {cells.x[i],      cells.y[i],      cells.vx[i],    cells.vy[i],
                    cells.radius[i], state.stiffness, state.adhesion, state.adhesion_range};
      inverse_mass_[i] = 1.0 / state.mass;
    }
  }
}

void MechanicsSolver::store(CellStore& cells) const {
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    cells.x[i] = bodies_[i].x;
    cells.y[i] = bodies_[i].y;
    cells.vx[i] = bodies_[i].vx;
    cells.vy[i] = bodies_[i].vy;
  }
}

void MechanicsSolver::refresh_neighbours(const CellStore& cells) {
  neighbours_.refresh(bodies_, cells.order, cells.rank, skin);
}

void MechanicsSolver::substep(const Mechanics& constants, const WorldState& world) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  PairBlock block(world, bodies_, constants.damping);
  // Every cell gathers its own force in canonical order; pairs are computed twice, exactly
  // opposite.
  for (std::uint32_t i = 0; i < count; ++i) {
    const Body& body = bodies_[i];
    double fx = external_x_[i] - constants.drag * body.vx;
    double fy = external_y_[i] - constants.drag * body.vy;
    for_each_block(block, i, neighbours_.of(i), [&](std::span<const std::uint32_t> part) {
      for (std::size_t k = 0; k < part.size(); ++k) {
        fx += block.fx(k);
        fy += block.fy(k);
      }
    });
    fx_[i] = fx;
    fy_[i] = fy;
  }
  // Semi-implicit Euler.
  const double h = constants.time_step;
  for (std::uint32_t i = 0; i < count; ++i) {
    Body& body = bodies_[i];
    body.vx += h * (fx_[i] * inverse_mass_[i]);
    body.vy += h * (fy_[i] * inverse_mass_[i]);
    body.x += h * body.vx;
    body.y += h * body.vy;
  }
}

void MechanicsSolver::observe(const Mechanics& constants, WorldState& world) {
  CellStore& cells = world.cells;
  Contacts& contacts = world.contacts;
  contacts.start.resize(cells.size() + 1);
  contacts.items.clear();
  PairBlock block(world, bodies_, constants.damping);
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    double push = 0, xx = 0, xy = 0, yy = 0;
    contacts.start[i] = static_cast<std::uint32_t>(contacts.items.size());
    for_each_block(block, i, neighbours_.of(i), [&](std::span<const std::uint32_t> part) {
      for (std::size_t k = 0; k < part.size(); ++k) {
        if (block.near(k) && block.kin(i, part[k])) contacts.items.push_back(part[k]);
        const double collision = block.collision(k);
        push += collision;
        xx += collision * block.nx(k) * block.nx(k);
        xy += collision * block.nx(k) * block.ny(k);
        yy += collision * block.ny(k) * block.ny(k);
      }
    });
    cells.pressure[i] = push / (push + constants.pressure_scale);
    cells.stress_xx[i] = xx;
    cells.stress_xy[i] = xy;
    cells.stress_yy[i] = yy;
  }
  contacts.start[cells.size()] = static_cast<std::uint32_t>(contacts.items.size());
}

}  // namespace somas::model
