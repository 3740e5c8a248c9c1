// Phase 8 (docs/model.md, section 3): every cell against every other, in canonical order.
#include <algorithm>
#include <cmath>

#include "somas/sdk/rng.hpp"

#include "tests/core/model/reference/fields.hpp"
#include "tests/core/model/reference/phases.hpp"

namespace somas::reference {

namespace {

struct Vector {
  double x = 0, y = 0;
};

/// What joins two cells.
struct Spring {
  double stiffness = 0, adhesion = 0;
  double range = 1;  ///< where it begins to act, over the sum of the radii
  bool contact = false;
};

Spring spring_between(const World& world, const Cell& a, const Cell& b) {
  const model::State &first = world.state_of(a), &second = world.state_of(b);
  const model::Strangers& strangers = world.config().strangers;
  const bool kin = a.name.organism == b.name.organism;
  Spring spring{.stiffness = 0.5 * (first.stiffness + second.stiffness),
                .contact = kin || strangers.feed};
  if (!kin && !strangers.adhere) return spring;
  spring.range = 0.5 * (first.adhesion_range + second.adhesion_range);
  spring.adhesion = kin ? world.organism_of(a).phenotype->tree->adhesion_between(a.state, b.state)
                        : 0.5 * (first.adhesion + second.adhesion);
  return spring;
}

/// Two cells as one of them sees the other.
struct Pair {
  Spring spring;
  double radii = 0, distance = 0;
  double nx = 0, ny = 0;  ///< from the other towards the one
  double push = 0;        ///< of the collision spring
};

/// From the later one towards the earlier one, when they are at the same place.
Vector drawn_direction(const World& world, const Cell& earlier, const Cell& later) {
  Rng rng(stable_key("core.coincident"), world.organism_of(earlier).key,
          world.organism_of(later).key, earlier.name.id, later.name.id);
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  return {angle.cos, angle.sin};
}

/// Whether the cells are within reach of each other; if so, `pair` says how.
bool meet(const World& world, const Cell& one, const Cell& other, Pair& pair) {
  pair.spring = spring_between(world, one, other);
  pair.radii = one.radius + other.radius;
  const double reach = pair.spring.range * pair.radii;
  const double dx = one.x - other.x, dy = one.y - other.y;
  const double square = dx * dx + dy * dy;
  if (!(reach * reach > square)) return false;

  pair.distance = std::sqrt(square);
  const double inverse = 1.0 / pair.distance;
  pair.nx = dx * inverse;
  pair.ny = dy * inverse;
  if (pair.distance <= 1e-12) {
    const bool earlier = one.name < other.name;
    const Vector drawn =
        earlier ? drawn_direction(world, one, other) : drawn_direction(world, other, one);
    pair.nx = earlier ? drawn.x : -drawn.x;
    pair.ny = earlier ? drawn.y : -drawn.y;
  }
  pair.push = pair.spring.stiffness * std::max(0.0, pair.radii - pair.distance);
  return true;
}

/// Calls visit(other, pair) for all cells within reach of one, in canonical order.
template <class Visit>
void each_partner(const World& world, const Cell& one, bool descending, Visit&& visit) {
  Pair pair;
  for (std::size_t k = 0; k < world.cells.size(); ++k) {
    const Cell& other = world.cells[descending ? world.cells.size() - 1 - k : k];
    if (other.name == one.name || !meet(world, one, other, pair)) continue;
    visit(other, pair);
  }
}

/// Forces of cells that crawl, at the present places.
std::vector<Vector> crawling(World& world) {
  std::vector<Vector> forces;
  for (const Cell& cell : world.cells) {
    Vector& force = forces.emplace_back();
    const model::State& state = world.state_of(cell);
    if (state.motility == 0 || cell.dead) continue;
    const Slope slope =
        slope_at(world.organism_of(cell).fields[state.motility_signal], cell.x, cell.y);
    const double steepness = std::sqrt(slope.x * slope.x + slope.y * slope.y);
    if (!(steepness >= 1e-6)) continue;
    force = {state.motility * (slope.x / steepness), state.motility * (slope.y / steepness)};
    ++world.events.crawls;
  }
  return forces;
}

Vector force_on(World& world, const Cell& cell, const Vector& crawl) {
  const model::Mechanics& m = world.config().mechanics;
  Vector force{(cell.force_x + crawl.x) - m.drag * cell.vx,
               (cell.force_y + crawl.y) - m.drag * cell.vy};
  if (cell.force_x != 0 || cell.force_y != 0) ++world.events.forces_from_outside;
  const bool descending = world.mistake == Mistake::forces_descending;
  each_partner(world, cell, descending, [&](const Cell& other, const Pair& pair) {
    double pull = pair.spring.adhesion * (pair.distance - 0.5 * pair.radii);
    if (world.mistake == Mistake::late_adhesion && pair.distance < pair.radii) pull = 0;
    const double parting = (cell.vx - other.vx) * pair.nx + (cell.vy - other.vy) * pair.ny;
    const double damping = world.mistake == Mistake::no_damper ? 0.0 : m.damping;
    const double total = pair.push - pull - damping * parting;
    force.x += total * pair.nx;
    force.y += total * pair.ny;
    if (pair.distance <= 1e-12) ++world.events.coincident_pairs;
  });
  return force;
}

void substep(World& world, const std::vector<Vector>& crawl) {
  act(Phase::forces, world);
  std::vector<Vector> forces;
  for (std::size_t k = 0; k < world.cells.size(); ++k)
    forces.push_back(force_on(world, world.cells[k], crawl[k]));
  const double h = world.config().mechanics.time_step;
  for (std::size_t k = 0; k < world.cells.size(); ++k) {
    Cell& cell = world.cells[k];
    const double inverse_mass = 1.0 / world.state_of(cell).mass;
    cell.vx += h * (forces[k].x * inverse_mass);
    cell.vy += h * (forces[k].y * inverse_mass);
    cell.x += h * cell.vx;
    cell.y += h * cell.vy;
  }
}

/// Contacts, pressure and stress at the present places.
void look_round(World& world, Cell& cell) {
  double pushes = 0, xx = 0, xy = 0, yy = 0;
  std::vector<Name> contacts;
  const bool descending = world.mistake == Mistake::stress_descending;
  each_partner(world, cell, descending, [&](const Cell& other, const Pair& pair) {
    pushes += pair.push;
    xx += pair.push * pair.nx * pair.nx;
    xy += pair.push * pair.nx * pair.ny;
    yy += pair.push * pair.ny * pair.ny;
    if (pair.spring.contact) contacts.push_back(other.name);
    if (other.name.organism == cell.name.organism) return;
    ++world.events.stranger_touches;
    if (pair.spring.contact) ++world.events.stranger_contacts;
  });
  std::sort(contacts.begin(), contacts.end());
  cell.contacts = contacts;
  cell.pressure = pushes / (pushes + world.config().mechanics.pressure_scale);
  cell.stress_xx = xx;
  cell.stress_xy = xy;
  cell.stress_yy = yy;
}

}  // namespace

void move(World& world) {
  const std::vector<Vector> crawl = crawling(world);
  for (std::uint32_t s = 0; s < world.config().mechanics.substeps; ++s) substep(world, crawl);
  for (Cell& cell : world.cells) look_round(world, cell);
}

}  // namespace somas::reference
