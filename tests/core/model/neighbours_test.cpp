// Neighbour lists against all pairs.
#include "core/model/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

Body body_at(double x, double y, double radius = 1, double range = 1.2) {
  Body body{};
  body.x = x;
  body.y = y;
  body.radius = radius;
  body.range = range;
  return body;
}

/// Whether two bodies may interact: nearer than max(1, mean range) x (r1 + r2).
bool in_reach(const Body& a, const Body& b) {
  const double range = std::max(1.0, 0.5 * (a.range + b.range));
  return std::hypot(a.x - b.x, a.y - b.y) < range * (a.radius + b.radius);
}

std::vector<std::uint32_t> shuffled_order(std::size_t count, Dice& dice) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  dice.shuffle(order);
  return order;
}

/// Every pair in reach is listed, both ways, once, in canonical order, and nothing far away.
void expect_complete(const NeighbourLists& lists, const std::vector<Body>& bodies,
                     const std::vector<std::uint32_t>& order, double skin) {
  std::vector<std::uint32_t> rank(bodies.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) rank[order[k]] = k;
  double range = 1;
  for (const Body& body : bodies) range = std::max(range, body.range);
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const auto listed = lists.of(i);
    for (std::size_t k = 1; k < listed.size(); ++k)
      ASSERT_LT(rank[listed[k - 1]], rank[listed[k]]) << "canonical order, no repetition";
    for (const std::uint32_t j : listed) {
      ASSERT_NE(j, i);
      const double far = range * (bodies[i].radius + bodies[j].radius) + skin;
      ASSERT_LE(std::hypot(bodies[i].x - bodies[j].x, bodies[i].y - bodies[j].y),
                far * (1 + 1e-9) + 1e-9);
    }
    for (std::uint32_t j = 0; j < bodies.size(); ++j) {
      if (j == i || !in_reach(bodies[i], bodies[j])) continue;
      ASSERT_NE(std::find(listed.begin(), listed.end(), j), listed.end()) << i << ' ' << j;
    }
  }
}

void check_cloud(const std::vector<Body>& bodies, Dice& dice, double skin = 0.4) {
  const std::vector<std::uint32_t> order = shuffled_order(bodies.size(), dice);
  NeighbourLists lists;
  lists.build(bodies, order, skin);
  EXPECT_FALSE(lists.stale(bodies));
  expect_complete(lists, bodies, order, skin);
}

std::vector<Body> cloud(std::size_t count, double width, double height, Dice& dice) {
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < count; ++i)
    bodies.push_back(body_at(dice.uniform(-width, width), dice.uniform(-height, height),
                             dice.uniform(0.3, 1.5), dice.uniform(1, 1.6)));
  return bodies;
}

TEST(NeighbourLists, EqualBruteForceOnRandomClouds) {
  Dice dice(1);
  for (int trial = 0; trial < 40; ++trial)
    check_cloud(cloud(1 + dice.below(150), dice.uniform(1, 30), dice.uniform(1, 30), dice), dice);
}

TEST(NeighbourLists, HoldEverybodyInAHeap) {
  Dice dice(2);
  check_cloud(cloud(200, 0.5, 0.5, dice), dice);  // all see all: the lists must grow
  check_cloud(std::vector<Body>(70, body_at(3, -4)), dice);
}

TEST(NeighbourLists, EqualBruteForceOnSparseClouds) {
  Dice dice(3);
  for (int trial = 0; trial < 10; ++trial) check_cloud(cloud(60, 1e4, 1e4, dice), dice);
}

TEST(NeighbourLists, EqualBruteForceOnLines) {
  Dice dice(4);
  for (int trial = 0; trial < 10; ++trial) {
    check_cloud(cloud(100, 100, 0, dice), dice);
    check_cloud(cloud(100, 0, 100, dice), dice);
    std::vector<Body> diagonal = cloud(100, 80, 0, dice);
    for (Body& body : diagonal) body.y = body.x;
    check_cloud(diagonal, dice);
  }
}

