// Section 3 of the model, against closed forms and an all-pairs reference in double.
#include "core/model/mechanics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/model/team.hpp"
#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

// ---- the reference ------------------------------------------------------------------------------

struct Disc {
  double x = 0, y = 0, vx = 0, vy = 0;
  double mass = 1, radius = 1, stiffness = 10, adhesion = 3, range = 1.2;
  int organism = 0;
};

struct Sums {
  double fx = 0, fy = 0, push = 0, xx = 0, xy = 0, yy = 0;
  std::vector<std::size_t> contacts;
};

/// Forces on disc i as section 3 words them.
Sums sums_on(const std::vector<Disc>& discs, std::size_t i, double damping, double drag) {
  Sums sums;
  const Disc& a = discs[i];
  sums.fx = -drag * a.vx;
  sums.fy = -drag * a.vy;
  for (std::size_t j = 0; j < discs.size(); ++j) {
    if (j == i) continue;
    const Disc& b = discs[j];
    const double distance = std::hypot(a.x - b.x, a.y - b.y);
    const double nx = (a.x - b.x) / distance, ny = (a.y - b.y) / distance;
    const bool overlapping = distance < a.radius + b.radius;
    const bool adhering =
        a.organism == b.organism && distance < (a.range + b.range) / 2 * (a.radius + b.radius);
    double force = 0;
    if (overlapping) {
      const double push = (a.stiffness + b.stiffness) / 2 * (a.radius + b.radius - distance);
      force += push;
      sums.push += push;
      sums.xx += push * nx * nx;
      sums.xy += push * nx * ny;
      sums.yy += push * ny * ny;
    }
    if (adhering) {
      force -= (a.adhesion + b.adhesion) / 2 * (distance - (a.radius + b.radius) / 2);
      sums.contacts.push_back(j);
    }
    if (overlapping || adhering) force -= damping * ((a.vx - b.vx) * nx + (a.vy - b.vy) * ny);
    sums.fx += force * nx;
    sums.fy += force * ny;
  }
  return sums;
}

void substep(std::vector<Disc>& discs, const Mechanics& m) {
  std::vector<Sums> sums;
  for (std::size_t i = 0; i < discs.size(); ++i)
    sums.push_back(sums_on(discs, i, m.damping, m.drag));
  for (std::size_t i = 0; i < discs.size(); ++i) {
    discs[i].vx += m.time_step * sums[i].fx / discs[i].mass;
    discs[i].vy += m.time_step * sums[i].fy / discs[i].mass;
    discs[i].x += m.time_step * discs[i].vx;
    discs[i].y += m.time_step * discs[i].vy;
  }
}

// ---- helpers ------------------------------------------------------------------------------------

/// A bench whose cells live for nothing; ids count from 0 in the order given.
class MechanicsBench : public Bench {
 public:
  MechanicsBench() { free_living(); }

  void put(const std::vector<Placed>& cells) {
    std::vector<Placed> numbered = cells;
    for (std::size_t i = 0; i < numbered.size(); ++i) numbered[i].id = i;
    start_with(numbered);
  }
  /// One very short substep, to read off forces as mass x velocity change / h.
  void probe() {
    config.mechanics.substeps = 1;
    config.mechanics.time_step = 1e-6;
  }
  [[nodiscard]] double force_x(std::uint64_t id, double mass = 1) {
    return cells().vx[at(id)] * mass / 1e-6;
  }
  [[nodiscard]] double distance(std::uint64_t a, std::uint64_t b) {
    const CellStore& c = cells();
    return std::hypot(c.x[at(a)] - c.x[at(b)], c.y[at(a)] - c.y[at(b)]);
  }
  [[nodiscard]] Disc disc(std::uint64_t id) {
    const CellStore& c = cells();
    const std::uint32_t i = at(id);
    const StateDef& s = states[c.state[i]];
    return {c.x[i],      c.y[i],      c.vx[i],    c.vy[i],         s.mass,
            c.radius[i], s.stiffness, s.adhesion, s.adhesion_range};
  }
  [[nodiscard]] std::vector<Disc> discs() {
    std::vector<Disc> all;
    for (std::uint64_t id = 0; id < cells().size(); ++id) all.push_back(disc(id));
    return all;
  }
};

/// A few kinds of cells that differ in everything.
std::vector<StateDef> mixed_states() {
  return {{.name = "a"},
          {.name = "b",
           .parent = 0,
           .mass = 1.7,
           .radius = 0.8,
           .stiffness = 6,
           .adhesion = 5,
           .adhesion_range = 1.05},
          {.name = "c",
           .parent = 0,
           .mass = 2.5,
           .radius = 1.3,
           .stiffness = 14,
           .adhesion = 0.5,
           .adhesion_range = 1.5}};
}

