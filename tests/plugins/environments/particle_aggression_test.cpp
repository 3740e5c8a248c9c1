#include "plugins/environments/particle_aggression/particle_aggression.hpp"

#include <atomic>
#include <cstdlib>
#include <new>
#include <thread>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace {
std::atomic<std::uint64_t> allocations{0};
}

// Counts what the whole test program allocates. (Inlined, gcc takes new and free for a mismatch.)
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace somas::environments {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::Pair;

using Parameters = ParticleAggression::Parameters;

/// `count` particles a step, from the first step on.
Parameters steady(double count) {
  Parameters parameters;
  parameters.rate_constant = count;
  parameters.rate_linear = parameters.rate_quadratic = 0;
  return parameters;
}

struct Particle {
  double x, y, vx, vy, energy;
  bool operator==(const Particle&) const = default;
};

std::vector<Particle> particles(FakeWorld& world) {
  Table& table = world.table(0);
  std::vector<Particle> list;
  for (std::uint32_t i = 0; i < table.rows(); ++i)
    list.push_back({table.column(0)[i], table.column(1)[i], table.column(2)[i], table.column(3)[i],
                    table.column(4)[i]});
  return list;
}

double emitted(FakeWorld& world) { return world.scalar(1); }

void run(Stage<ParticleAggression>& stage, std::uint64_t first, std::uint64_t end) {
  for (std::uint64_t step = first; step < end; ++step) stage.step(step);
}

/// A step in which none is emitted.
void fly_on(Stage<ParticleAggression>& stage, std::uint64_t step) {
  ParticleAggression silent({.rate_constant = 0, .rate_linear = 0, .rate_quadratic = 0});
  FakeDeclare declared(stage.info, "it");
  silent.declare(declared);
  stage.world.set_step(step);
  silent.act(Phase::stress, stage.world);
}

/// The sum of the rate over t = 0 ... n - 1, in closed form.
double due_after(const Parameters& p, double n) {
  return p.rate_scale * (p.rate_constant * n + p.rate_linear * n * (n - 1) / 2 +
                         p.rate_quadratic * n * (n - 1) * (2 * n - 1) / 6);
}

/// Particles as they were launched: many, on a circle so wide that the offset of a line of flight
/// from the centre is the aim's, along the axis across the flight.
std::vector<Particle> launched(double radius, double speed) {
  Parameters parameters = steady(20000);
  parameters.spawn_radius = radius;
  parameters.speed = speed;
  Stage<ParticleAggression> stage(parameters, 7, {}, 1);
  stage.step(0);
  std::vector<Particle> list = particles(stage.world);
  for (Particle& p : list) {
    p.x -= p.vx;
    p.y -= p.vy;
  }
  return list;
}

TEST(ParticleAggression, HasTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<Parameters>(),
              ElementsAre("spawn_radius", "speed", "aim_spread", "energy", "start", "rate_scale",
                          "rate_constant", "rate_linear", "rate_quadratic", "resistance_skill"));
}

TEST(ParticleAggression, DeclaresAHazardNamedLikeTheInstanceAndItsResistance) {
  Stage<ParticleAggression> stage({.resistance_skill = "armour"});
  const FakeDeclare& d = stage.declared;
  EXPECT_THAT(d.phases, ElementsAre(Phase::stress));
  EXPECT_THAT(d.skills, ElementsAre("armour"));
  EXPECT_EQ(d.skill_specs[0].fallback, 0);
  ASSERT_EQ(d.hazards.size(), 1u);
  EXPECT_EQ(d.hazards[0].name, "it");
  EXPECT_EQ(d.hazards[0].skill, 0u);
  EXPECT_THAT(d.tables, ElementsAre(ElementsAre("x", "y", "vx", "vy", "energy")));
}

TEST(ParticleAggression, RateIsThatOfTheModel) {
  const ParticleAggression environment(Parameters{});
  EXPECT_DOUBLE_EQ(environment.rate(0, 1), 0.5);
  EXPECT_DOUBLE_EQ(environment.rate(100, 1), 0.5 + 0.4 + 0.2);
  EXPECT_DOUBLE_EQ(environment.rate(1000, 1), 0.5 + 4 + 20);
  EXPECT_DOUBLE_EQ(environment.rate(1000, 0.25), 24.5 / 4);
}

