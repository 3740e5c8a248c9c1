// What one core of this machine can do at most, measured here and now.
#pragma once

namespace somas::bench {

/// All per second. Operations are those of full vector registers, counted by the value.
struct Ceilings {
  double flops64 = 0, flops32 = 0;          ///< multiplications and additions, not fused
  double divisions64 = 0, divisions32 = 0;  ///< values
  double roots64 = 0, roots32 = 0;          ///< values
  double l1 = 0, l2 = 0, l3 = 0, dram = 0;  ///< bytes of a triad, a = b + s c, in arrays that fit
};

/// Each by the best of many short runs within `seconds`.
[[nodiscard]] Ceilings measure_ceilings(double seconds);

}  // namespace somas::bench
