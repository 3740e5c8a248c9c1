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

/// Uniform numbers, three for each particle: its place on the circle, and where it is headed for.
struct ParticleAggression::Draws {
  static constexpr std::uint32_t most = 128;
  std::uint32_t count = 0;
  std::array<double, most> turn, u, v;

  /// Those of the particles from number `first` on.
  void draw(const Rng& rng, std::uint64_t first) {
    for (std::uint32_t d = 0; d < count; ++d) {
      Rng own = rng.of(first + d);
      turn[d] = own.uniform();
      u[d] = own.uniform();
      v[d] = own.uniform();
    }
  }
};

namespace {

constexpr double most_particles = 1e7;
constexpr std::size_t block_size = 4096;
/// Of a round: few enough that their particles are still in a cache when the hits are known, enough
/// to be worth handing over.
constexpr std::size_t blocks_per_thread = 8;
/// Cells that are worth a thread that looks for their bounds.
constexpr std::uint32_t many_cells = 20000;
/// Particles that are worth a thread that launches them.
constexpr std::uint32_t many_launched = 500;
/// So many move to others' places that their columns are worth threads.
constexpr std::size_t many_fills = 2000;
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

inline bool all_miss(const std::int32_t* eight_hits) {
  const auto pair = [&](std::size_t i) {
    std::uint64_t both;
    std::memcpy(&both, eight_hits + 2 * i, sizeof both);
    return both;
  };
  constexpr std::uint64_t negative = 0x8000000080000000;
  return (pair(0) & pair(1) & pair(2) & pair(3) & negative) == negative;
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

/// Where the part-th of `parts` parts of so many items begins.
inline std::size_t bound(std::size_t count, std::size_t part, std::size_t parts) {
  return count * part / parts;
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
  const auto first_number = static_cast<std::uint64_t>(serial);
  const std::uint32_t launched = table.rows() - old_rows;
  serial += launched;
  const Rng rng = world.rng(purpose_, first_number);
  const Particles p(table);
  share_work(world, launched, many_launched, [&](std::uint32_t begin, std::uint32_t end) {
    Draws draws;
    for (; begin < end; begin += draws.count) {
      draws.count = std::min(Draws::most, end - begin);
      draws.draw(rng, first_number + begin);
      launch(p, old_rows + begin, draws);
    }
  });
}

/// Puts particles from `i` on onto the circle at even angles, headed for points near the centre.
void ParticleAggression::launch(const Particles& p, std::size_t i, const Draws& draws) const {
  const double radius = spawn_radius_, spread = parameters_.aim_spread, speed = parameters_.speed;
  std::fill_n(&p.energy[i], draws.count, parameters_.energy);
  double *x = &p.x[i], *y = &p.y[i], *vx = &p.vx[i], *vy = &p.vy[i];
  // Branches on nothing: in lanes.
  for (std::uint32_t d = 0; d < draws.count; ++d) {
    const math::SinCos angle = math::sincos(math::two_pi * draws.turn[d]);
    const auto [aim_x, aim_y] = Rng::normals_of(draws.u[d], draws.v[d]);
    x[d] = radius * angle.cos;
    y[d] = radius * angle.sin;
    const double dx = spread * aim_x - x[d], dy = spread * aim_y - y[d];
    const double distance = std::sqrt(dx * dx + dy * dy);
    // Aimed at where it stands: no direction, so take the centre's.
    const bool aimless = distance == 0;
    const double way = aimless ? radius : distance;
    vx[d] = speed * ((aimless ? -x[d] : dx) / way);
    vy[d] = speed * ((aimless ? -y[d] : dy) / way);
  }
}

/// A rectangle that holds cells; empty, and so far from everything, when there are none.
struct alignas(64) ParticleAggression::Box {
  double left = nowhere, right = -nowhere, bottom = nowhere, top = -nowhere;

  void hold(const Box& other) {
    left = std::min(left, other.left);
    right = std::max(right, other.right);
    bottom = std::min(bottom, other.bottom);
    top = std::max(top, other.top);
  }
  void hold(const Cells& cells, std::size_t begin, std::size_t end);
};

void ParticleAggression::Box::hold(const Cells& cells, std::size_t begin, std::size_t end) {
  Four low_x = Four{} + left, high_x = Four{} + right;
  Four low_y = Four{} + bottom, high_y = Four{} + top;
  const auto widen = [&](const Four& x, const Four& y, const Four& radius) {
    const Four x0 = x - radius, x1 = x + radius, y0 = y - radius, y1 = y + radius;
    low_x = x0 < low_x ? x0 : low_x;
    high_x = x1 > high_x ? x1 : high_x;
    low_y = y0 < low_y ? y0 : low_y;
    high_y = y1 > high_y ? y1 : high_y;
  };
  std::size_t i = begin;
  for (; i + 4 <= end; i += 4) {
    Four x, y, radius;
    std::memcpy(&x, &cells.x[i], sizeof x);
    std::memcpy(&y, &cells.y[i], sizeof y);
    std::memcpy(&radius, &cells.radius[i], sizeof radius);
    widen(x, y, radius);
  }
  for (; i < end; ++i) widen(Four{} + cells.x[i], Four{} + cells.y[i], Four{} + cells.radius[i]);
  for (int lane = 0; lane < 4; ++lane) hold({low_x[lane], high_x[lane], low_y[lane], high_y[lane]});
}

/// Particles that fly side by side.
struct alignas(64) ParticleAggression::Block {
  std::size_t begin = 0, count = 0;
  /// Where those that may meet a cell on the way stand in the lists of the round.
  std::size_t near_begin = 0, near_count = 0;
};

/// Scratch memory, too large for a stack.
struct ParticleAggression::Round {
  std::vector<Box> boxes;  ///< by part
  std::vector<Block> blocks;
  // Of the particles that may meet a cell on the way: which of its block, its path, who is hit.
  // Those of blocks that one thread moves follow each other.
  std::vector<std::uint32_t> near;
  std::vector<Segment> paths;
  std::vector<std::int32_t> hits;
  /// A bit for each particle, of this round or an earlier one: past the far side, or spent.
  std::vector<std::uint64_t> leaves;
  /// Particles that move, one by one, to the places of others.
  struct Fill {
    std::uint32_t to, from;
  };
  std::vector<Fill> fills;

  [[nodiscard]] bool is_leaving(std::size_t i) const { return (leaves[i / 64] >> i % 64 & 1) != 0; }
  void leave(std::size_t i) { leaves[i / 64] |= std::uint64_t{1} << i % 64; }

  /// The blocks that come next, at most so many, from the particle `begin` on; returns their end.
  std::size_t line_up(std::size_t begin, std::size_t rows, std::size_t most_blocks) {
    blocks.resize(std::min(most_blocks, (rows - begin + block_size - 1) / block_size));
    for (Block& block : blocks) {
      block.begin = begin;
      block.count = std::min(block_size, rows - begin);
      begin += block.count;
    }
    const std::size_t room = std::max(near.size(), blocks.size() * block_size);
    near.resize(room);
    paths.resize(room);
    hits.resize(room);
    return begin;
  }
};

void ParticleAggression::act(Phase, World& world) const {
  if (world.step() < static_cast<std::uint64_t>(parameters_.start)) return;
  emit(world);
  // Handed on: to the threads that help, the name would mean one of their own.
  static thread_local Round round;
  fly(world, round);
}

ParticleAggression::Box ParticleAggression::bounds_of(World& world, Round& round) {
  const Cells& cells = world.cells();
  const std::uint32_t parts = std::clamp(cells.count / many_cells, 1u, threads_of(world));
  round.boxes.resize(parts);
  share_work(world, parts, 1, [&](std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t part = first; part < end; ++part) {
      round.boxes[part] = {};
      round.boxes[part].hold(cells, bound(cells.count, part, parts),
                             bound(cells.count, part + 1, parts));
    }
  });
  Box all;
  for (const Box& some : round.boxes) all.hold(some);
  return all;
}

/// Round by round, so that particles are still in a cache when their hits are known.
void ParticleAggression::fly(World& world, Round& round) const {
  Table& table = world.table(particles_);
  const Particles p(table);
  const Box inhabited = bounds_of(world, round);
  const std::size_t rows = table.rows();
  const std::uint32_t threads = threads_of(world);
  round.leaves.resize((rows + 63) / 64);
  for (std::size_t begin = 0; begin < rows;) {
    begin = round.line_up(begin, rows, threads == 1 ? 1 : blocks_per_thread * threads);
    const auto parts = std::min(static_cast<std::uint32_t>(round.blocks.size()), threads);
    share_work(world, parts, 1, [&](std::uint32_t first, std::uint32_t end) {
      for (std::uint32_t part = first; part < end; ++part)
        advance(p, inhabited, round, part, parts);
    });
    find_hits(world, round);
    for (const Block& block : round.blocks) strike(world, p, round, block);
  }
  table.resize(fill_gaps(world, p, round));
}

/// Moves a part of the blocks.
void ParticleAggression::advance(const Particles& p, const Box& inhabited, Round& round,
                                 std::uint32_t part, std::uint32_t parts) const {
  const std::size_t count = round.blocks.size(), first = bound(count, part, parts);
  std::size_t near_begin = first * block_size;
  for (std::size_t b = first; b < bound(count, part + 1, parts); ++b) {
    Block& block = round.blocks[b];
    block.near_begin = near_begin;
    advance(p, inhabited, block, &round.near[near_begin], &round.paths[near_begin],
            &round.leaves[block.begin / 64]);
    near_begin += block.near_count;
  }
}

/// The particles of the block move; who is past the far side leaves; the paths of those that come
/// near the cells are listed: most are too far off to meet any.
void ParticleAggression::advance(const Particles& p, const Box& inhabited, Block& block,
                                 std::uint32_t* nears, Segment* near_paths,
                                 std::uint64_t* all_leave) const {
  const Four limit = Four{} + spawn_radius_ * spawn_radius_;
  const Four left = Four{} + inhabited.left, right = Four{} + inhabited.right;
  const Four bottom = Four{} + inhabited.bottom, top = Four{} + inhabited.top;
  double *xs = &p.x[block.begin], *ys = &p.y[block.begin];
  const double *vxs = &p.vx[block.begin], *vys = &p.vy[block.begin];
  std::uint64_t leaves = 0;
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
    leaves |= std::uint64_t{bits_of(beyond & outwards)} << (k % 64);
    const FourMask across = ((x0 >= left) | (x >= left)) & ((x0 <= right) | (x <= right));
    const FourMask up = ((y0 >= bottom) | (y >= bottom)) & ((y0 <= top) | (y <= top));
    const std::uint32_t near = bits_of(across & up);
    Four rows[4];
    transpose({x0, y0, x, y}, rows);
    static_assert(sizeof(Segment) == sizeof(Four));
    // All are written down; the next one takes the place of who is far off.
    const auto pick = [&](std::size_t lane) __attribute__((always_inline)) {
      nears[near_count] = static_cast<std::uint32_t>(k + lane);
      std::memcpy(&near_paths[near_count], &rows[lane], sizeof(Segment));
      near_count += (near >> lane) & 1;
    };
    pick(0);
    if constexpr (some == 4) pick(1), pick(2), pick(3);
  };
  const std::size_t count = block.count;
  for (std::size_t k = 0; k < count; leaves = 0) {
    const std::size_t word = k / 64, end = std::min(k + 64, count);
    for (; k + 4 <= end; k += 4) move(k, std::integral_constant<std::size_t, 4>());
    for (; k < end; ++k) move(k, std::integral_constant<std::size_t, 1>());
    all_leave[word] = leaves;
  }
  block.near_count = near_count;
}

