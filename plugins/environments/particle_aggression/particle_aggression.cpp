#include "plugins/environments/particle_aggression/particle_aggression.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "somas/sdk/math.hpp"
#include "somas/sdk/workers.hpp"

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
/// Enough for threads that are not equally fast.
constexpr std::size_t blocks_per_thread = 8;
constexpr double nowhere = std::numeric_limits<double>::infinity();
constexpr std::string_view column_names[] = {"x", "y", "vx", "vy", "energy"};

// Four particles side by side, in one register where there is one so wide.
using Four = double __attribute__((vector_size(32)));
using FourMask = std::int64_t __attribute__((vector_size(32)));

/// The lanes of a mask as bits.
inline std::uint32_t bits_of(const FourMask& mask) {
#ifdef __AVX__
  Four lanes;
  std::memcpy(&lanes, &mask, sizeof lanes);
  return static_cast<std::uint32_t>(__builtin_ia32_movmskpd256(lanes));
#else
  return static_cast<std::uint32_t>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

/// Four rows from four columns.
inline void transpose(const Four (&column)[4], Four (&row)[4]) {
  const Four even01 = __builtin_shufflevector(column[0], column[1], 0, 4, 2, 6);
  const Four odd01 = __builtin_shufflevector(column[0], column[1], 1, 5, 3, 7);
  const Four even23 = __builtin_shufflevector(column[2], column[3], 0, 4, 2, 6);
  const Four odd23 = __builtin_shufflevector(column[2], column[3], 1, 5, 3, 7);
  row[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  row[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  row[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  row[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
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
    Four low_x = Four{} + left, high_x = Four{} + right;
    Four low_y = Four{} + bottom, high_y = Four{} + top;
    const auto hold = [&](const Four& x, const Four& y, const Four& radius) {
      const Four x0 = x - radius, x1 = x + radius, y0 = y - radius, y1 = y + radius;
      low_x = x0 < low_x ? x0 : low_x;
      high_x = x1 > high_x ? x1 : high_x;
      low_y = y0 < low_y ? y0 : low_y;
      high_y = y1 > high_y ? y1 : high_y;
    };
    std::uint32_t i = 0;
    for (; i + 4 <= cells.count; i += 4) {
      Four x, y, radius;
      std::memcpy(&x, &cells.x[i], sizeof x);
      std::memcpy(&y, &cells.y[i], sizeof y);
      std::memcpy(&radius, &cells.radius[i], sizeof radius);
      hold(x, y, radius);
    }
    for (; i < cells.count; ++i)
      hold(Four{} + cells.x[i], Four{} + cells.y[i], Four{} + cells.radius[i]);
    for (int lane = 0; lane < 4; ++lane) {
      left = std::min(left, low_x[lane]);
      right = std::max(right, high_x[lane]);
      bottom = std::min(bottom, low_y[lane]);
      top = std::max(top, high_y[lane]);
    }
  }
  double left = nowhere, right = -nowhere, bottom = nowhere, top = -nowhere;
};

/// Particles that fly side by side.
struct ParticleAggression::Block {
  std::size_t begin = 0, count = 0;
  /// A bit for each: past the far side, or spent.
  std::array<std::uint64_t, most_paths / 64> leaves;
  // Of those that may meet a cell on the way, with room for four more: which particle, its path,
  // who is hit.
  std::array<std::uint32_t, most_paths + 4> near;
  std::array<Segment, most_paths + 4> paths;
  std::array<std::int32_t, most_paths> hits;
  std::size_t near_count = 0;
};

void ParticleAggression::fly(World& world) const {
  Table& table = world.table(particles_);
  const Particles p(table);
  const Box inhabited(world.cells());
  const std::size_t rows = table.rows(), threads = threads_of(world);
  // As many blocks at a time as keep the threads busy, so that their particles are still in a cache
  // when the hits are known.
  const std::size_t most_blocks = threads == 1 ? 1 : blocks_per_thread * threads;
  static thread_local std::vector<Block> blocks;  // too large for a stack
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < rows;) {
    std::size_t count = 0;
    for (; count < most_blocks && begin < rows; begin += blocks[count++].count) {
      if (blocks.size() == count) blocks.emplace_back();
      blocks[count].begin = begin;
      blocks[count].count = std::min(most_paths, rows - begin);
    }
    const std::span<Block> round = std::span(blocks).first(count);
    share_work(world, static_cast<std::uint32_t>(count), 1,
               [&](std::uint32_t first, std::uint32_t end) {
                 for (std::uint32_t b = first; b < end; ++b) advance(p, inhabited, round[b]);
               });
    for (Block& block : round) strike(world, p, block);
    kept = close_ranks(world, p, round, kept);
  }
  table.resize(static_cast<std::uint32_t>(kept));
}

/// The particles of the block move; who is past the far side leaves; the paths of those that come
/// near the cells are listed: most are too far off to meet any.
void ParticleAggression::advance(const Particles& p, const Box& inhabited, Block& block) const {
  const Four limit = Four{} + spawn_radius_ * spawn_radius_;
  const Four left = Four{} + inhabited.left, right = Four{} + inhabited.right;
  const Four bottom = Four{} + inhabited.bottom, top = Four{} + inhabited.top;
  double *xs = &p.x[block.begin], *ys = &p.y[block.begin];
  const double *vxs = &p.vx[block.begin], *vys = &p.vy[block.begin];
  const std::size_t count = block.count;
  std::size_t near_count = 0;
  // From place k on, as many as are asked for of four lanes; those in others stand still.
  const auto move = [&](std::size_t k, auto some) __attribute__((always_inline)) {
    constexpr std::size_t bytes = some * sizeof(double);
    Four x0{}, y0{}, vx{}, vy{};
    std::memcpy(&x0, xs + k, bytes);
    std::memcpy(&y0, ys + k, bytes);
    std::memcpy(&vx, vxs + k, bytes);
    std::memcpy(&vy, vys + k, bytes);
    const Four x = x0 + vx, y = y0 + vy;
    std::memcpy(xs + k, &x, bytes);
    std::memcpy(ys + k, &y, bytes);
    const FourMask beyond = x * x + y * y > limit, outwards = x * vx + y * vy > 0;
    block.leaves[k / 64] |= std::uint64_t{bits_of(beyond & outwards)} << (k % 64);
    const Four low_x = x < x0 ? x : x0, high_x = x < x0 ? x0 : x;
    const Four low_y = y < y0 ? y : y0, high_y = y < y0 ? y0 : y;
    const FourMask across = (high_x >= left) & (low_x <= right);
    const FourMask up = (high_y >= bottom) & (low_y <= top);
    const std::uint32_t near = bits_of(across & up);
    if (near == 0) return;
    // All are written down; the next one takes the place of who is far off.
    Four paths[4];
    transpose({x0, y0, x, y}, paths);
    static_assert(sizeof(Segment) == sizeof(Four));
    const auto list = [&](std::size_t lane) __attribute__((always_inline)) {
      block.near[near_count] = static_cast<std::uint32_t>(k + lane);
      std::memcpy(&block.paths[near_count], &paths[lane], sizeof(Segment));
      near_count += (near >> lane) & 1;
    };
    list(0);
    if constexpr (some == 4) list(1), list(2), list(3);
  };
  block.leaves.fill(0);
  std::size_t k = 0;
  for (; k + 4 <= count; k += 4) move(k, std::integral_constant<std::size_t, 4>());
  for (; k < count; ++k) move(k, std::integral_constant<std::size_t, 1>());
  block.near_count = near_count;
}

/// Those that meet a cell are spent on it.
void ParticleAggression::strike(World& world, const Particles& p, Block& block) const {
  if (block.near_count == 0) return;
  world.first_hit(std::span(block.paths).first(block.near_count),
                  std::span(block.hits).first(block.near_count));
  for (std::size_t n = 0; n < block.near_count; ++n) {
    if (block.hits[n] < 0) continue;
    const std::uint32_t k = block.near[n];
    block.leaves[k / 64] |= std::uint64_t{1} << (k % 64);
    world.strike(static_cast<std::uint32_t>(block.hits[n]), hazard_, p.energy[block.begin + k]);
  }
}

/// Who does not leave closes the ranks behind the `kept` ones, in order. Returns how many are.
std::size_t ParticleAggression::close_ranks(World& world, const Particles& p,
                                            std::span<const Block> blocks, std::size_t kept) {
  // The energy is everybody's: that column may stay.
  const std::array<std::span<double>, 4> columns{p.x, p.y, p.vx, p.vy};
  const std::uint32_t least = blocks.size() == 1 ? 4 : 1;
  share_work(world, 4, least, [&](std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t c = first; c < end; ++c) close_ranks(columns[c], blocks, kept);
  });
  for (const Block& block : blocks) {
    kept += block.count;
    for (const std::uint64_t leaves : block.leaves)
      kept -= static_cast<std::size_t>(std::popcount(leaves));
  }
  return kept;
}

void ParticleAggression::close_ranks(std::span<double> column, std::span<const Block> blocks,
                                     std::size_t kept) {
  const auto move_up = [&](std::size_t from, std::size_t to) {
    if (kept != from) std::copy(column.begin() + from, column.begin() + to, column.begin() + kept);
    kept += to - from;
  };
  std::size_t from = blocks.front().begin;
  for (const Block& block : blocks) {
    for (std::size_t word = 0; 64 * word < block.count; ++word)
      for (std::uint64_t set = block.leaves[word]; set != 0; set &= set - 1) {
        const std::size_t leaving =
            block.begin + 64 * word + static_cast<std::size_t>(std::countr_zero(set));
        move_up(from, leaving);
        from = leaving + 1;
      }
  }
  move_up(from, blocks.back().begin + blocks.back().count);
}

}  // namespace somas::environments
