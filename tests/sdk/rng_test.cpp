// Random numbers: Philox against Random123, distributions against their moments, streams by name.
#include "somas/sdk/rng.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include <Random123/philox.h>
#include <gtest/gtest.h>

namespace somas {
namespace {

using Counter = std::array<std::uint64_t, 4>;
using Key = std::array<std::uint64_t, 2>;

TEST(Philox, GivesTheKnownAnswers) {
  // From Random123's kat_vectors, philox4x64 with 10 rounds.
  constexpr std::uint64_t ones = ~std::uint64_t{0};
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Counter{0x16554d9eca36314cull, 0xdb20fe9d672d0fdcull,
                                                   0xd7e772cee186176bull, 0x7e68b68aec7ba23bull}));
  EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
            (Counter{0x87b092c3013fe90bull, 0x438c3c67be8d0224ull, 0x9cc7d7c69cd777b6ull,
                     0xa09caebf594f0ba0ull}));
  EXPECT_EQ(philox({0x243f6a8885a308d3ull, 0x13198a2e03707344ull, 0xa4093822299f31d0ull,
                    0x082efa98ec4e6c89ull},
                   {0x452821e638d01377ull, 0xbe5466cf34e90c6cull}),
            (Counter{0xa528f45403e61d95ull, 0x38c72dbd566e9788ull, 0xa5a1610e72fd18b5ull,
                     0x57bd43b5e52b7fe6ull}));
}

TEST(Philox, EqualsRandom123OnRandomInputs) {
  std::mt19937_64 engine(1);
  for (int i = 0; i < 20000; ++i) {
    const Counter counter{engine(), engine(), engine(), engine()};
    const Key key{engine(), engine()};
    const philox4x64_ctr_t reference_counter{{counter[0], counter[1], counter[2], counter[3]}};
    const philox4x64_key_t reference_key{{key[0], key[1]}};
    const philox4x64_ctr_t reference = philox4x64_R(10, reference_counter, reference_key);
    const Counter ours = philox(counter, key);
    for (std::size_t k = 0; k < 4; ++k) ASSERT_EQ(ours[k], reference.v[k]);
  }
}

TEST(Philox, WorksAtCompileTime) {
  static_assert(philox({0, 0, 0, 0}, {0, 0})[0] == 0x16554d9eca36314cull);
  static_assert(Rng(1, 2, 3, 4, 5).below(1) == 0);
}

TEST(Stream, IsPhiloxOfItsNameBlockByBlock) {
  Rng rng(11, 22, 33, 44, 55);
  for (std::uint64_t block = 0; block < 3; ++block) {
    const philox4x64_ctr_t reference =
        philox4x64_R(10, philox4x64_ctr_t{{block, 33, 44, 55}}, philox4x64_key_t{{11, 22}});
    for (const std::uint64_t word : reference.v) EXPECT_EQ(rng.bits(), word);
  }
}

TEST(Stream, DependsOnEveryPartOfItsName) {
  const std::array<std::uint64_t, 5> name{1, 2, 3, 4, 5};
  const auto first = [](const std::array<std::uint64_t, 5>& n) {
    return Rng(n[0], n[1], n[2], n[3], n[4]).bits();
  };
  std::set<std::uint64_t> seen{first(name)};
  EXPECT_EQ(first(name), first(name));
  for (std::size_t part = 0; part < 5; ++part)
    for (const std::uint64_t change :
         {std::uint64_t{1}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
      auto other = name;
      other[part] ^= change;
      EXPECT_TRUE(seen.insert(first(other)).second) << "part " << part;
    }
  // Neighbouring names share nothing, wherever the same number stands.
  EXPECT_NE(first({1, 2, 3, 4, 5}), first({2, 1, 3, 4, 5}));
  EXPECT_NE(first({1, 2, 3, 4, 5}), first({1, 2, 3, 5, 4}));
}

TEST(Stream, CopyContinuesOnItsOwn) {
  Rng rng(1, 2, 3, 4, 5);
  (void)rng.bits();
  Rng copy = rng;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(rng.bits(), copy.bits());
}

TEST(Uniform, IsTheTopFiftyThreeBits) {
  Rng rng(7, 0, 0, 0, 0), bits(7, 0, 0, 0, 0);
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(rng.uniform(), std::ldexp(static_cast<double>(bits.bits() >> 11), -53));
}

TEST(Uniform, FillsTheUnitIntervalEvenly) {
  Rng rng(8, 0, 0, 0, 0);
  const int n = 400000;
  double sum = 0, squares = 0;
  std::array<int, 20> bins{};
  for (int i = 0; i < n; ++i) {
    const double u = rng.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u, squares += u * u;
    ++bins[static_cast<std::size_t>(u * 20)];
  }
  EXPECT_NEAR(sum / n, 0.5, 0.002);
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.002);
  double chi2 = 0;
  for (const int count : bins) chi2 += std::pow(count - n / 20, 2) / (n / 20.0);
  EXPECT_LT(chi2, 45) << "19 degrees of freedom";
}