/// Asks for as many hits at a time as follow each other.
void ParticleAggression::find_hits(World& world, Round& round) {
  for (std::size_t b = 0; b < round.blocks.size();) {
    const std::size_t begin = round.blocks[b].near_begin;
    std::size_t count = 0;
    for (; b < round.blocks.size() && round.blocks[b].near_begin == begin + count; ++b)
      count += round.blocks[b].near_count;
    if (count == 0) continue;
    world.first_hit(std::span(round.paths).subspan(begin, count),
                    std::span(round.hits).subspan(begin, count));
  }
}

/// Those that meet a cell are spent on it.
void ParticleAggression::strike(World& world, const Particles& p, Round& round,
                                const Block& block) const {
  const std::size_t end = block.near_begin + block.near_count;
  for (std::size_t n = block.near_begin; n < end; ++n) {
    // Few meet one.
    while (n + 8 <= end && all_miss(&round.hits[n])) n += 8;
    if (n == end) return;
    if (round.hits[n] < 0) continue;
    const std::size_t i = block.begin + round.near[n];
    round.leave(i);
    world.strike(static_cast<std::uint32_t>(round.hits[n]), hazard_, p.energy[i]);
  }
}

/// The last ones take the places of those that leave, the lowest place first; returns how many
/// there are then. Few leave in a step: nobody else moves.
std::uint32_t ParticleAggression::fill_gaps(World& world, const Particles& p, Round& round) {
  std::size_t kept = p.x.size();
  const auto drop_last = [&](std::size_t from) {
    while (kept > from && round.is_leaving(kept - 1)) --kept;
  };
  drop_last(0);
  round.fills.clear();
  for (std::size_t word = 0; 64 * word < kept; ++word)
    for (std::uint64_t set = round.leaves[word]; set != 0; set &= set - 1) {
      const std::size_t to = 64 * word + static_cast<std::size_t>(std::countr_zero(set));
      if (to >= kept) break;
      round.fills.push_back({static_cast<std::uint32_t>(to), static_cast<std::uint32_t>(--kept)});
      drop_last(to + 1);
    }

  const std::array<std::span<double>, 5> columns{p.x, p.y, p.vx, p.vy, p.energy};
  const auto fill_some = [&](std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t c = first; c < end; ++c)
      for (const auto [to, from] : round.fills) columns[c][to] = columns[c][from];
  };
  const std::uint32_t least = round.fills.size() < many_fills ? columns.size() : 1;
  share_work(world, columns.size(), least, fill_some);
  return static_cast<std::uint32_t>(kept);
}

}  // namespace somas::environments
