// Values that the compiler must not know.
#pragma once

namespace somas::bench {

/// `value`, read from memory: no more can be worked out before the program runs. DoNotOptimize of
/// a scalar is not enough: with GCC the scalar may be anything afterwards (Google Benchmark 1.7.1
/// lets the compiler take its memory for the result and a register for the value).
template <class Scalar>
[[nodiscard]] Scalar unknown(Scalar value) {
  volatile const Scalar stored = value;
  return stored;
}

}  // namespace somas::bench