std::vector<Placed> random_cluster(std::size_t count, double radius, std::size_t states,
                                   double speed, Dice& dice) {
  std::vector<Placed> cells;
  for (std::size_t i = 0; i < count; ++i)
    cells.push_back({.id = i,
                     .x = dice.uniform(-radius, radius),
                     .y = dice.uniform(-radius, radius),
                     .vx = dice.uniform(-speed, speed),
                     .vy = dice.uniform(-speed, speed),
                     .state = static_cast<std::uint16_t>(dice.below(states))});
  return cells;
}

/// A hexagonal lattice round the origin, nearest points first.
std::vector<Placed> lattice(std::size_t count, double spacing, double jitter, Dice& dice) {
  std::vector<std::array<double, 2>> points;
  for (int row = -12; row <= 12; ++row)
    for (int column = -12; column <= 12; ++column)
      points.push_back(
          {spacing * (column + 0.5 * (row & 1)), spacing * row * std::numbers::sqrt3 / 2});
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::hypot(a[0], a[1]) < std::hypot(b[0], b[1]);
  });
  std::vector<Placed> cells;
  for (std::size_t i = 0; i < count; ++i)
    cells.push_back({.id = i,
                     .x = points[i][0] + dice.uniform(-jitter, jitter),
                     .y = points[i][1] + dice.uniform(-jitter, jitter)});
  return cells;
}

// ---- springs ------------------------------------------------------------------------------------

TEST(Springs, TwoCellsRestWhereBothSpringsBalance) {
  struct Case {
    double stiffness, adhesion, radius, rest;
  };
  // [k_c (r1 + r2) + k_a (r1 + r2) / 2] / (k_c + k_a)
  for (const Case& c : {Case{10, 3, 1, 23.0 / 13}, Case{8, 8, 1, 1.5}, Case{9, 1, 0.5, 0.95}}) {
    for (const double start : {0.6, 1.05}) {
      MechanicsBench bench;
      bench.states[0].stiffness = c.stiffness;
      bench.states[0].adhesion = c.adhesion;
      bench.states[0].radius = c.radius;
      bench.put({{.x = 0, .y = 0}, {.x = start * c.rest * 0.6, .y = start * c.rest * 0.8}});
      bench.steps(400);
      EXPECT_NEAR(bench.distance(0, 1), c.rest, 1e-9);
    }
  }
  EXPECT_NEAR(23.0 / 13, 1.769, 5e-4);
}

TEST(Springs, TwoUnequalCellsRestByTheirMeans) {
  MechanicsBench bench;
  bench.states = mixed_states();
  bench.put({{.x = 0, .state = 1}, {.x = 1.8, .state = 2}});
  bench.steps(600);
  const double radii = 0.8 + 1.3, stiffness = 10, adhesion = 2.75;
  EXPECT_NEAR(bench.distance(0, 1),
              (stiffness * radii + adhesion * radii / 2) / (stiffness + adhesion), 1e-9);
}

TEST(Springs, RestDistanceIsWhereTheForceVanishes) {
  State state;
  state.stiffness = 10, state.adhesion = 3, state.radius = 1;
  EXPECT_NEAR(rest_distance(state), 23.0 / 13, 1e-15);
  state.adhesion = 10, state.radius = 2;
  EXPECT_NEAR(rest_distance(state), 3.0, 1e-15);
  state.stiffness = 0;
  EXPECT_NEAR(rest_distance(state), 2.0, 1e-15);
  state.stiffness = 5, state.adhesion = 0;
  EXPECT_NEAR(rest_distance(state), 4.0, 1e-15);
}

/// Displacement of a damped oscillator released at rest from u0.
double oscillation(double u0, double omega0, double zeta, double t) {
  if (zeta < 1) {
    const double omega = omega0 * std::sqrt(1 - zeta * zeta);
    return u0 * std::exp(-zeta * omega0 * t) *
           (std::cos(omega * t) + zeta * omega0 / omega * std::sin(omega * t));
  }
  const double root = omega0 * std::sqrt(zeta * zeta - 1);
  const double slow = -zeta * omega0 + root, fast = -zeta * omega0 - root;
  return u0 * (slow * std::exp(fast * t) - fast * std::exp(slow * t)) / (slow - fast);
}

TEST(Springs, PairSwingsAsADampedOscillator) {
  struct Case {
    double damping, mass1, mass2;
  };
  for (const Case& c : {Case{0, 1, 1}, Case{3, 1, 1}, Case{1, 1, 3}, Case{8, 2, 1}}) {
    MechanicsBench bench;
    bench.states = {{.name = "a", .mass = c.mass1}, {.name = "b", .parent = 0, .mass = c.mass2}};
    bench.config.mechanics = {.substeps = 500, .time_step = 2e-5, .damping = c.damping, .drag = 0};
    const double rest = 23.0 / 13, u0 = -0.1;
    bench.put({{.x = 0}, {.x = rest + u0, .state = 1}});
    const double mu = c.mass1 * c.mass2 / (c.mass1 + c.mass2), k = 13;
    const double omega0 = std::sqrt(k / mu), zeta = c.damping / (2 * std::sqrt(k * mu));
    double greatest = 0;
    for (int step = 1; step <= 200; ++step) {
      bench.steps(1);
      const double t = step * 500 * 2e-5;
      const double expected = oscillation(u0, omega0, zeta, t);
      ASSERT_NEAR(bench.distance(0, 1) - rest, expected, 2e-5) << "damping " << c.damping;
      greatest = std::max(greatest, std::abs(expected));
    }
    EXPECT_GT(greatest, 0.05);
  }
}