TEST(NeighbourLists, EqualBruteForceFarFromTheOrigin) {
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

TEST(NeighbourLists, OneBodyHasNoNeighboursAndNoneIsFine) {
  Dice dice(6);
  const std::vector<Body> one{body_at(5, 5)};
  NeighbourLists lists;
  lists.build(one, shuffled_order(1, dice), 0.4);
  EXPECT_TRUE(lists.of(0).empty());
  lists.build({}, {}, 0.4);
  EXPECT_FALSE(lists.stale({}));
}

TEST(NeighbourLists, CountNeighboursOnlyJustWithinReach) {
  Dice dice(7);
  const std::vector<std::uint32_t> order{0, 1};
  NeighbourLists lists;
  lists.build(std::vector{body_at(0, 0), body_at(2.3999, 0)}, order, 0);
  EXPECT_EQ(lists.of(0).size(), 1u);
  EXPECT_EQ(lists.of(1).size(), 1u);
  lists.build(std::vector{body_at(0, 0), body_at(2.4001, 0)}, order, 0);
  EXPECT_EQ(lists.of(0).size(), 0u);
}

TEST(NeighbourLists, AreStaleWhenInvalidatedOrOfAnotherSize) {
  std::vector<Body> bodies{body_at(0, 0), body_at(1, 0)};
  NeighbourLists lists;
  EXPECT_TRUE(lists.stale(bodies)) << "nothing was built yet";
  lists.build(bodies, std::vector<std::uint32_t>{0, 1}, 0.4);
  EXPECT_FALSE(lists.stale(bodies));
  lists.invalidate();
  EXPECT_TRUE(lists.stale(bodies));
  lists.build(bodies, std::vector<std::uint32_t>{0, 1}, 0.4);
  bodies.push_back(body_at(2, 0));
  EXPECT_TRUE(lists.stale(bodies));
}

TEST(NeighbourLists, SurviveSmallMovesSoThatRebuildsAreRare) {
  std::vector<Body> bodies{body_at(0, 0), body_at(1, 0)};
  NeighbourLists lists;
  lists.build(bodies, std::vector<std::uint32_t>{0, 1}, 0.4);
  bodies[0].x += 0.15;
  bodies[1].y -= 0.15;
  EXPECT_FALSE(lists.stale(bodies));
  bodies[0].x += 0.1;
  EXPECT_TRUE(lists.stale(bodies));
}

TEST(NeighbourLists, FollowRemovals) {
  Dice dice(9);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Body> bodies = cloud(80, 7, 7, dice);
    std::vector<std::uint32_t> order = shuffled_order(bodies.size(), dice);
    NeighbourLists lists;
    lists.build(bodies, order, 0.4);
    for (int round = 0; round < 3; ++round) {
      std::vector<std::uint32_t> new_index(bodies.size(), gone), new_order;
      std::vector<Body> rest;
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (dice.below(4) == 0) continue;
        new_index[i] = static_cast<std::uint32_t>(rest.size());
        rest.push_back(bodies[i]);
      }
      for (const std::uint32_t i : order)
        if (new_index[i] != gone) new_order.push_back(new_index[i]);
      lists.remap(new_index);
      bodies = rest;
      order = new_order;
      EXPECT_FALSE(lists.stale(bodies));
      expect_complete(lists, bodies, order, 0.4 + 0.2);  // they moved a little
      for (Body& body : bodies) body.x += dice.uniform(-0.03, 0.03);
    }
    for (Body& body : bodies) body.x += 0.5;
    EXPECT_TRUE(lists.stale(bodies));
  }
}

TEST(NeighbourLists, AreMendedAfterBirthsDeathsLeapsAndReordering) {
  // Bodies carry a name, by which the canonical order goes; the storage is shuffled every round.
  struct Named {
    std::uint32_t name;
    Body body;
  };
  Dice dice(10);
  for (int trial = 0; trial < 30; ++trial) {
    const double skin = 0.3;
    std::vector<Named> all;
    std::uint32_t next = 0;
    for (const Body& body : cloud(60, 7, 7, dice)) all.push_back({next++, body});
    NeighbourLists lists;
    for (int round = 0; round < 25; ++round) {
      std::vector<Body> bodies;
      std::vector<std::uint32_t> order(all.size()), rank(all.size());
      std::iota(order.begin(), order.end(), 0u);
      for (const Named& named : all) bodies.push_back(named.body);
      std::sort(order.begin(), order.end(),
                [&](std::uint32_t a, std::uint32_t b) { return all[a].name < all[b].name; });
      for (std::uint32_t k = 0; k < order.size(); ++k) rank[order[k]] = k;
      lists.refresh(bodies, order, rank, skin);
      ASSERT_FALSE(lists.stale(bodies));
      expect_complete(lists, bodies, order, 2 * skin);

      // Everybody drifts a little; some leap, grow, die or are born.
      for (Named& named : all) named.body.x += dice.uniform(-0.02, 0.02);
      const std::size_t leaps = round % 5 == 4 ? all.size() : dice.below(4);
      for (std::size_t k = 0; k < leaps; ++k) {
        Body& body = all[dice.below(all.size())].body;
        body.x = dice.uniform(-7, 7), body.y = dice.uniform(-7, 7);
        body.radius = dice.uniform(0.3, 1.5);
      }
      const std::size_t old_count = all.size();
      for (std::uint64_t births = dice.below(4); births > 0; --births) {
        Named child = all[dice.below(old_count)];
        child.name = next++;
        child.body.y += 1;
        all.push_back(child);
      }
      std::vector<std::uint32_t> kept;
      for (std::uint32_t k = 0; k < all.size(); ++k)
        if (all.size() < 30 || dice.below(20) != 0) kept.push_back(k);
      dice.shuffle(kept);
      std::vector<std::uint32_t> new_index(all.size(), gone);
      std::vector<Named> rest;
      for (const std::uint32_t k : kept) {
        new_index[k] = static_cast<std::uint32_t>(rest.size());
        rest.push_back(all[k]);
      }
      lists.remap(new_index);
      all = rest;
    }
  }
}

TEST(NeighbourLists, NeverMissAPairWhileTheyAreNotStale) {
  Dice dice(8);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Body> bodies = cloud(40, 6, 6, dice);
    const std::vector<std::uint32_t> order = shuffled_order(bodies.size(), dice);
    NeighbourLists lists;
    lists.build(bodies, order, 0.4);
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
    for (int move = 0; move < 200 && !lists.stale(bodies); ++move, ++fresh) {
      for (std::uint32_t i = 0; i < bodies.size(); ++i)
        for (std::uint32_t j = 0; j < bodies.size(); ++j) {
          if (i == j || !in_reach(bodies[i], bodies[j])) continue;
          const auto listed = lists.of(i);
          ASSERT_NE(std::find(listed.begin(), listed.end(), j), listed.end())
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
