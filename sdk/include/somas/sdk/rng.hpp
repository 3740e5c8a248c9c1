/// @file
/// Counter-based random numbers: Philox4x64-10 (Salmon, Moraes, Dror, Shaw, "Parallel random
/// numbers: as easy as 1, 2, 3", SC11), with our own distributions, since the standard library's
/// differ between implementations. A stream is named by what it is for (seed, organism, step,
/// purpose, entity), never by thread, process or place in memory, so results do not depend on
/// scheduling.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "somas/sdk/math.hpp"

namespace somas {

/// One block of Philox4x64-10: 256 random bits for a 256-bit `counter` and a 128-bit `key`. For
/// most ends take an Rng.
[[nodiscard]] constexpr std::array<std::uint64_t, 4> philox(std::array<std::uint64_t, 4> counter,
                                                            std::array<std::uint64_t, 2> key) {
  __extension__ using Wide = unsigned __int128;
  for (int round = 0; round < 10; ++round) {
    const Wide p0 = static_cast<Wide>(0xD2E7470EE14C6C93ull) * counter[0];
    const Wide p1 = static_cast<Wide>(0xCA5A826395121157ull) * counter[2];
    counter = {
        static_cast<std::uint64_t>(p1 >> 64) ^ counter[1] ^ key[0], static_cast<std::uint64_t>(p1),
        static_cast<std::uint64_t>(p0 >> 64) ^ counter[3] ^ key[1], static_cast<std::uint64_t>(p0)};
    key[0] += 0x9E3779B97F4A7C15ull;
    key[1] += 0xBB67AE8584CAA73Bull;
  }
  return counter;
}

/// A random stream; cheap to make, a value, not shared between threads.
class Rng {
 public:
  /// The stream of (seed, organism; step, purpose, entity), from its beginning. Equal names give
  /// equal numbers. Plugins get theirs from World::rng, or are handed one.
  constexpr Rng(std::uint64_t seed, std::uint64_t organism, std::uint64_t step,
                std::uint64_t purpose, std::uint64_t entity)
      : key_{seed, organism}, counter_{0, step, purpose, entity} {}

  /// The stream of another entity and else the same name, from its beginning. Cheap, and needs no
  /// world.
  [[nodiscard]] constexpr Rng of(std::uint64_t entity) const {
    return {key_[0], key_[1], counter_[1], counter_[2], entity};
  }

  /// 64 random bits.
  constexpr std::uint64_t bits() {
    if (used_ == 4) {
      block_ = philox(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  constexpr double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  /// Uniform in [low, high).
  constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform in {0, ..., n - 1}, without bias (Lemire's multiply and reject). Precondition: n > 0.
  constexpr std::uint64_t below(std::uint64_t n) {
    __extension__ using Wide = unsigned __int128;
    Wide product = static_cast<Wide>(bits()) * n;
    if (static_cast<std::uint64_t>(product) < n) {
      const std::uint64_t reject = (0 - n) % n;
      while (static_cast<std::uint64_t>(product) < reject) product = static_cast<Wide>(bits()) * n;
    }
    return static_cast<std::uint64_t>(product >> 64);
  }

  /// True with probability p.
  constexpr bool chance(double p) { return uniform() < p; }

  /// Two independent standard normals: those of the next two uniforms.
  std::array<double, 2> normals() {
    const double u = uniform();
    return normals_of(u, uniform());
  }

  /// Two independent standard normals from two independent uniforms in [0, 1) (Box and Muller),
  /// without branches so that loops over lanes vectorise.
  [[nodiscard]] static std::array<double, 2> normals_of(double u, double v) {
    const math::SinCos angle = math::sincos(math::two_pi * v);
    const double radius = std::sqrt(-2.0 * math::log_of_normal(1.0 - u));
    return {radius * angle.cos, radius * angle.sin};
  }

  /// One standard normal; the second of the pair is dropped, so that streams stay easy to reason
  /// on.
  double normal() { return normals()[0]; }

 private:
  std::array<std::uint64_t, 2> key_;
  std::array<std::uint64_t, 4> counter_;
  std::array<std::uint64_t, 4> block_{};
  unsigned used_ = 4;
};

}  // namespace somas