TEST(Springs, CollisionSpringIsGoneBeyondBothRadii) {
  for (const double distance : {1.5, 1.99, 2.01, 2.3}) {
    MechanicsBench bench;
    bench.states[0].adhesion = 0;
    bench.probe();
    bench.put({{.x = 0}, {.x = distance}});
    bench.steps(1);
    const double push = distance < 2 ? 10 * (2 - distance) : 0.0;
    EXPECT_NEAR(bench.force_x(1), push, 1e-6) << distance;
    EXPECT_NEAR(bench.force_x(0), -push, 1e-6) << distance;
  }
}

TEST(Springs, AdhesionPullsUpToTheMeanActivationDistance) {
  // Factors 1.2 and 1.6, radii 1 and 0.5: threshold 1.4 x 1.5 = 2.1; strengths 3 and 7.
  for (const double distance : {1.6, 2.0999, 2.1001, 2.3}) {
    MechanicsBench bench;
    bench.states = {
        {.name = "a"},
        {.name = "b", .parent = 0, .radius = 0.5, .adhesion = 7, .adhesion_range = 1.6}};
    bench.probe();
    bench.put({{.x = 0}, {.x = distance, .state = 1}});
    bench.steps(1);
    const double pull = distance < 2.1 ? 5 * (distance - 0.75) : 0.0;
    EXPECT_NEAR(bench.force_x(1), -pull, 1e-5) << distance;
    EXPECT_EQ(bench.world().contacts.of(bench.at(0)).size(), distance < 2.1 ? 1u : 0u);
  }
}

TEST(Springs, UseCurrentRadiiNotThoseOfTheState) {
  MechanicsBench bench;
  bench.probe();
  bench.put({{.x = 0}, {.x = 2.5}});
  bench.cells().radius[bench.at(1)] = 1.3;  // as when it divides: threshold 1.2 x 2.3 = 2.76
  bench.steps(1);
  EXPECT_NEAR(bench.force_x(1), -3 * (2.5 - 1.15), 1e-5);

  bench.put({{.x = 0}, {.x = 2.2}});
  bench.cells().radius[bench.at(0)] = 1.4;  // now they overlap by 0.2
  bench.steps(1);
  EXPECT_NEAR(bench.force_x(1), 10 * 0.2 - 3 * (2.2 - 1.2), 1e-5);
}

TEST(Springs, AdhesionKeepsNoMemoryOfEarlierContact) {
  MechanicsBench bench;
  bench.probe();
  bench.put({{.x = 0}, {.x = 2.3}});
  bench.steps(1);
  EXPECT_NEAR(bench.force_x(1), -3 * 1.3, 1e-5);
  for (const double distance : {2.45, 2.3}) {
    CellStore& c = bench.cells();
    c.x[bench.at(0)] = 0, c.x[bench.at(1)] = distance;
    c.vx[bench.at(0)] = c.vx[bench.at(1)] = 0;
    bench.steps(1);
    EXPECT_NEAR(bench.force_x(1), distance < 2.4 ? -3 * 1.3 : 0.0, 1e-5) << distance;
    EXPECT_EQ(bench.world().contacts.of(bench.at(1)).size(), distance < 2.4 ? 1u : 0u);
  }
}

TEST(Springs, ForeignOrganismsCollide) {
  MechanicsBench bench;
  bench.founders = {{.key = 1}, {.key = 2}};
  bench.probe();
  bench.start_with({{.id = 0, .x = 0, .organism = 0}, {.id = 0, .x = 1.9, .organism = 1}});
  bench.steps(1);
  const CellStore& c = bench.cells();
  EXPECT_GT(c.vx[bench.at(0, 1)], 0) << "pushed apart";
  EXPECT_EQ(c.vx[bench.at(0, 0)], -c.vx[bench.at(0, 1)]);
  EXPECT_GT(c.pressure[bench.at(0, 0)], 0);
}

// ---- dampers and drag ---------------------------------------------------------------------------

TEST(Damping, ActsOnlyWhileASpringActs) {
  for (const double distance : {1.8, 2.3, 2.45}) {
    MechanicsBench bench;
    bench.probe();
    bench.config.mechanics.drag = 0;
    bench.put({{.x = 0, .vx = 0.5}, {.x = distance, .vx = -0.25}});
    bench.steps(1);
    double force = 0;  // on the first cell, whose normal points to -x
    if (distance < 2) force -= 10 * (2 - distance);
    if (distance < 2.4) force += 3 * (distance - 1) - 3 * 0.75;
    EXPECT_NEAR((bench.cells().vx[bench.at(0)] - 0.5) / 1e-6, force, 1e-4) << distance;
  }
}