TEST(ParticleAggression, EmitsTheWholePartOfWhatIsDueAtEveryStep) {
  for (const double scale : {1.0, 0.37, 2.0}) {
    const Parameters parameters{.rate_scale = scale};
    Stage<ParticleAggression> stage(parameters);
    for (std::uint64_t step = 0; step < 1000; ++step) {
      stage.step(step);
      const double due = due_after(parameters, static_cast<double>(step + 1));
      // Rounding may move a particle to the next step where a whole number falls due.
      EXPECT_LE(emitted(stage.world), due + 1e-6);
      EXPECT_GT(emitted(stage.world), due - 1 - 1e-6);
    }
  }
  Stage<ParticleAggression> stage({});
  run(stage, 0, 1000);
  EXPECT_EQ(emitted(stage.world), 9154);  // 500 + 1998 + 6656.67
}

TEST(ParticleAggression, CountsTimeFromItsStart) {
  Stage<ParticleAggression> early({});
  Stage<ParticleAggression> late({.start = 450});
  run(late, 0, 450);
  EXPECT_EQ(emitted(late.world), 0);
  EXPECT_EQ(late.world.first_hit_calls, 0);
  run(early, 0, 300);
  run(late, 450, 750);
  EXPECT_EQ(emitted(late.world), emitted(early.world));
}

TEST(ParticleAggression, StartsOnTheCircleAtAnEvenAngle) {
  const std::vector<Particle> list = launched(60, 0.5);
  ASSERT_EQ(list.size(), 20000u);
  std::vector<int> sectors(8);
  for (const Particle& p : list) {
    EXPECT_NEAR(std::hypot(p.x, p.y), 60, 1e-12);
    const double turn = std::atan2(p.y, p.x) / math::two_pi + 0.5;
    ++sectors[static_cast<std::size_t>(std::min(7.0, 8 * turn))];
  }
  // 2,500 are expected; the standard deviation is 47.
  for (const int count : sectors) EXPECT_NEAR(count, 2500, 235);
}

TEST(ParticleAggression, StartsOnTheEdgeOfTheWorldUnlessToldOtherwise) {
  Stage<ParticleAggression> stage(steady(10));
  stage.step(0);
  for (const Particle& p : particles(stage.world))
    EXPECT_NEAR(std::hypot(p.x - p.vx, p.y - p.vy), stage.info.radius, 1e-12);
}

TEST(ParticleAggression, AimsNormallyRoundTheCentre) {
  double sum = 0, squares = 0, inside = 0;
  const std::vector<Particle> list = launched(1e7, 1e6);
  for (const Particle& p : list) {
    const double offset = (p.x * p.vy - p.y * p.vx) / 1e6;
    sum += offset;
    squares += offset * offset;
    inside += std::abs(offset) < 12 ? 1 : 0;
  }
  // Bounds of five standard errors, n = 20,000.
  const auto n = static_cast<double>(list.size());
  EXPECT_NEAR(sum / n, 0, 0.42);
  EXPECT_NEAR(std::sqrt(squares / n), 12, 0.3);
  EXPECT_NEAR(inside / n, 0.6827, 0.0165);
}

TEST(ParticleAggression, FliesStraightAtItsSpeed) {
  Stage<ParticleAggression> stage(steady(5));
  stage.step(0);
  const std::vector<Particle> before = particles(stage.world);
  stage.step(1);
  const std::vector<Particle> after = particles(stage.world);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(std::hypot(before[i].vx, before[i].vy), 0.5, 1e-15);
    EXPECT_EQ(after[i].x, before[i].x + before[i].vx);
    EXPECT_EQ(after[i].y, before[i].y + before[i].vy);
    EXPECT_EQ(after[i].vx, before[i].vx);
    EXPECT_EQ(after[i].vy, before[i].vy);
  }
}

TEST(ParticleAggression, LeavesPastTheFarSide) {
  // Through the centre: 120 at 0.5 a step, and one step more at most.
  Parameters parameters = steady(1);
  parameters.aim_spread = 0;
  Stage<ParticleAggression> stage(parameters);
  run(stage, 0, 239);
  EXPECT_EQ(particles(stage.world).size(), 239u);
  run(stage, 239, 600);
  EXPECT_GE(particles(stage.world).size(), 239u);
  EXPECT_LE(particles(stage.world).size(), 241u);
}

TEST(ParticleAggression, NoneRemainsALifetimeAfterTheLastWasEmitted) {
  Stage<ParticleAggression> stage(steady(7));
  run(stage, 0, 300);
  EXPECT_GT(particles(stage.world).size(), 1000u);

  // The state is the world's, so another instance can go on with it, one that emits nothing.
  for (std::uint64_t step = 300; step < 300 + 241; ++step) fly_on(stage, step);
  EXPECT_TRUE(particles(stage.world).empty());
}

