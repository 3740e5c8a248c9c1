#include "plugins/environments/particle_aggression/particle_aggression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "somas/sdk/math.hpp"

namespace somas::environments {

/// The rows of the table; valid until it is resized. Velocities are per step.
struct ParticleAggression::Particles {
  explicit Particles(Table& t)
      : x(t.column(0)), y(t.column(1)), vx(t.column(2)), vy(t.column(3)), energy(t.column(4)) {}
  std::span<double> x, y, vx, vy, energy;
};

namespace {

constexpr double most_particles = 1e7;
/// Of a block. Many, since the host may share the search for hits among threads.
constexpr std::size_t most_paths = 4096;
/// 0 or 1 for each particle of a block, with room to look at eight at a time.
using Marks = std::array<std::int64_t, most_paths + 8>;
constexpr double nowhere = std::numeric_limits<double>::infinity();
constexpr std::string_view column_names[] = {"x", "y", "vx", "vy", "energy"};

/// Calls visit(k) for the eight around each mark that is set, in order: most are far from any.
template <class Visit>
void each_group(const Marks& marks, std::size_t count, const Visit& visit) {
  for (std::size_t group = 0; group < count; group += 8) {
    std::int64_t any = 0;
    for (std::size_t k = group; k < group + 8; ++k) any |= marks[k];
    if (any == 0) continue;
    for (std::size_t k = group; k < std::min(group + 8, count); ++k) visit(k);
  }
}

}  // namespace

void ParticleAggression::declare(Declare& declare) {
  spawn_radius_ = parameters_.spawn_radius.value_or(declare.world().radius);
  check_number(declare.world().max_steps);
  particles_ = declare.table("particles", column_names);
  due_ = declare.scalar("due", 0);
  serial_ = declare.scalar("serial", 0);
  hazard_ = declare.hazard(declare.instance(), declare.skill(parameters_.resistance_skill, {}));
  purpose_ = declare.purpose("emission");
  rate_scale_ = declare.parameter("rate_scale", {.value = parameters_.rate_scale, .minimum = 0});
  declare.acts_in(Phase::stress);
}

double ParticleAggression::rate(double t, double scale) const {
  return scale * (parameters_.rate_constant +
                  (parameters_.rate_linear + parameters_.rate_quadratic * t) * t);
}

/// Refuses what would fill the memory: the rate is greatest at the end, and a particle crosses the
/// circle in at most 2 radii / speed steps.
void ParticleAggression::check_number(std::uint64_t max_steps) const {
  const auto start = static_cast<std::uint64_t>(parameters_.start);
  if (start >= max_steps) return;
  const double last = rate(static_cast<double>(max_steps - 1 - start), parameters_.rate_scale);
  if (!(last * (2 * spawn_radius_ / parameters_.speed + 1) <= most_particles))
    throw ParameterError("rate_scale",
                         "more than ten million particles at a time could be in flight at the "
                         "last step; lower the rate, raise 'speed' or shorten the run");
}

void ParticleAggression::act(Phase, World& world) const {
  if (world.step() < static_cast<std::uint64_t>(parameters_.start)) return;
  emit(world);
  fly(world);
}

void ParticleAggression::emit(World& world) const {
  // Whole particles fly, the rest is carried over.
  double& due = world.scalar(due_);
  const std::uint64_t t = world.step() - static_cast<std::uint64_t>(parameters_.start);
  due += rate(static_cast<double>(t), world.parameter(rate_scale_));
  const double whole = std::floor(due);
  due -= whole;

  Table& table = world.table(particles_);
  const std::uint32_t old_rows = table.rows();
  if (!(old_rows + whole <= most_particles))
    throw std::runtime_error("more than ten million particles would be in flight");
  table.resize(old_rows + static_cast<std::uint32_t>(whole));

  // A particle's chance hangs on its number alone.
  double& serial = world.scalar(serial_);
  const Particles p(table);
  for (std::uint32_t i = old_rows; i < table.rows(); ++i) {
    launch(p, i, world.rng(purpose_, static_cast<std::uint64_t>(serial)));
    p.energy[i] = parameters_.energy;
    serial += 1;
  }
}

/// Puts particle `i` on the circle at an even angle, headed for a point near the centre.
void ParticleAggression::launch(const Particles& p, std::size_t i, Rng rng) const {
  const double radius = spawn_radius_, spread = parameters_.aim_spread, speed = parameters_.speed;
  const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
  const auto [aim_x, aim_y] = rng.normals();
  p.x[i] = radius * angle.cos;
  p.y[i] = radius * angle.sin;
  double dx = spread * aim_x - p.x[i];
  double dy = spread * aim_y - p.y[i];
  double distance = std::sqrt(dx * dx + dy * dy);
  // Aimed at where it stands: no direction, so take the centre's.
  if (distance == 0) {
    dx = -p.x[i];
    dy = -p.y[i];
    distance = radius;
  }
  p.vx[i] = speed * (dx / distance);
  p.vy[i] = speed * (dy / distance);
}

/// A rectangle that holds all cells; empty, and so far from everything, when there are none.
struct ParticleAggression::Box {
  explicit Box(const Cells& cells) {
    for (std::uint32_t i = 0; i < cells.count; ++i) {
      left = std::min(left, cells.x[i] - cells.radius[i]);
      right = std::max(right, cells.x[i] + cells.radius[i]);
      bottom = std::min(bottom, cells.y[i] - cells.radius[i]);
      top = std::max(top, cells.y[i] + cells.radius[i]);
    }
  }
  double left = nowhere, right = -nowhere, bottom = nowhere, top = -nowhere;
};

/// Particles that fly side by side.
struct ParticleAggression::Block {
  std::size_t count = 0;
  std::array<double, most_paths> x, y;  ///< where they come to
  Marks near;                           ///< 1: may meet a cell on the way
  Marks leaves;                         ///< 1: past the far side, or spent
  // Of those that are near, with room for one more: the place in the block, the path, who is hit.
  std::array<std::uint32_t, most_paths + 1> place;
  std::array<Segment, most_paths + 1> paths;
  std::array<std::int32_t, most_paths> hits;
  std::size_t near_count = 0;
};

void ParticleAggression::fly(World& world) const {
  Table& table = world.table(particles_);
  const Particles p(table);
  const Box inhabited(world.cells());
  // A block at a time, so that its paths are still in a cache when the hits are known.
  Block block;
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < table.rows(); begin += most_paths) {
    block.count = std::min(most_paths, table.rows() - begin);
    advance(p, begin, inhabited, block);
    if (block.near_count > 0)
      world.first_hit(std::span(block.paths).first(block.near_count),
                      std::span(block.hits).first(block.near_count));
    kept = settle(world, p, begin, kept, block);
  }
  table.resize(static_cast<std::uint32_t>(kept));
}

