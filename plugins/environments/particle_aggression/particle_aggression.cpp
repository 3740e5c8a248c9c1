#include "plugins/environments/particle_aggression/particle_aggression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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
constexpr std::size_t most_paths = 128;  // of a block
constexpr std::string_view column_names[] = {"x", "y", "vx", "vy", "energy"};

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

void ParticleAggression::fly(World& world) const {
  Table& table = world.table(particles_);
  const Particles p(table);
  // A block at a time, so that its paths are still near when the hits are known.
  std::array<Segment, most_paths> paths;
  std::array<std::int32_t, most_paths> hits;
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < table.rows(); begin += most_paths) {
    const std::size_t count = std::min(most_paths, table.rows() - begin);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = begin + k;
      paths[k] = {p.x[i], p.y[i], p.x[i] + p.vx[i], p.y[i] + p.vy[i]};
    }
    world.first_hit(std::span(paths).first(count), std::span(hits).first(count));
    kept = settle(world, p, begin, kept, std::span(hits).first(count));
  }
  table.resize(static_cast<std::uint32_t>(kept));
}

/// Particles from `begin` on fly, one for each of `hits`: they strike, and who is neither spent nor
/// gone past the far side closes the ranks behind the `kept` ones, in order. Returns how many are.
std::size_t ParticleAggression::settle(World& world, const Particles& p, std::size_t begin,
                                       std::size_t kept, std::span<const std::int32_t> hits) const {
  // Few leave: mark them all side by side, then look for marks eight at a time.
  const double limit = spawn_radius_ * spawn_radius_;
  std::array<double, most_paths> x, y;
  alignas(8) std::array<std::uint8_t, most_paths> leaves{};
  for (std::size_t k = 0; k < hits.size(); ++k) {
    x[k] = p.x[begin + k] + p.vx[begin + k];
    y[k] = p.y[begin + k] + p.vy[begin + k];
    const bool beyond = x[k] * x[k] + y[k] * y[k] > limit;
    const bool outwards = x[k] * p.vx[begin + k] + y[k] * p.vy[begin + k] > 0;
    leaves[k] = (hits[k] >= 0) | (beyond & outwards);
  }
  std::array<std::uint32_t, most_paths + 1> leaving;
  std::size_t left = 0;
  for (std::size_t k = 0; k < hits.size(); k += 8) {
    std::uint64_t marks;
    std::memcpy(&marks, &leaves[k], sizeof marks);
    for (std::size_t n = k; marks != 0 && n < k + 8; ++n)
      if (leaves[n] != 0) leaving[left++] = static_cast<std::uint32_t>(n);
  }
  for (std::size_t n = 0; n < left; ++n) {
    const std::uint32_t k = leaving[n];
    if (hits[k] >= 0)
      world.strike(static_cast<std::uint32_t>(hits[k]), hazard_, p.energy[begin + k]);
  }

  // The runs between them move up.
  leaving[left] = static_cast<std::uint32_t>(hits.size());
  std::size_t from = 0;
  for (std::size_t n = 0; n <= left; ++n) {
    const std::size_t to = leaving[n];
    std::copy_n(x.begin() + from, to - from, p.x.begin() + kept);
    std::copy_n(y.begin() + from, to - from, p.y.begin() + kept);
    for (const std::span<double> column : {p.vx, p.vy, p.energy})
      if (kept != begin + from)
        std::copy_n(column.begin() + begin + from, to - from, column.begin() + kept);
    kept += to - from;
    from = to + 1;
  }
  return kept;
}

}  // namespace somas::environments
