// Elementary functions against the C library's in extended precision.
#include "somas/sdk/math.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace somas {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Distance from the exact value in units of the last place of its double.
double ulps(double value, long double exact) {
  const double nearest = std::abs(static_cast<double>(exact));
  const double unit = std::nextafter(nearest, infinity) - nearest;
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact) / unit);
}

class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

TEST(Exp, IsWithinTwoUlp) {
  Uniform draw(1);
  double worst = 0;
  for (int i = 0; i < 300000; ++i) {
    const double x = i % 3 == 0 ? draw(-707.9, 709.7) : i % 3 == 1 ? draw(-20, 20) : draw(-1, 1);
    worst = std::max(worst, ulps(math::exp(x), std::exp(static_cast<long double>(x))));
  }
  EXPECT_LE(worst, 2);
  for (double x = 1e-300; x < 1; x *= 7)
    for (const double y : {x, -x})
      EXPECT_LE(ulps(math::exp(y), std::exp(static_cast<long double>(y))), 2) << y;
  for (const double x : {709.7, 709.78, 709.782712893384, -707.99, -708.0})
    EXPECT_LE(ulps(math::exp(x), std::exp(static_cast<long double>(x))), 2) << x;
}

TEST(Exp, TakesSpecialValues) {
  EXPECT_EQ(math::exp(0), 1);
  EXPECT_EQ(math::exp(-0.0), 1);
  EXPECT_EQ(math::exp(infinity), infinity);
  EXPECT_EQ(math::exp(710), infinity);
  EXPECT_EQ(math::exp(-infinity), 0);
  EXPECT_EQ(math::exp(-709), 0);
  EXPECT_TRUE(std::isnan(math::exp(nan)));
}

TEST(Exp, NeverFallsWhereItsArgumentRises) {
  for (const double start : {-700.0, -1.0, 0.34657359, 5.0, 700.0}) {
    double x = start, before = math::exp(x);
    for (int i = 0; i < 2000; ++i) {
      x = std::nextafter(x, infinity);
      const double now = math::exp(x);
      ASSERT_GE(now, before * (1 - 1e-15));
      before = now;
    }
  }
}

TEST(Log, IsWithinTwoUlp) {
  Uniform draw(2);
  double worst = 0;
  for (int i = 0; i < 300000; ++i) {
    const double x = i % 3 == 0   ? std::exp(draw(-708, 709))
                     : i % 3 == 1 ? draw(0.5, 2)
                                  : 1 + std::ldexp(draw(-1, 1), -static_cast<int>(draw(1, 50)));
    if (x == 1) continue;
    worst = std::max(worst, ulps(math::log(x), std::log(static_cast<long double>(x))));
  }
  EXPECT_LE(worst, 2);
  for (const double x :
       {1.4142135623730950, 1.4142135623730951, 1.4142135623730954, 0.7071067811865476,
        std::numeric_limits<double>::min(), std::numeric_limits<double>::max(), 5e-324, 1e-310})
    EXPECT_LE(ulps(math::log(x), std::log(static_cast<long double>(x))), 2) << x;
}

TEST(Log, OfNormalNumbersNeedsNoBranch) {
  Uniform draw(21);
  for (int i = 0; i < 100000; ++i) {
    const double x = i % 2 == 0 ? std::exp(draw(-708, 709)) : 1 - draw(0, 1);
    ASSERT_EQ(math::log_of_normal(x), math::log(x)) << x;
  }
  for (const double x : {1.0, std::numeric_limits<double>::min(),
                         std::numeric_limits<double>::max(), 0x1p-53, 1 - 0x1p-53})
    EXPECT_EQ(math::log_of_normal(x), math::log(x)) << x;
}

