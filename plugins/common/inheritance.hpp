// Where the genes of a layout's ports come from when the genes at hand are of another layout.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "plugins/common/keys.hpp"

namespace somas::common {

/// For each port of a layout, in ascending order of keys, its place among some genes' keys.
using Places = std::vector<std::optional<std::size_t>>;

/// The place of an input among `known`. An input of a state that is unknown there takes over from
/// the same input of the nearest state above that is known, so that cells of a new state are at
/// first governed as those that they came from.
[[nodiscard]] inline std::optional<std::size_t> find_input(const Layout& layout, const Port& port,
                                                           std::span<const std::uint64_t> known) {
  const Port* wanted = &port;
  while (wanted != nullptr) {
    if (const auto at = find_key(known, wanted->key)) return at;
    if (wanted->state >= layout.states.size()) return std::nullopt;
    const std::uint16_t above = layout.states[wanted->state].parent;
    const auto same = std::ranges::find_if(layout.inputs, [&](const Port& other) {
      return other.state == above && other.channel == port.channel;
    });
    wanted = above != no_state && same != layout.inputs.end() ? &*same : nullptr;
  }
  return std::nullopt;
}

/// find_input for all inputs.
[[nodiscard]] inline Places places_of_inputs(const Layout& layout,
                                             std::span<const std::uint64_t> known) {
  std::vector<std::pair<std::uint64_t, std::optional<std::size_t>>> found;
  found.reserve(layout.inputs.size());
  for (const Port& port : layout.inputs)
    found.emplace_back(port.key, find_input(layout, port, known));
  std::sort(found.begin(), found.end());
  Places places;
  places.reserve(found.size());
  for (const auto& [key, place] : found) places.push_back(place);
  return places;
}

/// The places of the outputs.
[[nodiscard]] inline Places places_of_outputs(const Layout& layout,
                                              std::span<const std::uint64_t> known) {
  Places places;
  places.reserve(layout.outputs.size());
  for (const std::uint64_t key : sorted_keys(layout.outputs))
    places.push_back(find_key(known, key));
  return places;
}

}  // namespace somas::common
