#include "core/model/mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "somas/sdk/math.hpp"

namespace somas::model {

namespace {

// Extra reach of the lists: larger means fewer rebuilds and more pairs to pass over.
constexpr double skin = 0.25;
constexpr double coincident = 1e-12;

struct Pair {
  double nx = 0, ny = 0;  ///< unit vector from the other cell to this one
  double collision = 0;   ///< magnitude of the collision spring's push
  double total = 0;       ///< signed force along n on this cell
  bool contact = false;   ///< the adhesion spring is active
  bool active = false;
};

/// A direction for cells at the very same place, from their two names; opposite for the other one.
std::pair<double, double> arbitrary_direction(const CellStore& cells, std::uint32_t i,
                                              std::uint32_t j) {
  const bool first = cells.rank[i] < cells.rank[j];
  const std::uint32_t a = first ? i : j, b = first ? j : i;
  Rng rng(stable_key("core.coincident"), cells.organism[a], cells.organism[b], cells.id[a],
          cells.id[b]);
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  return first ? std::pair(angle.cos, angle.sin) : std::pair(-angle.cos, -angle.sin);
}

/// Springs and damper between cells i and j, as they act on i.
inline Pair interact(const CellStore& cells, const Body& a, const Body& b, std::uint32_t i,
                     std::uint32_t j, double damping) {
  Pair pair;
  const double dx = a.x - b.x, dy = a.y - b.y;
  const double square = dx * dx + dy * dy;
  const double radii = a.radius + b.radius;
  const bool kin = cells.organism[i] == cells.organism[j];
  const double reach = kin ? 0.5 * (a.range + b.range) * radii : radii;
  if (square >= reach * reach) return pair;

  const double distance = std::sqrt(square);
  if (distance > coincident) {
    const double inverse = 1.0 / distance;
    pair.nx = dx * inverse;
    pair.ny = dy * inverse;
  } else {
    std::tie(pair.nx, pair.ny) = arbitrary_direction(cells, i, j);
  }
  pair.active = true;
  pair.contact = kin;
  if (distance < radii) pair.collision = 0.5 * (a.stiffness + b.stiffness) * (radii - distance);
  const double pull = kin ? 0.5 * (a.adhesion + b.adhesion) * (distance - 0.5 * radii) : 0.0;
  const double approach = (a.vx - b.vx) * pair.nx + (a.vy - b.vy) * pair.ny;
  pair.total = pair.collision - pull - damping * approach;
  return pair;
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
  if (neighbours_.stale(bodies_)) neighbours_.build(bodies_, cells.order, skin);
}

void MechanicsSolver::substep(const Mechanics& constants, const WorldState& world) {
  const CellStore& cells = world.cells;
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  // Every cell gathers its own force in canonical order; pairs are computed twice, exactly
  // opposite.
  for (std::uint32_t i = 0; i < count; ++i) {
    const Body& body = bodies_[i];
    double fx = external_x_[i] - constants.drag * body.vx;
    double fy = external_y_[i] - constants.drag * body.vy;
    for (const std::uint32_t j : neighbours_.of(i)) {
      const Pair pair = interact(cells, body, bodies_[j], i, j, constants.damping);
      if (!pair.active) continue;
      fx += pair.total * pair.nx;
      fy += pair.total * pair.ny;
    }
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
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    double push = 0, xx = 0, xy = 0, yy = 0;
    contacts.start[i] = static_cast<std::uint32_t>(contacts.items.size());
    for (const std::uint32_t j : neighbours_.of(i)) {
      const Pair pair = interact(cells, bodies_[i], bodies_[j], i, j, constants.damping);
      if (pair.contact) contacts.items.push_back(j);
      if (!(pair.collision > 0)) continue;
      push += pair.collision;
      xx += pair.collision * pair.nx * pair.nx;
      xy += pair.collision * pair.nx * pair.ny;
      yy += pair.collision * pair.ny * pair.ny;
    }
    cells.pressure[i] = push / (push + constants.pressure_scale);
    cells.stress_xx[i] = xx;
    cells.stress_xy[i] = xy;
    cells.stress_yy[i] = yy;
  }
  contacts.start[cells.size()] = static_cast<std::uint32_t>(contacts.items.size());
}

}  // namespace somas::model