/// Where the particles from `begin` on come to, who leaves, and the paths of those that come near
/// the cells: most are too far off to meet any.
void ParticleAggression::advance(const Particles& p, std::size_t begin, const Box& inhabited,
                                 Block& block) const {
  const double limit = spawn_radius_ * spawn_radius_;
  const double* x0 = &p.x[begin];
  const double* y0 = &p.y[begin];
  const double* vx = &p.vx[begin];
  const double* vy = &p.vy[begin];
  for (std::size_t k = 0; k < block.count; ++k) {
    const double x = x0[k] + vx[k], y = y0[k] + vy[k];
    const double low_x = x < x0[k] ? x : x0[k], high_x = x < x0[k] ? x0[k] : x;
    const double low_y = y < y0[k] ? y : y0[k], high_y = y < y0[k] ? y0[k] : y;
    const bool across = (high_x >= inhabited.left) & (low_x <= inhabited.right);
    const bool up = (high_y >= inhabited.bottom) & (low_y <= inhabited.top);
    const bool beyond = x * x + y * y > limit, outwards = x * vx[k] + y * vy[k] > 0;
    block.x[k] = x;
    block.y[k] = y;
    block.near[k] = (across & up) ? 1 : 0;
    block.leaves[k] = (beyond & outwards) ? 1 : 0;
  }
  std::fill_n(block.near.begin() + block.count, 8, 0);
  std::fill_n(block.leaves.begin() + block.count, 8, 0);
  // Those launched together come near together.
  block.near_count = 0;
  each_group(block.near, block.count, [&](std::size_t k) {
    block.place[block.near_count] = static_cast<std::uint32_t>(k);
    block.paths[block.near_count] = {x0[k], y0[k], block.x[k], block.y[k]};
    block.near_count += static_cast<std::size_t>(block.near[k]);
  });
}

/// Particles from `begin` on fly: they strike, and who is neither spent nor gone past the far side
/// closes the ranks behind the `kept` ones, in order. Returns how many are.
std::size_t ParticleAggression::settle(World& world, const Particles& p, std::size_t begin,
                                       std::size_t kept, Block& block) const {
  for (std::size_t n = 0; n < block.near_count; ++n) {
    if (block.hits[n] < 0) continue;
    const std::uint32_t k = block.place[n];
    block.leaves[k] = 1;
    world.strike(static_cast<std::uint32_t>(block.hits[n]), hazard_, p.energy[begin + k]);
  }
  std::array<std::uint32_t, most_paths + 1> leaving;
  std::size_t left = 0;
  each_group(block.leaves, block.count, [&](std::size_t k) {
    leaving[left] = static_cast<std::uint32_t>(k);
    left += static_cast<std::size_t>(block.leaves[k]);
  });

  // The runs between them move up.
  leaving[left] = static_cast<std::uint32_t>(block.count);
  std::size_t from = 0;
  for (std::size_t n = 0; n <= left; ++n) {
    const std::size_t to = leaving[n];
    std::copy_n(block.x.begin() + from, to - from, p.x.begin() + kept);
    std::copy_n(block.y.begin() + from, to - from, p.y.begin() + kept);
    // The energy is everybody's: that column may stay.
    for (const std::span<double> column : {p.vx, p.vy})
      if (kept != begin + from)
        std::copy_n(column.begin() + begin + from, to - from, column.begin() + kept);
    kept += to - from;
    from = to + 1;
  }
  return kept;
}

}  // namespace somas::environments
