/// @file
/// Elementary functions for code that bears results: built from + - * / and sqrt alone, so that the
/// same bits come out on every CPU (glibc picks other kernels on other CPUs). Accuracy: within 2
/// ulp on the stated domains, tested against the C library in extended precision.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

/// Elementary functions with the same bits on every CPU.
namespace somas::math {

/// Half a turn.
inline constexpr double pi = 3.14159265358979323846;
/// A turn.
inline constexpr double two_pi = 6.28318530717958647692;

namespace detail {

inline constexpr double ln2_high = 0x1.62e42fefa3800p-1;  // 42 bits: k * ln2_high is exact
inline constexpr double ln2_low = 0x1.ef35793c76730p-45;

/// Added to |x| < 2^51 it leaves the nearest integer, ties to even, in the lowest bits.
inline constexpr double magic = 0x1.8p52;

/// Nearest integer, ties to even, for |x| < 2^51.
[[nodiscard]] inline double round_even(double x) { return (x + magic) - magic; }

/// 2^k for -1022 <= k <= 1023.
[[nodiscard]] inline double power_of_two(std::int64_t k) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52);
}

/// Natural logarithm of 2^more x, x positive and normal.
[[nodiscard]] inline double log_of_normal(double x, double more) {
  // x = 2^k m, m in [sqrt(1/2), sqrt(2)); log m = 2 artanh(s), s = (m - 1) / (m + 1).
  const auto bits = std::bit_cast<std::uint64_t>(x);
  double m = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
  const bool above = m > 1.4142135623730951;
  m = above ? 0.5 * m : m;
  // The exponent as the lowest bits of 2^52.
  const double exponent = std::bit_cast<double>((bits >> 52) | 0x4330000000000000ull);
  const double k = (exponent - (0x1p52 + 1023)) + (above ? more + 1.0 : more);
  const double f = m - 1.0;
  const double s = f / (m + 1.0);
  const double z = s * s;
  double p = 1.0 / 23.0;
  p = p * z + 1.0 / 21.0;
  p = p * z + 1.0 / 19.0;
  p = p * z + 1.0 / 17.0;
  p = p * z + 1.0 / 15.0;
  p = p * z + 1.0 / 13.0;
  p = p * z + 1.0 / 11.0;
  p = p * z + 1.0 / 9.0;
  p = p * z + 1.0 / 7.0;
  p = p * z + 1.0 / 5.0;
  p = p * z + 1.0 / 3.0;
  // 2 artanh(s) = f - s (f - 2 z s^0 p ...) rearranged so that the leading term f is exact.
  const double half_square = 0.5 * f * f;
  const double tail = s * (half_square + 2.0 * z * p);
  return k * ln2_high - ((half_square - (tail + k * ln2_low)) - f);
}

}  // namespace detail

/// e^x. Overflows to infinity above 709.78, is 0 below -708.
[[nodiscard]] inline double exp(double x) {
  if (!(x == x)) return x;
  if (x > 709.782712893384) return std::numeric_limits<double>::infinity();
  if (x < -708.0) return 0.0;
  // x = k ln 2 + r, |r| <= ln 2 / 2; e^r by its Taylor polynomial of degree 13.
  const double k = detail::round_even(x * 1.4426950408889634);
  const double r = (x - k * detail::ln2_high) - k * detail::ln2_low;
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  const double e = 1.0 + (r + r * r * p);
  // 2^1024 is no double: scale in two steps.
  const auto n = static_cast<std::int64_t>(k);
  return e * detail::power_of_two(n / 2) * detail::power_of_two(n - n / 2);
}

/// Natural logarithm of a positive normal x < infinity, without branches so that loops over lanes
/// vectorise.
[[nodiscard]] inline double log_of_normal(double x) { return detail::log_of_normal(x, 0); }

/// Natural logarithm of x > 0; -infinity at 0, NaN below.
[[nodiscard]] inline double log(double x) {
  if (!(x >= 0)) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0) return -std::numeric_limits<double>::infinity();
  if (x == std::numeric_limits<double>::infinity()) return x;
  const bool normal = x >= std::numeric_limits<double>::min();
  return normal ? detail::log_of_normal(x, 0) : detail::log_of_normal(x * 0x1p54, -54);
}

/// Both of one angle.
struct SinCos {
  double sin;  ///< of the angle
  double cos;  ///< of the angle
};

/// Sine and cosine of x, |x| <= 1e6, without branches so that loops over lanes vectorise.
[[nodiscard]] inline SinCos sincos(double x) {
  // x = q pi/2 + r, pi/2 in three parts (Cody and Waite), r as a sum r + t of two doubles; then
  // Taylor polynomials on |r| <= pi/4, corrected by the derivative for t.
  const double shifted = x * 0.6366197723675814 + detail::magic;
  const double q = shifted - detail::magic;
  const double coarse = x - q * 0x1.921fb54400000p+0;
  const double fine = q * 0x1.0b4611a600000p-34;
  const double difference = coarse - fine;
  const double rest = ((coarse - difference) - fine) - q * 0x1.3198a2e037073p-69;
  const double r = difference + rest;
  const double t = (difference - r) + rest;
  const double z = r * r;
  double s = -1.0 / 1307674368000.0;
  s = s * z + 1.0 / 6227020800.0;
  s = s * z - 1.0 / 39916800.0;
  s = s * z + 1.0 / 362880.0;
  s = s * z - 1.0 / 5040.0;
  s = s * z + 1.0 / 120.0;
  s = s * z - 1.0 / 6.0;
  const double sine = r + (r * z * s + t * (1.0 - 0.5 * z));
  double c = 1.0 / 20922789888000.0;
  c = c * z - 1.0 / 87178291200.0;
  c = c * z + 1.0 / 479001600.0;
  c = c * z - 1.0 / 3628800.0;
  c = c * z + 1.0 / 40320.0;
  c = c * z - 1.0 / 720.0;
  c = c * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  const double lead = 1.0 - half;
  const double cosine = lead + (((1.0 - lead) - half) + (z * z * c - r * t));
  // The quarter turn, in the lowest bits, chooses which is which and the signs.
  const auto quarter = std::bit_cast<std::uint64_t>(shifted);
  const bool swap = (quarter & 1) != 0;
  const double a = swap ? cosine : sine, b = swap ? sine : cosine;
  const bool lower = (quarter & 2) != 0, left = ((quarter + 1) & 2) != 0;
  return {lower ? -a : a, left ? -b : b};
}

/// 1 / (1 + e^-x) in single precision, without branches so that loops over lanes vectorise.
/// Saturates exactly at |x| >= 30. Relative error below 1e-6.
[[nodiscard]] inline float logistic(float x) {
  const float a = x < -30.0f ? 30.0f : (x > 30.0f ? -30.0f : -x);
  constexpr float magic = 0x1.8p23f;
  const float k = (a * 1.44269504f + magic) - magic;
  const float r = (a - k * 0x1.62e400p-1f) - k * 0x1.7f7d1cp-20f;
  float p = 1.0f / 5040.0f;
  p = p * r + 1.0f / 720.0f;
  p = p * r + 1.0f / 120.0f;
  p = p * r + 1.0f / 24.0f;
  p = p * r + 1.0f / 6.0f;
  p = p * r + 0.5f;
  const float e = 1.0f + (r + r * r * p);
  const auto scale = std::bit_cast<float>((static_cast<std::int32_t>(k) + 127) << 23);
  return 1.0f / (1.0f + e * scale);
}

}  // namespace somas::math