TEST(Damping, IsAlongTheNormalAndOncePerPair) {
  // Overlapping and adhering at once there are two springs, yet one damper; sliding past is free.
  MechanicsBench bench;
  bench.probe();
  bench.config.mechanics.drag = 0;
  bench.states[0].stiffness = 0;
  bench.states[0].adhesion = 0;
  bench.put({{.x = 0, .vx = 0.5, .vy = 0.7}, {.x = 1.5}});
  bench.steps(1);
  const CellStore& c = bench.cells();
  EXPECT_NEAR((c.vx[bench.at(0)] - 0.5) / 1e-6, -3 * 0.5, 1e-4);
  EXPECT_NEAR(c.vy[bench.at(0)], 0.7, 1e-7 * 0.5);
  EXPECT_NEAR(c.vx[bench.at(1)] / 1e-6, 3 * 0.5, 1e-4);
}

TEST(Damping, DragSlowsALoneCellInProportionToItsSpeed) {
  MechanicsBench bench;
  bench.states[0].mass = 2;
  bench.config.mechanics.drag = 1.5;
  bench.put({{.x = 0, .vx = 0.8, .vy = -0.4}});
  bench.steps(4);
  // Twelve substeps of v <- v (1 - h drag / m).
  const double factor = std::pow(1 - 1.5 / 30 / 2, 12);
  EXPECT_NEAR(bench.cells().vx[0], 0.8 * factor, 1e-14);
  EXPECT_NEAR(bench.cells().vy[0], -0.4 * factor, 1e-14);
}

TEST(Damping, DrainsTheEnergyOfAPairWithoutDrag) {
  // Kinetic plus elastic energy of a pair within both springs falls from substep to substep.
  MechanicsBench bench;
  bench.config.mechanics = {.substeps = 1, .time_step = 1e-4, .damping = 2, .drag = 0};
  bench.put({{.x = 0}, {.x = 1.2}});
  const auto energy = [&] {
    const CellStore& c = bench.cells();
    const double d = bench.distance(0, 1);
    return 0.5 * (c.vx[0] * c.vx[0] + c.vx[1] * c.vx[1]) + 5 * (2 - d) * (2 - d) +
           1.5 * (d - 1) * (d - 1);
  };
  const double start = energy();
  double before = start;
  for (int i = 0; i < 2500; ++i) {
    bench.steps(1);
    ASSERT_LT(energy(), before + 1e-5);
    before = energy();
  }
  EXPECT_LT(before, start - 0.5);
}

// ---- whole clusters -----------------------------------------------------------------------------

TEST(Cluster, EqualsTheAllPairsReferenceStepByStep) {
  Dice dice(1);
  for (int trial = 0; trial < 12; ++trial) {
    MechanicsBench bench;
    bench.states = mixed_states();
    bench.config.mechanics.damping = dice.uniform(0, 3);
    bench.config.mechanics.drag = dice.uniform(0, 1);
    bench.config.mechanics.time_step = 0.01;
    const std::size_t count = 2 + dice.below(40);
    bench.put(random_cluster(count, dice.uniform(2, 8), 3, 0.5, dice));
    std::vector<Disc> discs = bench.discs();
    for (int step = 0; step < 15; ++step) {
      bench.steps(1);
      for (int s = 0; s < 3; ++s) substep(discs, bench.config.mechanics);
      for (std::uint64_t id = 0; id < count; ++id) {
        const Disc disc = bench.disc(id);
        ASSERT_NEAR(disc.x, discs[id].x, 1e-10);
        ASSERT_NEAR(disc.y, discs[id].y, 1e-10);
        ASSERT_NEAR(disc.vx, discs[id].vx, 1e-9);
        ASSERT_NEAR(disc.vy, discs[id].vy, 1e-9);
        const Sums sums = sums_on(discs, id, 3, 1);
        const std::uint32_t i = bench.at(id);
        ASSERT_NEAR(bench.cells().pressure[i], sums.push / (sums.push + 10), 1e-9);
        ASSERT_NEAR(bench.cells().stress_xx[i], sums.xx, 1e-8);
        ASSERT_NEAR(bench.cells().stress_xy[i], sums.xy, 1e-8);
        ASSERT_NEAR(bench.cells().stress_yy[i], sums.yy, 1e-8);
        std::vector<std::size_t> contacts;
        for (const std::uint32_t j : bench.world().contacts.of(i))
          contacts.push_back(bench.cells().id[j]);
        ASSERT_EQ(contacts, sums.contacts) << "in ascending id";
      }
    }
  }
}