TEST(Log, TakesSpecialValues) {
  EXPECT_EQ(math::log(1), 0);
  EXPECT_EQ(math::log(0), -infinity);
  EXPECT_EQ(math::log(-0.0), -infinity);
  EXPECT_EQ(math::log(infinity), infinity);
  EXPECT_TRUE(std::isnan(math::log(-1)));
  EXPECT_TRUE(std::isnan(math::log(-infinity)));
  EXPECT_TRUE(std::isnan(math::log(nan)));
}

TEST(SinCos, IsWithinTwoUlp) {
  Uniform draw(3);
  double worst = 0;
  for (int i = 0; i < 300000; ++i) {
    const double x = i % 3 == 0 ? draw(-1e6, 1e6) : i % 3 == 1 ? draw(-10, 10) : draw(-0.8, 0.8);
    const math::SinCos sc = math::sincos(x);
    worst = std::max(worst, ulps(sc.sin, std::sin(static_cast<long double>(x))));
    worst = std::max(worst, ulps(sc.cos, std::cos(static_cast<long double>(x))));
  }
  EXPECT_LE(worst, 2);
}

TEST(SinCos, IsWithinTwoUlpNextToItsZeros) {
  // The doubles nearest to multiples of pi / 2, where the reduced argument is smallest.
  const long double half_pi = std::acos(-1.0L) / 2;
  double worst = 0, at = 0;
  for (std::int64_t q = 1; q <= 636619; ++q) {
    const auto x = static_cast<double>(static_cast<long double>(q) * half_pi);
    const math::SinCos sc = math::sincos(x);
    const bool sine = q % 2 == 0;
    const double error = sine ? ulps(sc.sin, std::sin(static_cast<long double>(x)))
                              : ulps(sc.cos, std::cos(static_cast<long double>(x)));
    if (error > worst) worst = error, at = x;
  }
  EXPECT_LE(worst, 2) << "at " << at;
}

TEST(SinCos, TakesSpecialValues) {
  EXPECT_EQ(math::sincos(0).sin, 0);
  EXPECT_EQ(math::sincos(0).cos, 1);
  EXPECT_NEAR(math::sincos(math::pi).sin, 1.2246467991473532e-16, 1e-25);
  EXPECT_EQ(math::sincos(math::pi).cos, -1);
  for (double x = 1e-300; x < 1e-9; x *= 11) {
    EXPECT_EQ(math::sincos(x).sin, x);
    EXPECT_EQ(math::sincos(-x).sin, -x);
  }
}

TEST(SinCos, IsOddAndEven) {
  Uniform draw(4);
  for (int i = 0; i < 20000; ++i) {
    const double x = draw(-1e4, 1e4);
    EXPECT_EQ(math::sincos(-x).sin, -math::sincos(x).sin);
    EXPECT_EQ(math::sincos(-x).cos, math::sincos(x).cos);
  }
}

TEST(Logistic, IsWithinAMillionth) {
  double worst = 0;
  for (double x = -30; x <= 30; x += 0.00037) {
    const auto argument = static_cast<float>(x);
    const long double exact = 1 / (1 + std::exp(-static_cast<long double>(argument)));
    worst =
        std::max(worst, static_cast<double>(std::abs(math::logistic(argument) - exact) / exact));
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(Logistic, SaturatesBeyondThirty) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(math::logistic(0), 0.5f);
  EXPECT_EQ(math::logistic(30), 1.0f);
  for (const float x : {31.0f, 1e3f, 1e38f, inf}) {
    EXPECT_EQ(math::logistic(x), math::logistic(30));
    EXPECT_EQ(math::logistic(-x), math::logistic(-30));
  }
  EXPECT_GT(math::logistic(-30), 0);
  EXPECT_LT(math::logistic(-30), 1e-12f);
}

TEST(Constants, AreTheNearestDoubles) {
  EXPECT_EQ(math::pi, static_cast<double>(std::acos(-1.0L)));
  EXPECT_EQ(math::two_pi, static_cast<double>(2 * std::acos(-1.0L)));
}

}  // namespace
}  // namespace somas
