// Discs in bins: by one thread and by several.
#include "core/model/disc_bins.hpp"

#include <bit>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "core/model/team.hpp"
#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Heaps of discs here and there, some of which are nowhere.
std::vector<Disc> scattered(Dice& dice, int count) {
  std::vector<Disc> discs;
  for (int i = 0; i < count; ++i) {
    const double heap = 40 * static_cast<double>(dice.below(5));
    discs.push_back({heap + dice.uniform(-9, 9), dice.uniform(-9, 9) - heap, dice.uniform(0.1, 1),
                     dice.uniform(0, 0.2)});
  }
  discs[discs.size() / 2].x = std::numeric_limits<double>::quiet_NaN();
  discs[discs.size() / 3].y = 1e300;
  return discs;
}

struct Sorted {
  std::vector<std::uint32_t> start, items, bins;
  std::vector<std::uint32_t> x, y, reach;  ///< as bits: some are no numbers
  bool operator==(const Sorted&) const = default;
};

Sorted sorted(const DiscBins& bins, std::size_t count) {
  Sorted all;
  for (std::size_t b = 0; b <= std::size_t{bins.columns()} * bins.rows(); ++b)
    all.start.push_back(bins.start(b));
  all.items.assign(bins.items(), bins.items() + count);
  for (std::size_t k = 0; k < count; ++k) {
    all.bins.push_back(bins.bin_at(static_cast<std::uint32_t>(k)));
    all.x.push_back(std::bit_cast<std::uint32_t>(bins.x()[k]));
    all.y.push_back(std::bit_cast<std::uint32_t>(bins.y()[k]));
    all.reach.push_back(std::bit_cast<std::uint32_t>(bins.reach()[k]));
  }
  return all;
}

TEST(DiscBins, HoldEveryDiscOnceInOrderWithinABin) {
  Dice dice(1);
  const std::vector<Disc> discs = scattered(dice, 500);
  DiscBins bins;
  bins.sort(discs, 1.5);
  const Sorted all = sorted(bins, discs.size());
  EXPECT_EQ(std::set<std::uint32_t>(all.items.begin(), all.items.end()).size(), discs.size());
  EXPECT_EQ(all.start.front(), 0u);
  EXPECT_EQ(all.start.back(), discs.size());
  for (std::uint32_t row = 0; row < bins.rows(); ++row)
    for (std::uint32_t column = 0; column < bins.columns(); ++column) {
      const std::size_t bin = std::size_t{row} * bins.columns() + column;
      for (std::uint32_t k = all.start[bin]; k < all.start[bin + 1]; ++k) {
        if (k > all.start[bin]) {
          ASSERT_LT(all.items[k - 1], all.items[k]);
        }
        ASSERT_EQ(bins.bin_at(k), bin);
        const Disc& disc = discs[all.items[k]];
        if (!(disc.y < 1e30) || !(disc.x < 1e30)) continue;
        ASSERT_NEAR((disc.x - bins.left()) * bins.per_length(), column + 0.5, 0.5 + 1e-9);
        ASSERT_NEAR((disc.y - bins.bottom()) * bins.per_length(), row + 0.5, 0.5 + 1e-9);
      }
    }
}

TEST(DiscBins, AreTheSameHoweverManyThreadsSortThem) {
  Dice dice(2);
  for (const int count : {3, 64, 1000, 5000}) {
    const std::vector<Disc> discs = scattered(dice, count);
    DiscBins alone;
    alone.sort(discs, 1.5);
    for (const unsigned threads : {2u, 3u, 7u}) {
      Team team(threads, 1);
      DiscBins shared;
      shared.use(&team);
      shared.sort(discs, 1.5);
      EXPECT_TRUE(sorted(shared, discs.size()) == sorted(alone, discs.size()))
          << count << " discs, " << threads << " threads";
      // Again, over what is left of more.
      shared.sort(std::span(discs).first(discs.size() / 3 + 2), 1.2);
      alone.sort(std::span(discs).first(discs.size() / 3 + 2), 1.2);
      EXPECT_TRUE(sorted(shared, discs.size() / 3 + 2) == sorted(alone, discs.size() / 3 + 2));
      alone.sort(discs, 1.5);
    }
  }
}

}  // namespace
}  // namespace somas::model::test