TEST(Cluster, SumsAnyNumberOfNeighboursOfAnyOrganism) {
  Dice dice(7);
  for (std::size_t count = 2; count <= 80; count += count < 40 ? 1 : 5) {
    MechanicsBench bench;
    bench.probe();
    bench.states = mixed_states();
    bench.founders = {{.key = 1}, {.key = 2}};
    std::vector<Placed> cells = random_cluster(count, 1.0, 3, 0.5, dice);
    for (Placed& cell : cells)
      cell.organism = static_cast<std::uint16_t>(cell.id < 2 ? cell.id : dice.below(3) / 2);
    bench.start_with(cells);
    std::vector<Disc> discs;
    for (const Placed& p : cells) {
      const StateDef& s = bench.states[p.state];
      discs.push_back({p.x, p.y, p.vx, p.vy, s.mass, s.radius, s.stiffness, s.adhesion,
                       s.adhesion_range, p.organism});
    }
    bench.steps(1);
    for (std::size_t id = 0; id < count; ++id) {
      const Sums sums = sums_on(discs, id, 3, 1);
      const std::uint32_t i = bench.at(id, cells[id].organism);
      const CellStore& c = bench.cells();
      ASSERT_NEAR((c.vx[i] - cells[id].vx) * discs[id].mass / 1e-6, sums.fx, 1e-4) << count;
      ASSERT_NEAR((c.vy[i] - cells[id].vy) * discs[id].mass / 1e-6, sums.fy, 1e-4);
      ASSERT_NEAR(c.pressure[i], sums.push / (sums.push + 10), 1e-4);
      ASSERT_EQ(bench.world().contacts.of(i).size(), sums.contacts.size());
    }
  }
}

TEST(Cluster, ConservesMomentumWithoutDrag) {
  Dice dice(2);
  for (int trial = 0; trial < 5; ++trial) {
    MechanicsBench bench;
    bench.states = mixed_states();
    bench.config.mechanics.drag = 0;
    bench.config.mechanics.time_step = 0.01;
    bench.put(random_cluster(40, 5, 3, 1, dice));
    const auto momentum = [&] {
      std::array<double, 2> sum{};
      for (const Disc& d : bench.discs()) sum[0] += d.mass * d.vx, sum[1] += d.mass * d.vy;
      return sum;
    };
    const auto before = momentum();
    const double some_speed = bench.cells().vx[0];
    bench.steps(60);
    EXPECT_NEAR(momentum()[0], before[0], 1e-11);
    EXPECT_NEAR(momentum()[1], before[1], 1e-11);
    EXPECT_NE(bench.cells().vx[0], some_speed);
  }
}

TEST(Cluster, MovesAlikeWhenTurnedAndShifted) {
  Dice dice(3);
  for (int trial = 0; trial < 4; ++trial) {
    const std::vector<Placed> cells = random_cluster(40, 5, 3, 0.5, dice);
    const double angle = dice.uniform(0, 6.28), sx = dice.uniform(-20, 20),
                 sy = dice.uniform(-20, 20);
    const double c = std::cos(angle), s = std::sin(angle);
    std::vector<Placed> turned = cells;
    for (Placed& p : turned) {
      const Placed q = p;
      p.x = c * q.x - s * q.y + sx, p.y = s * q.x + c * q.y + sy;
      p.vx = c * q.vx - s * q.vy, p.vy = s * q.vx + c * q.vy;
    }
    MechanicsBench first, second;
    for (MechanicsBench* bench : {&first, &second}) {
      bench->states = mixed_states();
      bench->config.mechanics.time_step = 0.01;
    }
    first.put(cells);
    second.put(turned);
    first.steps(20);
    second.steps(20);
    for (std::uint64_t id = 0; id < 40; ++id) {
      const Disc p = first.disc(id), q = second.disc(id);
      EXPECT_NEAR(q.x, c * p.x - s * p.y + sx, 1e-9);
      EXPECT_NEAR(q.y, s * p.x + c * p.y + sy, 1e-9);
      EXPECT_NEAR(first.cells().pressure[first.at(id)], second.cells().pressure[second.at(id)],
                  1e-9);
    }
  }
}

TEST(Cluster, MovesAlikeUnderOtherIds) {
  Dice dice(4);
  const std::size_t count = 50;
  const std::vector<Placed> cells = random_cluster(count, 5, 1, 0.5, dice);
  std::vector<std::size_t> name(count);
  for (std::size_t i = 0; i < count; ++i) name[i] = i;
  dice.shuffle(name);
  std::vector<Placed> renamed(count);
  for (std::size_t i = 0; i < count; ++i) renamed[name[i]] = cells[i];
  MechanicsBench first, second;
  first.put(cells);
  second.put(renamed);
  first.steps(20);
  second.steps(20);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(first.disc(i).x, second.disc(name[i]).x, 1e-9);
    EXPECT_NEAR(first.disc(i).y, second.disc(name[i]).y, 1e-9);
  }
}

