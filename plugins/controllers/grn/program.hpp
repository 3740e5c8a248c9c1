// A gene regulatory network compiled to weights, and one step of it over many cells
// (docs/model.md section 6).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "somas/sdk/controller.hpp"

#include "plugins/controllers/grn/network.hpp"

namespace somas::grn {

enum class Affinity {
  proximity,  ///< u = 1 - |tag - id|: equal tags attract
  distance,   ///< u = |tag - id|: as the paper prints it
};

/// Memory of a cell: the clamped concentrations of the outputs in channel order, then of the
/// regulators in genome order. Output channels receive the unclamped concentrations.
/// Throws std::runtime_error when the layout has more input channels than a step can hold.
/// Precondition: the network fits the layout.
[[nodiscard]] std::unique_ptr<Program> compile(const Network& network, const Layout& layout,
                                               Affinity affinity);

}  // namespace somas::grn