TEST(ParticleAggression, LastOnesTakeThePlacesOfThoseThatLeave) {
  const std::vector<FakeCell> few{{.x = 5}, {.x = -10, .y = 3, .id = 1}};
  Stage<ParticleAggression> stage({}, 3, few);
  run(stage, 0, 250);
  int left_within = 0, left_at_the_end = 0;
  for (std::uint64_t step = 250; step < 450; ++step) {
    std::vector<Particle> expected = particles(stage.world);
    // In two of the steps many leave at once, old ones and new ones.
    const bool wide = step == 251 || step == 300;
    stage.world.place(wide ? std::vector<FakeCell>{{.x = 25, .y = -10, .radius = 30}} : few);
    const std::size_t struck_before = stage.world.strikes.size();
    fly_on(stage, step);
    const std::vector<Particle> after = particles(stage.world);
    // Those that were struck, or are past the far side.
    std::size_t leave = stage.world.strikes.size() - struck_before;
    for (const Particle& p : expected) {
      const double x = p.x + p.vx, y = p.y + p.vy;
      leave += x * x + y * y > 3600 && x * p.vx + y * p.vy > 0 ? 1 : 0;
    }
    ASSERT_EQ(after.size() + leave, expected.size()) << step;
    // A velocity names a particle.
    const auto stays = [&](const Particle& p) {
      return std::ranges::any_of(after,
                                 [&](const Particle& q) { return q.vx == p.vx && q.vy == p.vy; });
    };
    left_at_the_end += !expected.empty() && !stays(expected.back()) ? 1 : 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      while (i < expected.size() && !stays(expected.back())) expected.pop_back();
      if (i >= expected.size() || stays(expected[i])) continue;
      ++left_within;
      expected[i] = expected.back();
      expected.pop_back();
    }
    ASSERT_EQ(after.size(), expected.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
      ASSERT_EQ(after[i].vx, expected[i].vx) << step << ' ' << i;
      ASSERT_EQ(after[i].x, expected[i].x + expected[i].vx) << step << ' ' << i;
      ASSERT_EQ(after[i].y, expected[i].y + expected[i].vy) << step << ' ' << i;
    }
  }
  EXPECT_GT(left_within, 200);
  EXPECT_GT(left_at_the_end, 0);
}

TEST(ParticleAggression, SameSeedGivesTheSameParticles) {
  Stage<ParticleAggression> one({}, 11), same({}, 11), other({}, 12);
  run(one, 0, 200);
  run(same, 0, 200);
  run(other, 0, 200);
  EXPECT_EQ(particles(one.world), particles(same.world));
  EXPECT_NE(particles(one.world), particles(other.world));
}

TEST(ParticleAggression, AHitDoesNotChangeTheOtherParticles) {
  Stage<ParticleAggression> empty({}, 5);
  Stage<ParticleAggression> struck({}, 5, {{.radius = 3}});
  run(empty, 0, 240);
  run(struck, 0, 240);
  const std::vector<Particle> all = particles(empty.world);
  const std::vector<Particle> left = particles(struck.world);
  EXPECT_LT(left.size(), all.size());
  EXPECT_GT(left.size(), 100u);
  EXPECT_THAT(all, testing::IsSupersetOf(left));
}

TEST(ParticleAggression, DoesNotDependOnTheOrderOfCells) {
  std::vector<FakeCell> cells;
  for (std::uint64_t id = 0; id < 30; ++id)
    cells.push_back({.x = 1.5 * static_cast<double>(id % 6) - 4,
                     .y = 1.5 * static_cast<double>(id / 6) - 3,
                     .id = id});
  Stage<ParticleAggression> straight({}, 2, cells);
  std::reverse(cells.begin(), cells.end());
  std::swap(cells[3], cells[17]);
  Stage<ParticleAggression> shuffled({}, 2, cells);
  run(straight, 0, 400);
  run(shuffled, 0, 400);
  EXPECT_GT(straight.world.strikes.size(), 50u);
  EXPECT_EQ(straight.world.strikes, shuffled.world.strikes);
  EXPECT_EQ(particles(straight.world), particles(shuffled.world));
}