TEST(Cluster, MovesBitForBitAlikeInAnyStorageOrder) {
  // Cells are stored by state: alike states dealt out differently permute the storage.
  Dice dice(5);
  const std::vector<StateDef> alike{
      {.name = "a"}, {.name = "b", .parent = 0}, {.name = "c", .parent = 0}};
  std::vector<Placed> cells = random_cluster(80, 6, 3, 0.5, dice);
  MechanicsBench first, second;
  first.states = second.states = alike;
  first.put(cells);
  for (Placed& p : cells) p.state = static_cast<std::uint16_t>(dice.below(3));
  second.put(cells);
  ASSERT_NE(first.cells().id, second.cells().id);
  first.steps(40);
  second.steps(40);
  for (std::uint64_t id = 0; id < cells.size(); ++id) {
    const std::uint32_t i = first.at(id), j = second.at(id);
    ASSERT_EQ(first.cells().x[i], second.cells().x[j]);
    ASSERT_EQ(first.cells().vy[i], second.cells().vy[j]);
    ASSERT_EQ(first.cells().pressure[i], second.cells().pressure[j]);
    ASSERT_EQ(first.cells().stress_xy[i], second.cells().stress_xy[j]);
  }
}

// ---- islands ------------------------------------------------------------------------------------

/// Heaps of some cells, far from each other; those of some heaps fly, all together.
std::vector<Placed> flying_heaps(Dice& dice, double speed) {
  std::vector<Placed> cells;
  const double pitch = dice.uniform(9, 14);
  for (int heap = 0; heap < 9; ++heap) {
    const bool flies = dice.below(2) == 0;
    const double vx = dice.uniform(-speed, speed), vy = dice.uniform(-speed, speed);
    for (std::uint64_t count = 1 + dice.below(12); count > 0; --count)
      cells.push_back({.x = heap % 3 * pitch + dice.uniform(-1.5, 1.5),
                       .y = heap / 3 * pitch + dice.uniform(-1.5, 1.5),
                       .vx = (flies ? vx : 0) + dice.uniform(-1, 1),
                       .vy = (flies ? vy : 0) + dice.uniform(-1, 1),
                       .state = static_cast<std::uint16_t>(dice.below(3))});
  }
  // Those of a heap are not born one after another.
  for (std::size_t i = cells.size(); i > 1; --i) std::swap(cells[i - 1], cells[dice.below(i)]);
  return cells;
}

TEST(Islands, MoveBitForBitAsAllAtOnceDoHoweverFarTheyFlyInAStep) {
  Team team(3, 4);
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Dice dice(seed);
    // Three substeps of 1/30: up to some radii, or several times the way to the next heap.
    const std::vector<Placed> cells = flying_heaps(dice, dice.uniform(1, 200));
    MechanicsBench whole, by_island, by_threads;
    for (MechanicsBench* bench : {&whole, &by_island, &by_threads}) {
      bench->states = mixed_states();
      bench->put(cells);
    }
    by_island.simulation().move_by_island_from(2);
    by_threads.simulation().move_by_island_from(2);
    by_threads.simulation().use(&team);
    for (int step = 0; step < 4; ++step) {
      for (MechanicsBench* bench : {&whole, &by_island, &by_threads}) bench->steps(1);
      ASSERT_EQ(by_island.simulation().hash(), whole.simulation().hash())
          << "seed " << seed << ", step " << step;
      ASSERT_EQ(by_threads.simulation().hash(), whole.simulation().hash())
          << "three threads, seed " << seed << ", step " << step;
    }
  }
}

TEST(Islands, KeepTheContactsOfThoseWhomAWoundLeaves) {
  Dice dice(7);
  MechanicsBench whole, by_island;
  const std::vector<Placed> cells = flying_heaps(dice, 0.5);
  whole.states = by_island.states = mixed_states();
  whole.put(cells);
  by_island.put(cells);
  by_island.simulation().move_by_island_from(2);
  for (int step = 0; step < 12; ++step) {
    whole.steps(1);
    by_island.steps(1);
    // Nothing but the contacts tells of them until the next step.
    const std::uint64_t hit = dice.below(whole.cells().size());
    const Wound wound{.x = whole.cells().x[hit], .y = whole.cells().y[hit], .radius = 0.8};
    whole.simulation().wound(wound);
    by_island.simulation().wound(wound);
    ASSERT_EQ(whole.simulation().hash(), by_island.simulation().hash()) << "step " << step;
  }
  EXPECT_LT(whole.cells().size(), cells.size());
}

TEST(Cluster, OfAHundredAndFiftyComesToRest) {
  Dice dice(6);
  MechanicsBench bench;
  bench.put(lattice(150, 1.77, 0.15, dice));
  bench.steps(1);
  const auto rms = [&] {
    double sum = 0;
    for (const Disc& d : bench.discs()) sum += d.vx * d.vx + d.vy * d.vy;
    return std::sqrt(sum / 150);
  };
  EXPECT_GT(rms(), 1e-2);
  bench.steps(333);  // 1,002 substeps
  ASSERT_EQ(bench.cells().size(), 150u);
  EXPECT_LT(rms(), 1e-6);
}

