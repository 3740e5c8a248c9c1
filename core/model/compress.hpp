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

/// Moves those of eight items whose lanes are set to the front.
inline void compress(std::uint32_t set, EightItems& items) {
  EightItems from;
  std::memcpy(&from, lanes_first[set].data(), sizeof from);
  items = __builtin_shuffle(items, from);
}

}  // namespace somas::model