TEST(ParticleAggression, IsSpentOnTheCellItHits) {
  // One particle, at step 0, through the centre.
  Parameters parameters = steady(1);
  parameters.aim_spread = 0;
  parameters.energy = 2.5;
  Stage<ParticleAggression> stage(parameters, 1, {{.id = 42}}, 1);
  stage.step(0);
  ParticleAggression silent(
      {.aim_spread = 0, .energy = 9, .rate_constant = 0, .rate_linear = 0, .rate_quadratic = 0});
  FakeDeclare declared(stage.info, "it");
  silent.declare(declared);

  // 59 away from the disc: not before step 117, not after step 118.
  for (std::uint64_t step = 1; step < 117; ++step) {
    stage.world.set_step(step);
    silent.act(Phase::stress, stage.world);
  }
  EXPECT_TRUE(stage.world.strikes.empty());
  EXPECT_EQ(particles(stage.world).size(), 1u);
  for (std::uint64_t step = 117; step < 300; ++step) {
    stage.world.set_step(step);
    silent.act(Phase::stress, stage.world);
  }
  EXPECT_THAT(stage.world.strikes, ElementsAre(Strike{42, 2.5}));
  EXPECT_TRUE(particles(stage.world).empty());
}

TEST(ParticleAggression, CannotTunnelThroughACellInOneStep) {
  Parameters parameters = steady(1);
  parameters.aim_spread = 0;
  parameters.speed = 1000;
  Stage<ParticleAggression> stage(parameters, 1, {{.radius = 0.1, .id = 3}});
  stage.step(0);
  EXPECT_THAT(stage.world.strikes, ElementsAre(Strike{3, 1.0}));
  EXPECT_TRUE(particles(stage.world).empty());
}

TEST(ParticleAggression, AsksForTheHitsOfAllThatAreNearAtOnce) {
  Stage<ParticleAggression> stage(steady(300), 1, {{.radius = 61, .id = 1}});
  run(stage, 0, 50);
  EXPECT_EQ(stage.world.first_hit_calls, 50);
  EXPECT_EQ(stage.world.strikes.size(), 300u * 50);
}

TEST(ParticleAggression, DoesNotAskWhileAllAreFarFromTheCells) {
  Stage<ParticleAggression> stage(steady(3), 1, {{.radius = 1, .id = 1}});
  run(stage, 0, 50);
  EXPECT_EQ(particles(stage.world).size(), 150u);
  EXPECT_EQ(stage.world.first_hit_calls, 0);
}

TEST(ParticleAggression, AimedAtItsOwnPlaceItFliesToTheCentre) {
  // So small a circle that the squared distance to the aim underflows to zero.
  Parameters parameters = steady(100);
  parameters.aim_spread = 0;
  parameters.spawn_radius = 1e-300;
  Stage<ParticleAggression> stage(parameters, 1, {}, 1);
  stage.step(0);
  for (const Particle& p : particles(stage.world)) EXPECT_NEAR(std::hypot(p.vx, p.vy), 0.5, 1e-15);
}

TEST(ParticleAggression, EmitsByTheRateScaleOfTheMoment) {
  Stage<ParticleAggression> stage(steady(3));
  ASSERT_EQ(stage.declared.parameter_names, std::vector<std::string>{"rate_scale"});
  stage.step(0);
  EXPECT_EQ(particles(stage.world).size(), 3u);
  stage.world.parameters[0] *= 2;
  stage.step(1);
  EXPECT_EQ(particles(stage.world).size(), 9u);
  stage.world.parameters[0] = 0;
  stage.step(2);
  EXPECT_EQ(particles(stage.world).size(), 9u);
  stage.world.parameters[0] = 1e8;
  EXPECT_THROW(stage.step(3), std::runtime_error) << "before the memory is full";
}

TEST(ParticleAggression, AllocatesNothingOnceWarm) {
  Stage<ParticleAggression> stage(steady(4));
  run(stage, 0, 500);
  const std::uint64_t before = allocations;
  run(stage, 500, 520);
  EXPECT_EQ(allocations - before, 0u);
}