TEST(Uniform, OfARangeStaysInIt) {
  Rng rng(9, 0, 0, 0, 0);
  double least = 1e9, greatest = -1e9;
  for (int i = 0; i < 20000; ++i) {
    const double u = rng.uniform(-3, 5);
    least = std::min(least, u), greatest = std::max(greatest, u);
  }
  EXPECT_GE(least, -3);
  EXPECT_LT(least, -2.99);
  EXPECT_LT(greatest, 5);
  EXPECT_GT(greatest, 4.99);
}

TEST(Below, IsUnbiasedForAllSizes) {
  Rng rng(10, 0, 0, 0, 0);
  for (const std::uint64_t n : {1ull, 2ull, 3ull, 7ull, 10ull, 100ull}) {
    std::vector<int> counts(n);
    const int draws = 30000;
    for (int i = 0; i < draws; ++i) {
      const std::uint64_t value = rng.below(n);
      ASSERT_LT(value, n);
      ++counts[value];
    }
    const double expected = draws / static_cast<double>(n);
    double chi2 = 0;
    for (const int count : counts) chi2 += (count - expected) * (count - expected) / expected;
    EXPECT_LT(chi2, static_cast<double>(n) + 5 * std::sqrt(2.0 * static_cast<double>(n)) + 5) << n;
  }
}

TEST(Below, OfAHugeSizeRejectsWithoutBias) {
  // Three quarters of 2^64: without rejection the lower third would come twice as often.
  Rng rng(11, 0, 0, 0, 0);
  const std::uint64_t n = 3ull << 62;
  std::array<int, 3> thirds{};
  const int draws = 60000;
  for (int i = 0; i < draws; ++i) {
    const std::uint64_t value = rng.below(n);
    ASSERT_LT(value, n);
    ++thirds[value >> 62];
  }
  for (const int count : thirds) EXPECT_NEAR(count, draws / 3, 600);
  EXPECT_LT(rng.below(~std::uint64_t{0}), ~std::uint64_t{0});
}

TEST(Chance, ComesTrueAsOftenAsAsked) {
  Rng rng(12, 0, 0, 0, 0);
  int count = 0;
  for (int i = 0; i < 100000; ++i) count += rng.chance(0.3) ? 1 : 0;
  EXPECT_NEAR(count, 30000, 800);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(rng.chance(0));
    EXPECT_TRUE(rng.chance(1));
  }
}

TEST(Rng, StreamOfAnotherEntityIsThatOfItsName) {
  Rng one(3, 5, 7, 11, 13);
  one.bits();
  Rng other = one.of(17), named(3, 5, 7, 11, 17);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(other.bits(), named.bits());
  Rng again = one.of(13), first(3, 5, 7, 11, 13);
  EXPECT_EQ(again.bits(), first.bits()) << "from its beginning";
}

TEST(Normal, HasTheMomentsAndTailsOfAStandardNormal) {
  Rng rng(13, 0, 0, 0, 0);
  const int n = 200000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, cross = 0;
  std::array<int, 3> beyond{};
  for (int i = 0; i < n; ++i) {
    const auto [a, b] = rng.normals();
    for (const double z : {a, b}) {
      ASSERT_TRUE(std::isfinite(z));
      m1 += z, m2 += z * z, m3 += z * z * z, m4 += z * z * z * z;
      for (int s = 1; s <= 3; ++s) beyond[static_cast<std::size_t>(s - 1)] += std::abs(z) > s;
    }
    cross += a * b;
  }
  const double count = 2.0 * n;
  EXPECT_NEAR(m1 / count, 0, 0.01);
  EXPECT_NEAR(m2 / count, 1, 0.01);
  EXPECT_NEAR(m3 / count, 0, 0.03);
  EXPECT_NEAR(m4 / count, 3, 0.06);
  EXPECT_NEAR(cross / n, 0, 0.01) << "the two of a pair are independent";
  for (int s = 1; s <= 3; ++s)
    EXPECT_NEAR(beyond[static_cast<std::size_t>(s - 1)] / count, std::erfc(s / std::sqrt(2.0)),
                0.003);
}

TEST(Normal, PairIsThatOfTheNextTwoUniforms) {
  Rng one(15, 0, 0, 0, 0), two(15, 0, 0, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double u = two.uniform(), v = two.uniform();
    EXPECT_EQ(one.normals(), Rng::normals_of(u, v));
  }
  EXPECT_EQ(Rng::normals_of(0, 0.3)[0], 0);
  EXPECT_NEAR(Rng::normals_of(1 - 0x1p-53, 0)[0], std::sqrt(2 * 53 * std::log(2.0)), 1e-12)
      << "none is farther out";
}

TEST(Normal, SingleOneIsTheFirstOfAPair) {
  Rng one(14, 0, 0, 0, 0), two(14, 0, 0, 0, 0);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(one.normal(), two.normals()[0]);
}

}  // namespace
}  // namespace somas
