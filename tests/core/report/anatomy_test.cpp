// The statistics of an organism's shape, against brute force and cases worked out by hand.
#include "core/report/anatomy.hpp"

#include <gtest/gtest.h>

#include "somas/sdk/rng.hpp"

namespace somas::report {
namespace {

/// Cells in a row of one organism, `links` as contacts of consecutive cells.
model::WorldState chain(const std::vector<bool>& linked_to_next) {
  model::WorldState world;
  const std::uint32_t count = static_cast<std::uint32_t>(linked_to_next.size()) + 1;
  for (std::uint32_t i = 0; i < count; ++i) {
    world.cells.append(0);
    world.cells.id[i] = i;
    world.cells.x[i] = 2.0 * i;
    world.cells.order.push_back(i);
    world.cells.rank.push_back(i);
  }
  std::vector<std::uint32_t>& items = world.contacts.items;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto begin = static_cast<std::uint32_t>(items.size());
    if (i > 0 && linked_to_next[i - 1]) items.push_back(i - 1);
    if (i + 1 < count && linked_to_next[i]) items.push_back(i + 1);
    world.contacts.runs.push_back({begin, static_cast<std::uint32_t>(items.size())});
  }
  return world;
}

TEST(Clusters, AreTheConnectedComponentsOfContacts) {
  const Clusters clusters = clusters_of(chain({true, false, true, true, false}));
  EXPECT_EQ(clusters.count, 3u);
  EXPECT_EQ(clusters.label, (std::vector<std::uint32_t>{0, 0, 1, 1, 1, 2}));
}

TEST(CountFarther, ComparesPairsOfTheSameClusterOnly) {
  // Cluster 0: outer at 3, inner at 1 and 2. Cluster 1: outer at 1, inner at 5.
  const std::vector<double> distance{3, 1, 2, 1, 5};
  const std::vector<std::uint32_t> cluster{0, 0, 0, 1, 1};
  const std::vector<std::uint16_t> state{1, 0, 0, 1, 0};
  const PairCount count = count_farther(distance, cluster, state, 1, 0);
  EXPECT_EQ(count.pairs, 3);
  EXPECT_EQ(count.farther, 2);
}

TEST(CountFarther, CountsTiesHalf) {
  const std::vector<double> distance{2, 2, 2, 1};
  const std::vector<std::uint32_t> cluster{0, 0, 0, 0};
  const std::vector<std::uint16_t> state{1, 0, 0, 0};
  const PairCount count = count_farther(distance, cluster, state, 1, 0);
  EXPECT_EQ(count.pairs, 3);
  EXPECT_EQ(count.farther, 2);
}

TEST(CountFarther, EqualsBruteForceOnRandomCells) {
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    Rng rng(trial, 0, 0, 0, 0);
    const std::size_t cells = 1 + rng.below(60);
    std::vector<double> distance(cells);
    std::vector<std::uint32_t> cluster(cells);
    std::vector<std::uint16_t> state(cells);
    for (std::size_t i = 0; i < cells; ++i) {
      distance[i] = static_cast<double>(rng.below(8));
      cluster[i] = static_cast<std::uint32_t>(rng.below(4));
      state[i] = static_cast<std::uint16_t>(rng.below(3));
    }
    PairCount expected;
    for (std::size_t a = 0; a < cells; ++a)
      for (std::size_t b = 0; b < cells; ++b) {
        if (state[a] != 2 || state[b] != 0 || cluster[a] != cluster[b]) continue;
        expected.pairs += 1;
        expected.farther += distance[a] > distance[b] ? 1 : (distance[a] == distance[b] ? 0.5 : 0);
      }
    const PairCount found = count_farther(distance, cluster, state, 2, 0);
    EXPECT_EQ(found.pairs, expected.pairs);
    EXPECT_EQ(found.farther, expected.farther);
  }
}

}  // namespace
}  // namespace somas::report