TEST(ParticleAggression, OneInstanceServesSeveralThreads) {
  ParticleAggression environment({});
  const WorldInfo info{60, 3000, 3, 1.0 / 30};
  FakeDeclare declared(info, "it");
  environment.declare(declared);
  const auto particles_of = [&](std::uint64_t seed) {
    FakeWorld world(info, seed, declared, {{.radius = 2}});
    for (std::uint64_t step = 0; step < 300; ++step) {
      world.set_step(step);
      environment.act(Phase::stress, world);
    }
    return particles(world);
  };
  std::vector<std::vector<Particle>> alone(4), together(4);
  for (std::uint64_t seed = 0; seed < 4; ++seed) alone[seed] = particles_of(seed);
  std::vector<std::thread> threads;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    threads.emplace_back([&, seed] { together[seed] = particles_of(seed); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(alone, together);
}

/// A thread for each part, the last part's first.
class Helpers final : public Workers {
 public:
  explicit Helpers(std::uint32_t threads) : threads_(threads) {}
  void share(std::uint32_t count, std::uint32_t least, Call call, void* context) override {
    if (count == 0) return;
    const std::uint32_t parts = std::clamp(count / std::max(least, 1u), 1u, threads_);
    std::vector<std::thread> others;
    for (std::uint32_t part = parts; part-- > 0;)
      others.emplace_back([=] { call(context, count * part / parts, count * (part + 1) / parts); });
    for (std::thread& other : others) other.join();
  }
  std::uint32_t threads() const override { return threads_; }

 private:
  std::uint32_t threads_;
};

struct Flight {
  std::vector<Strike> strikes;
  std::vector<Particle> left;
  int first_hit_calls;
};

/// So many steps that so many threads share (0: the host knows of none).
Flight shared(const Parameters& parameters, const std::vector<FakeCell>& cells, std::uint64_t steps,
              std::uint32_t threads) {
  Helpers helpers(threads);
  Stage<ParticleAggression> stage(parameters, 4, cells);
  if (threads > 0) stage.world.workers = &helpers;
  run(stage, 0, steps);
  return {stage.world.strikes, particles(stage.world), stage.world.first_hit_calls};
}

TEST(ParticleAggression, StrikesInTheSameOrderHoweverManyThreadsShareTheFlight) {
  // Some 150,000 in flight: more than a round of as many threads.
  Parameters crowd = steady(30000);
  crowd.speed = 25;
  const std::vector<FakeCell> cells{{.x = 5, .radius = 2, .id = 7},
                                    {.x = -20, .y = 9, .radius = 3, .id = 2},
                                    {.x = 3, .y = -30, .radius = 2, .id = 9}};
  const Flight alone = shared(crowd, cells, 6, 0);
  EXPECT_GT(alone.strikes.size(), 10000u);
  EXPECT_GT(alone.left.size(), 100000u);
  for (const std::uint32_t threads : {1u, 2u, 3u, 7u}) {
    const Flight together = shared(crowd, cells, 6, threads);
    EXPECT_TRUE(together.strikes == alone.strikes) << threads;
    EXPECT_TRUE(together.left == alone.left) << threads;
  }
  // Each search is shared in turn, which is worth it for many at a time.
  EXPECT_LT(shared(crowd, cells, 6, 2).first_hit_calls, alone.first_hit_calls / 4);
}

TEST(ParticleAggression, MeetsCellsFarOutHoweverManyThreadsLookForThem) {
  // Far out on each side is one among many, each in the middle of another part of them.
  std::vector<FakeCell> cells(100'000, {.radius = 1e-3});
  const std::array<FakeCell, 4> outer{{{.x = 40, .radius = 15},
                                       {.x = -40, .radius = 15},
                                       {.y = 40, .radius = 15},
                                       {.y = -40, .radius = 15}}};
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].id = i;
  for (std::size_t side = 0; side < outer.size(); ++side) {
    const std::size_t at = cells.size() * (2 * side + 1) / 8;
    cells[at] = outer[side];
    cells[at].id = at;
  }
  Parameters fast = steady(5);
  fast.speed = 10;
  const Flight alone = shared(fast, cells, 12, 0);
  std::set<std::uint64_t> struck;
  for (const Strike& strike : alone.strikes) struck.insert(strike.cell_id);
  EXPECT_THAT(struck, testing::IsSupersetOf({12'500u, 37'500u, 62'500u, 87'500u}));
  for (const std::uint32_t threads : {2u, 4u, 7u})
    EXPECT_EQ(shared(fast, cells, 12, threads).strikes, alone.strikes) << threads;
}

TEST(ParticleAggression, RefusesMoreParticlesThanMemoryHolds) {
  EXPECT_THAT(refusal([] { Stage<ParticleAggression> stage({.rate_scale = 1e4}); }),
              Pair("rate_scale",
                   "more than ten million particles at a time could be in flight at the last step; "
                   "lower the rate, raise 'speed' or shorten the run"));
  // A start after the end means never.
  EXPECT_THAT(refusal([] { Stage<ParticleAggression> stage({.start = 5000, .rate_scale = 1e4}); }),
              Pair("", "no refusal"));
}

}  // namespace
}  // namespace somas::environments
