// Several numbers at a time, in one register where there is one so wide.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace somas::model {

using Two = double __attribute__((vector_size(16)));
using TwoMask = std::int64_t __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));
using FourFloats = float __attribute__((vector_size(16)));
using FourMask = std::int64_t __attribute__((vector_size(32)));
using EightFloats = float __attribute__((vector_size(32)));
using EightMask = std::int32_t __attribute__((vector_size(32)));
using FourItems = std::uint32_t __attribute__((vector_size(16)));
using EightItems = std::uint32_t __attribute__((vector_size(32)));

inline bool any(const FourMask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

/// The lanes of a mask as bits.
inline std::uint32_t bits_of(const FourMask& mask) {
#ifdef __AVX__
  Four lanes;
  std::memcpy(&lanes, &mask, sizeof lanes);
  return static_cast<std::uint32_t>(__builtin_ia32_movmskpd256(lanes));
#else
  std::uint32_t bits = 0;
  for (std::uint32_t lane = 0; lane < 4; ++lane)
    bits |= static_cast<std::uint32_t>(mask[lane] & 1) << lane;
  return bits;
#endif
}
inline std::uint32_t bits_of(const EightMask& mask) {
#ifdef __AVX__
  EightFloats lanes;
  std::memcpy(&lanes, &mask, sizeof lanes);
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps256(lanes));
#else
  std::uint32_t bits = 0;
  for (std::uint32_t lane = 0; lane < 8; ++lane)
    bits |= static_cast<std::uint32_t>(mask[lane] & 1) << lane;
  return bits;
#endif
}

inline void read(const double* from, Four& values) { std::memcpy(&values, from, sizeof values); }

inline void square_root(const Four& x, Four& root) {
  root = Four{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}

inline void transpose(const Four (&row)[4], Four (&column)[4]) {
  const Four even01 = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
  const Four odd01 = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
  const Four even23 = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
  const Four odd23 = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
  column[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  column[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  column[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  column[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
}

/// The first four doubles of four objects, as columns.
template <class Row>
void read_columns(const Row& r0, const Row& r1, const Row& r2, const Row& r3, Four (&column)[4]) {
  static_assert(sizeof(Row) >= sizeof(Four));
  Four row[4];
  std::memcpy(&row[0], &r0, sizeof(Four));
  std::memcpy(&row[1], &r1, sizeof(Four));
  std::memcpy(&row[2], &r2, sizeof(Four));
  std::memcpy(&row[3], &r3, sizeof(Four));
  transpose(row, column);
}

/// Four pairs (x, y) one after another.
inline void write_interleaved(const Four& x, const Four& y, Two* to) {
  const Four even = __builtin_shufflevector(x, y, 0, 4, 2, 6);
  const Four odd = __builtin_shufflevector(x, y, 1, 5, 3, 7);
  const Four low = __builtin_shufflevector(even, odd, 0, 1, 4, 5);
  const Four high = __builtin_shufflevector(even, odd, 2, 3, 6, 7);
  std::memcpy(to, &low, sizeof low);
  std::memcpy(to + 2, &high, sizeof high);
}

}  // namespace somas::model
