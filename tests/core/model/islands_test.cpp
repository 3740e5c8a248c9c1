// Islands of bodies against chains of all pairs.
#include "core/model/islands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/model/team.hpp"
#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

struct Cloud {
  std::vector<double> x, y;

  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
  [[nodiscard]] Sites sites() const { return {x, y, {}}; }
};

/// Heaps of `radius`, so far from each other, their bodies in a random order.
Cloud archipelago(Dice& dice, int heaps, double gap, double radius) {
  Cloud cloud;
  const auto pitch = gap + 2 * radius;
  for (int body = 0; body < 40 * heaps; ++body) {
    const auto heap = static_cast<double>(dice.below(static_cast<std::uint64_t>(heaps)));
    cloud.add(std::fmod(heap, 3) * pitch + dice.uniform(-radius, radius),
              std::floor(heap / 3) * pitch + dice.uniform(-radius, radius));
  }
  return cloud;
}

void expect_permutation(std::vector<std::uint32_t> numbers, std::size_t count) {
  ASSERT_EQ(numbers.size(), count);
  std::sort(numbers.begin(), numbers.end());
  for (std::uint32_t k = 0; k < count; ++k) ASSERT_EQ(numbers[k], k);
}

/// For each body the lowest that a chain of bodies nearer than `distance` joins it with.
std::vector<std::uint32_t> chains(const Cloud& cloud, double distance) {
  std::vector<std::uint32_t> lowest(cloud.x.size());
  std::iota(lowest.begin(), lowest.end(), 0u);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < lowest.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (lowest[i] != lowest[j] &&
            std::hypot(cloud.x[i] - cloud.x[j], cloud.y[i] - cloud.y[j]) < distance) {
          lowest[i] = lowest[j] = std::min(lowest[i], lowest[j]);
          changed = true;
        }
  }
  return lowest;
}

TEST(Islands, OfTwoThatAChainJoinsTheLowerStaysSo) {
  Dice dice(1);
  Islands islands;
  int numbered = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Cloud cloud;
    const double extent = dice.uniform(5, 60), distance = dice.uniform(0.5, 4);
    for (std::uint64_t count = 1 + dice.below(150); count > 0; --count)
      cloud.add(dice.uniform(-extent, extent), dice.uniform(-extent, extent));
    std::vector<std::uint32_t> numbers;
    if (!islands.number(cloud.sites(), distance, numbers)) continue;
    ++numbered;
    expect_permutation(numbers, cloud.x.size());
    const std::vector<std::uint32_t> lowest = chains(cloud, distance);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (lowest[i] == lowest[j]) {
          ASSERT_LT(numbers[j], numbers[i]);
        }
  }
  EXPECT_GT(numbered, 30);
}

TEST(Islands, ThatLieApartStandOneAfterAnother) {
  Dice dice(2);
  Islands islands;
  for (int heaps = 2; heaps < 10; ++heaps) {
    // Bins are a little wider than the distance: with one empty between them heaps are apart.
    const Cloud cloud = archipelago(dice, heaps, 2.5, 1);
    std::vector<std::uint32_t> numbers;
    ASSERT_TRUE(islands.number(cloud.sites(), 1, numbers));
    const std::vector<std::uint32_t> lowest = chains(cloud, 2.4);
    std::vector<std::uint32_t> heap_at(numbers.size());
    for (std::size_t k = 0; k < numbers.size(); ++k) heap_at[numbers[k]] = lowest[k];
    const auto changes = std::inner_product(heap_at.begin() + 1, heap_at.end(), heap_at.begin(), 0,
                                            std::plus<>(), std::not_equal_to<>());
    std::sort(heap_at.begin(), heap_at.end());
    const auto different = std::unique(heap_at.begin(), heap_at.end()) - heap_at.begin();
    EXPECT_EQ(changes, different - 1);
  }
}

TEST(Islands, AreJoinedAcrossCornersAndRoundBays) {
  Islands islands;
  std::vector<std::uint32_t> numbers;
  // A ring of one body a bin, open below, with a body in its middle: two islands.
  Cloud ring;
  for (int step = 0; step < 40; ++step)
    ring.add(10 * std::sin(0.15 * step), 10 * std::cos(0.15 * step));
  EXPECT_FALSE(islands.number(ring.sites(), 2, numbers)) << "one chain";
  ring.add(0, 0);
  EXPECT_TRUE(islands.number(ring.sites(), 2, numbers));
  // A stair: neighbours touch at the corners of bins only.
  for (const double direction : {1.0, -1.0}) {
    Cloud stair;
    for (int step = 0; step < 20; ++step) stair.add(direction * 0.99 * step, 0.99 * step);
    EXPECT_FALSE(islands.number(stair.sites(), 1.45, numbers)) << direction;
  }
}

TEST(Islands, CountBodiesThatAreNowhere) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Cloud cloud;
  cloud.add(0, 0), cloud.add(std::numeric_limits<double>::quiet_NaN(), 1), cloud.add(100, 0);
  cloud.add(-infinity, infinity), cloud.add(1e300, -1e300), cloud.add(100.5, 0), cloud.add(0.5, 0);
  Islands islands;
  std::vector<std::uint32_t> numbers;
  ASSERT_TRUE(islands.number(cloud.sites(), 1, numbers));
  expect_permutation(numbers, cloud.x.size());
  EXPECT_LT(numbers[0], numbers[6]);
  EXPECT_LT(numbers[2], numbers[5]);
  for (double& x : cloud.x) x = infinity;
  EXPECT_FALSE(islands.number(cloud.sites(), 1, numbers));
}

TEST(Islands, TakeFewBinsHoweverFarOffABodyIs) {
  Cloud cloud;
  cloud.add(0, 0), cloud.add(1e12, 1e12), cloud.add(0.1, 0);
  Islands islands;
  std::vector<std::uint32_t> numbers;
  ASSERT_TRUE(islands.number(cloud.sites(), 1, numbers)) << "and not for want of memory";
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0, 2, 1}));
}

TEST(Islands, AreNumberedAlikeByAnyNumberOfThreadsAndFromAnyStorage) {
  Dice dice(3);
  const Cloud cloud = archipelago(dice, 8, 4, 3);
  Islands alone;
  std::vector<std::uint32_t> expected;
  ASSERT_TRUE(alone.number(cloud.sites(), 1.5, expected));
  for (const unsigned threads : {2u, 3u, 4u}) {
    Team team(threads, 1);
    Islands shared;
    shared.use(&team);
    std::vector<std::uint32_t> numbers;
    ASSERT_TRUE(shared.number(cloud.sites(), 1.5, numbers));
    EXPECT_EQ(numbers, expected) << threads;
  }
  // Backwards, in pairs (x, y).
  const auto count = static_cast<std::uint32_t>(cloud.x.size());
  Cloud stored = cloud;
  std::vector<std::uint32_t> index(count), numbers;
  for (std::uint32_t k = 0; k < count; ++k) {
    index[k] = count - 1 - k;
    stored.x[index[k]] = cloud.x[k];
    stored.y[index[k]] = cloud.y[k];
  }
  ASSERT_TRUE(alone.number({stored.x, stored.y, index}, 1.5, numbers));
  EXPECT_EQ(numbers, expected);
}

}  // namespace
}  // namespace somas::model::test
