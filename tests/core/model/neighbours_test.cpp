// Pairs of neighbours against all pairs.
#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

Body body_at(double x, double y, double radius = 1) {
  Body body{};
  body.x = x;
  body.y = y;
  body.radius = radius;
  return body;
}

/// Whether two bodies may interact.
bool in_reach(const Body& a, const Body& b, double range) {
  return std::hypot(a.x - b.x, a.y - b.y) < range * (a.radius + b.radius);
}

using Pair = std::pair<std::uint32_t, std::uint32_t>;

std::vector<Pair> listed(const NeighbourPairs& pairs) {
  std::vector<Pair> all;
  for (std::size_t p = 0; p < pairs.first().size(); ++p)
    all.emplace_back(pairs.first()[p], pairs.second()[p]);
  return all;
}

/// Every pair in reach is listed once, the lower index first, in order, and nothing far away.
void expect_complete(const NeighbourPairs& pairs, const std::vector<Body>& bodies, double range,
                     double skin) {
  const std::vector<Pair> all = listed(pairs);
  for (std::size_t p = 0; p < all.size(); ++p) {
    const auto& [i, j] = all[p];
    ASSERT_LT(i, j);
    ASSERT_LT(j, bodies.size());
    if (p > 0) {
      ASSERT_LT(all[p - 1], all[p]) << "ascending, no repetition";
    }
    ASSERT_GE(p, pairs.start(i));
    ASSERT_LT(p, pairs.start(i + 1));
    const double far = range * (bodies[i].radius + bodies[j].radius) + skin;
    ASSERT_LE(std::hypot(bodies[i].x - bodies[j].x, bodies[i].y - bodies[j].y),
              far * (1 + 1e-9) + 1e-9);
  }
  for (std::uint32_t i = 0; i < bodies.size(); ++i)
    for (std::uint32_t j = i + 1; j < bodies.size(); ++j)
      if (in_reach(bodies[i], bodies[j], range)) {
        ASSERT_TRUE(std::binary_search(all.begin(), all.end(), Pair(i, j))) << i << ' ' << j;
      }
}

void check_cloud(const std::vector<Body>& bodies, Dice& dice, double skin = 0.4) {
  NeighbourPairs pairs;
  const double range = dice.uniform(1, 1.6);
  pairs.build(bodies, range, skin);
  EXPECT_FALSE(pairs.stale(bodies, range));
  expect_complete(pairs, bodies, range, skin);
}

std::vector<Body> cloud(std::size_t count, double width, double height, Dice& dice) {
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < count; ++i)
    bodies.push_back(body_at(dice.uniform(-width, width), dice.uniform(-height, height),
                             dice.uniform(0.3, 1.5)));
  return bodies;
}

TEST(NeighbourPairs, EqualBruteForceOnRandomClouds) {
  Dice dice(1);
  for (int trial = 0; trial < 40; ++trial)
    check_cloud(cloud(1 + dice.below(150), dice.uniform(1, 30), dice.uniform(1, 30), dice), dice);
}

TEST(NeighbourPairs, HoldEverybodyInAHeap) {
  Dice dice(2);
  check_cloud(cloud(200, 0.5, 0.5, dice), dice);  // all see all: the memory must grow
  check_cloud(std::vector<Body>(70, body_at(3, -4)), dice);
}

TEST(NeighbourPairs, EqualBruteForceOnSparseClouds) {
  Dice dice(3);
  for (int trial = 0; trial < 10; ++trial) check_cloud(cloud(60, 1e4, 1e4, dice), dice);
}

TEST(NeighbourPairs, EqualBruteForceOnLines) {
  Dice dice(4);
  for (int trial = 0; trial < 10; ++trial) {
    check_cloud(cloud(100, 100, 0, dice), dice);
    check_cloud(cloud(100, 0, 100, dice), dice);
    std::vector<Body> diagonal = cloud(100, 80, 0, dice);
    for (Body& body : diagonal) body.y = body.x;
    check_cloud(diagonal, dice);
  }
}

TEST(NeighbourPairs, EqualBruteForceFarFromTheOrigin) {
  Dice dice(5);
  for (const double offset : {1e6, -1e9}) {
    std::vector<Body> bodies = cloud(80, 8, 8, dice);
    for (Body& body : bodies) body.x += offset, body.y -= offset;
    check_cloud(bodies, dice);
  }
  // One cloud, and one straggler very far away.
  std::vector<Body> bodies = cloud(80, 8, 8, dice);
  bodies.push_back(body_at(1e12, -3e11));
  check_cloud(bodies, dice);
}

TEST(NeighbourPairs, OneBodyHasNoNeighboursAndNoneIsFine) {
  const std::vector<Body> one{body_at(5, 5)};
  NeighbourPairs pairs;
  pairs.build(one, 1.2, 0.4);
  EXPECT_TRUE(pairs.first().empty());
  EXPECT_EQ(pairs.start(1), 0u);
  pairs.build({}, 1.2, 0.4);
  EXPECT_FALSE(pairs.stale({}, 1.2));
}