TEST(Cluster, CoincidentCentresPartOppositelyAndReproducibly) {
  const auto parted = [](std::uint64_t a, std::uint64_t b) {
    MechanicsBench bench;
    bench.start_with({{.id = a, .x = 1, .y = 2}, {.id = b, .x = 1, .y = 2}});
    bench.steps(1);
    const CellStore& c = bench.cells();
    const std::uint32_t i = bench.at(a), j = bench.at(b);
    EXPECT_EQ(c.vx[i], -c.vx[j]);
    EXPECT_EQ(c.vy[i], -c.vy[j]);
    EXPECT_GT(std::hypot(c.x[i] - c.x[j], c.y[i] - c.y[j]), 0.1);
    EXPECT_TRUE(std::isfinite(c.pressure[i]));
    return std::array{c.x[i], c.y[i]};
  };
  EXPECT_EQ(parted(3, 7), parted(3, 7));
  EXPECT_NE(parted(3, 7), parted(3, 8)) << "the direction is a matter of both ids";
  EXPECT_NE(parted(3, 7), parted(4, 7));

  MechanicsBench heap;
  heap.put(std::vector<Placed>(5));
  heap.steps(300);
  for (std::uint64_t a = 0; a < 5; ++a)
    for (std::uint64_t b = 0; b < a; ++b) EXPECT_GT(heap.distance(a, b), 1.0);
}

TEST(Cluster, PartsCoincidentCentresAlikeWhoeverElseLivesInTheWorld) {
  const auto parted = [](std::vector<Founder> founders, std::uint16_t own) {
    MechanicsBench bench;
    bench.founders = std::move(founders);
    std::vector<Placed> cells{{.id = 3, .organism = own}, {.id = 7, .organism = own}};
    if (own == 1) cells.push_back({.id = 0, .x = 50, .organism = 0});
    bench.start_with(cells);
    bench.steps(1);
    return std::array{bench.cells().x[bench.at(3, own)], bench.cells().y[bench.at(3, own)]};
  };
  // Organism 9 alone, and after an organism of a lower key that it never meets.
  EXPECT_EQ(parted({{.key = 9}}, 0), parted({{.key = 4}, {.key = 9}}, 1));
}

// ---- pressure and stress ------------------------------------------------------------------------

TEST(Pressure, IsTheSummedPushOverItselfPlusTen) {
  MechanicsBench bench;
  bench.probe();
  bench.put({{.x = 0}, {.x = 1.4}, {.x = -1.6}, {.x = 0, .y = 2.1}});
  bench.steps(1);
  // Cell 0: pushes of 6 and 4 (adhesion at 2.1 and the pulls do not count).
  EXPECT_NEAR(bench.cells().pressure[bench.at(0)], 10.0 / 20, 1e-5);
  EXPECT_NEAR(bench.cells().pressure[bench.at(1)], 6.0 / 16, 1e-5);
  EXPECT_NEAR(bench.cells().pressure[bench.at(2)], 4.0 / 14, 1e-5);
  EXPECT_EQ(bench.cells().pressure[bench.at(3)], 0);
}

TEST(Pressure, ScaleIsTheExperiments) {
  MechanicsBench bench;
  bench.probe();
  bench.config.mechanics.pressure_scale = 2;
  bench.put({{.x = 0}, {.x = 1.4}});
  bench.steps(1);
  EXPECT_NEAR(bench.cells().pressure[bench.at(0)], 6.0 / 8, 1e-5);
}

TEST(Pressure, OfSixNeighboursAtRestReadsAboutPointFiveEight) {
  MechanicsBench bench;
  std::vector<Placed> cells{{.x = 0, .y = 0}};
  for (int k = 0; k < 6; ++k) {
    const double angle = k * std::numbers::pi / 3;
    cells.push_back({.x = 23.0 / 13 * std::cos(angle), .y = 23.0 / 13 * std::sin(angle)});
  }
  bench.put(cells);
  bench.steps(20);
  EXPECT_NEAR(bench.cells().pressure[bench.at(0)], 0.58, 0.005);
}

TEST(Stress, IsTheSumOfPushTimesNormalNormal) {
  MechanicsBench bench;
  bench.probe();
  // From cell 0: a push of 8 along x at distance 1.2, and of 5 along (0.6, 0.8) at 1.5; the third
  // contact at 2.2 adheres only.
  bench.put({{.x = 0}, {.x = 1.2}, {.x = -0.9, .y = -1.2}, {.x = 0, .y = 2.2}});
  bench.steps(1);
  const CellStore& c = bench.cells();
  const std::uint32_t i = bench.at(0);
  EXPECT_NEAR(c.stress_xx[i], 8 + 5 * 0.36, 1e-4);
  EXPECT_NEAR(c.stress_xy[i], 5 * 0.48, 1e-4);
  EXPECT_NEAR(c.stress_yy[i], 5 * 0.64, 1e-4);
  EXPECT_EQ(c.stress_xx[bench.at(3)], 0);
}

