/// @file
/// The ports between cells and their controller, as the host wires them from the specialization
/// tree, the model's own signals and the environments' sensors.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "somas/sdk/types.hpp"

namespace somas {

/// No state: what the root has for a parent, and a port that belongs to none.
inline constexpr std::uint16_t no_state = 0xFFFF;

/// A state of the specialization tree as a controller sees it.
struct StateInfo {
  std::string_view name;  ///< unique within the tree
  std::uint64_t key;      ///< stable: survives changes elsewhere in the tree
  std::uint16_t parent;   ///< index of the parent, no_state for the root (always index 0)
};

/// One input or output.
struct Port {
  std::string_view name;  ///< "defensive/energy" (an input), "uptake.nutrients"
  std::uint64_t key;      ///< stable and unique among the ports of a layout, whatever the order
  std::uint32_t channel;  ///< row of Batch::in (inputs) or Batch::out (outputs)
  std::uint16_t state;    ///< inputs: the state that owns it; specialization outputs: the target
};

/// All ports of one organism. Every state has its own set of inputs (model, section 6): `inputs`
/// holds input_channels ports for state 0, then as many for state 1, and so on, each set in channel
/// order; a batch carries the channels of its own state only. Outputs are shared by all states.
/// Views into host memory, valid as long as the call, or as long as the Program made from them.
struct Layout {
  std::span<const StateInfo> states;  ///< parents before children
  std::span<const Port> inputs;       ///< states times input_channels
  std::span<const Port> outputs;      ///< in channel order
  std::uint32_t input_channels = 0;   ///< rows of Batch::in
};

}  // namespace somas