TEST(NeighbourPairs, CountNeighboursOnlyJustWithinReach) {
  NeighbourPairs pairs;
  pairs.build(std::vector{body_at(0, 0), body_at(2.3999, 0)}, 1.2, 0);
  EXPECT_EQ(listed(pairs), (std::vector<Pair>{{0, 1}}));
  pairs.build(std::vector{body_at(0, 0), body_at(2.4001, 0)}, 1.2, 0);
  EXPECT_TRUE(pairs.first().empty());
}

TEST(NeighbourPairs, CanBeReadFourAtATimePastTheLastOne) {
  Dice dice(7);
  for (std::size_t count = 2; count < 12; ++count) {
    const std::vector<Body> bodies = cloud(count, 2, 2, dice);
    NeighbourPairs pairs;
    pairs.build(bodies, 1.2, 0.4);
    const std::size_t size = pairs.first().size();
    ASSERT_GT(size, 0u);
    for (std::size_t p = size; p % 4 != 0; ++p) {
      EXPECT_EQ(pairs.first().data()[p], pairs.first().back());
      EXPECT_EQ(pairs.second().data()[p], pairs.second().back());
    }
  }
}

TEST(NeighbourPairs, AreStaleWhenNeverBuiltOrOfAnotherSizeOrOfALongerRange) {
  std::vector<Body> bodies{body_at(0, 0), body_at(1, 0)};
  NeighbourPairs pairs;
  EXPECT_TRUE(pairs.stale(bodies, 1.2)) << "nothing was built yet";
  pairs.build(bodies, 1.2, 0.4);
  EXPECT_FALSE(pairs.stale(bodies, 1.2));
  EXPECT_TRUE(pairs.stale(bodies, 1.3));
  bodies.push_back(body_at(2, 0));
  EXPECT_TRUE(pairs.stale(bodies, 1.2));
}

TEST(NeighbourPairs, SurviveSmallMovesSoThatRebuildsAreRare) {
  std::vector<Body> bodies{body_at(0, 0), body_at(1, 0)};
  NeighbourPairs pairs;
  pairs.build(bodies, 1.2, 0.4);
  bodies[0].x += 0.15;
  bodies[1].y -= 0.15;
  EXPECT_FALSE(pairs.stale(bodies, 1.2));
  bodies[0].x += 0.1;
  EXPECT_TRUE(pairs.stale(bodies, 1.2));
}

TEST(NeighbourPairs, LeaveTheFastRoomForTheirWay) {
  std::vector<Body> bodies{body_at(0, 0), body_at(2.45, 0), body_at(-2.45, 0)};
  bodies[1].vy = 1;
  NeighbourPairs pairs;
  pairs.build(bodies, 1.2, 0.02, 0.1);
  EXPECT_EQ(listed(pairs), (std::vector<Pair>{{0, 1}}));
  bodies[1].y += 0.1;
  EXPECT_FALSE(pairs.stale(bodies, 1.2));
  bodies[2].y += 0.1;
  EXPECT_TRUE(pairs.stale(bodies, 1.2)) << "a slow one that was pushed";
}

TEST(NeighbourPairs, AreStaleWhereABodyIsNowhere) {
  std::vector<Body> bodies{body_at(0, 0), body_at(1, 0)};
  NeighbourPairs pairs;
  bodies[1].y = std::nan("");
  pairs.build(bodies, 1.2, 0.4);
  EXPECT_TRUE(pairs.first().empty());
  EXPECT_TRUE(pairs.stale(bodies, 1.2));
}

TEST(NeighbourPairs, NeverMissAPairWhileTheyAreNotStale) {
  Dice dice(8);
  const double range = 1.3;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Body> bodies = cloud(40, 6, 6, dice);
    NeighbourPairs pairs;
    pairs.build(bodies, range, 0.4);
    const std::vector<Pair> all = listed(pairs);
    const double pace = dice.uniform(0.001, 0.05), growth = dice.uniform(0, 0.03);
    // Straight courses, and every third trial all toward the middle, are the worst case.
    std::vector<std::pair<double, double>> course;
    for (const Body& body : bodies) {
      const double angle = dice.uniform(0, 6.283);
      const double distance = std::hypot(body.x, body.y) + 1e-9;
      course.push_back(trial % 3 == 0 ? std::pair(-body.x / distance, -body.y / distance)
                                      : std::pair(std::cos(angle), std::sin(angle)));
    }
    int fresh = 0;
    for (int move = 0; move < 200 && !pairs.stale(bodies, range); ++move, ++fresh) {
      for (std::uint32_t i = 0; i < bodies.size(); ++i)
        for (std::uint32_t j = i + 1; j < bodies.size(); ++j)
          if (in_reach(bodies[i], bodies[j], range)) {
            ASSERT_TRUE(std::binary_search(all.begin(), all.end(), Pair(i, j)))
                << "trial " << trial << " move " << move;
          }
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        bodies[i].x += pace * course[i].first;
        bodies[i].y += pace * course[i].second;
        bodies[i].radius += growth * dice.uniform(0, 1);
      }
    }
    EXPECT_GT(fresh, 0);
    EXPECT_LT(fresh, 200) << "they must become stale some time";
  }
}

}  // namespace
}  // namespace somas::model::test