TEST(Stress, IsThatOfTheLastPositions) {
  MechanicsBench bench;
  bench.put({{.x = 0}, {.x = 1.2}});
  bench.steps(1);
  const double push = 10 * (2 - bench.distance(0, 1));
  ASSERT_GT(bench.distance(0, 1), 1.25);
  EXPECT_NEAR(bench.cells().stress_xx[0], push, 1e-10);
  EXPECT_NEAR(bench.cells().pressure[0], push / (push + 10), 1e-12);
}

// ---- time steps and the environment's forces ----------------------------------------------------

TEST(TimeStep, SubstepsAreAsManyAndAsLongAsConfigured) {
  for (const std::uint32_t substeps : {1u, 4u}) {
    MechanicsBench bench;
    bench.config.mechanics = {.substeps = substeps, .time_step = 0.02, .damping = 3, .drag = 0};
    bench.put({{.x = 0, .vx = 1.5}});
    bench.steps(3);
    EXPECT_NEAR(bench.cells().x[0], 3 * 1.5 * 0.02 * substeps, 1e-14);
  }
}

TEST(TimeStep, ForcesOfEnvironmentsAddUpEverySubstep) {
  int calls = 0;
  MechanicsBench bench;
  bench.states[0].mass = 4;
  bench.config.mechanics.drag = 0;
  std::vector<double> seen;
  for (int k = 0; k < 2; ++k)
    bench.environments.push_back(acting("wind" + std::to_string(k), Phase::forces, [&](World& w) {
      ++calls;
      seen.push_back(w.cells().x[0]);
      for (double& f : w.force_x()) f += 3;
      for (double& f : w.force_y()) f -= 1;
    }));
  bench.put({{.x = 0}});
  bench.steps(1);
  EXPECT_EQ(calls, 2 * 3);
  const double h = 1.0 / 30, ax = 6.0 / 4, ay = -2.0 / 4;
  EXPECT_NEAR(bench.cells().vx[0], 3 * h * ax, 1e-14);
  EXPECT_NEAR(bench.cells().vy[0], 3 * h * ay, 1e-14);
  EXPECT_NEAR(bench.cells().x[0], (1 + 2 + 3) * h * h * ax, 1e-14);
  // Each substep shows the positions that the one before left.
  EXPECT_EQ(seen[0], 0);
  EXPECT_NEAR(seen[2], h * h * ax, 1e-14);
  EXPECT_NEAR(seen[4], 3 * h * h * ax, 1e-14);
}

TEST(TimeStep, LimitFollowsTheFormula) {
  // Defaults: K = 13 x 13 / 2 = 84.5, C = 13 x 3 / 2 + 1 = 20.5.
  EXPECT_NEAR(stable_time_step(10, 3, 1, 3, 1), 0.0416, 5e-5);
  EXPECT_NEAR(stable_time_step(10, 3, 1, 3, 1),
              (std::sqrt(20.5 * 20.5 + 4 * 84.5) - 20.5) / (2 * 84.5), 1e-15);
  // Mass 2, no damping or drag: K = 13 x 8 / 4 = 26, h = 1 / sqrt K.
  EXPECT_NEAR(stable_time_step(6, 2, 2, 0, 0), 1 / std::sqrt(26.0), 1e-15);
}

TEST(TimeStep, LimitOfVanishingSpringsIsThatOfNone) {
  // As K -> 0 the formula tends to 1 / C; no springs at all must not allow more than that.
  const double weak = stable_time_step(1e-6, 0, 1, 3, 1);
  EXPECT_NEAR(weak, 1 / 20.5, 1e-6);
  EXPECT_NEAR(stable_time_step(0, 0, 1, 3, 1), weak, 1e-6);
}

TEST(TimeStep, TooLongASubstepIsRefused) {
  MechanicsBench bench;
  bench.config.mechanics.time_step = 0.0416;
  EXPECT_NO_THROW(bench.wire());
  bench.config.mechanics.time_step = 0.0417;
  EXPECT_THROW(bench.wire(), UnstableTimeStep);
  try {
    bench.wire();
  } catch (const UnstableTimeStep& error) {
    EXPECT_NE(std::string(error.what()).find("0.0417"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("0.0416"), std::string::npos) << error.what();
  }
}

TEST(TimeStep, LimitCountsTheStiffestStickiestAndLightestStates) {
  // Each state alone would do; the worst pair that the tree can make counts.
  MechanicsBench bench;
  bench.config.mechanics.time_step = 0.04;
  bench.states = {{.name = "root"}};
  EXPECT_NO_THROW(bench.wire());
  for (const StateDef& other : {StateDef{.name = "x", .parent = 0, .stiffness = 20},
                                StateDef{.name = "x", .parent = 0, .adhesion = 13},
                                StateDef{.name = "x", .parent = 0, .mass = 0.7}}) {
    bench.states = {{.name = "root"}, other, {.name = "y", .parent = 0}};
    EXPECT_THROW(bench.wire(), UnstableTimeStep);
  }
}

}  // namespace
}  // namespace somas::model::test
