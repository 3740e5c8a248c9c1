// Those of several numbers side by side that are wanted, one behind another.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/model/lanes.hpp"

namespace somas::model {

/// For each set of eight lanes, these first.
alignas(32) inline constexpr auto lanes_first = [] {
  std::array<std::array<std::uint32_t, 8>, 256> table{};
  for (std::size_t set = 0; set < 256; ++set) {
    std::size_t to = 0;
    for (std::uint32_t lane = 0; lane < 8; ++lane)
      if ((set >> lane & 1) != 0) table[set][to++] = lane;
  }
  return table;
}();

/// Each lane gets the item of the lane that stands there in a list of eight.
inline void permute(const std::array<std::uint32_t, 8>& from, EightItems& items) {
#ifdef __AVX2__
  using Ints = int __attribute__((vector_size(32)));
  Ints lanes, values;
  std::memcpy(&lanes, from.data(), sizeof lanes);
  std::memcpy(&values, &items, sizeof values);
  values = __builtin_ia32_permvarsi256(values, lanes);
  std::memcpy(&items, &values, sizeof items);
#else
  EightItems moved{};
  for (std::size_t lane = 0; lane < 8; ++lane) moved[lane] = items[from[lane]];
  items = moved;
#endif
}

/// Moves those of eight items whose lanes are set to the front.
inline void compress(std::uint32_t set, EightItems& items) { permute(lanes_first[set], items); }

}  // namespace somas::model
