// A recurrent network compiled for batches, and one Euler step of it:
//
//   tau_i dy_i/dt = -y_i + sum_j w_ij sigma(y_j + theta_j) + sum_k v_ik I_k
//
// (Beer, "On the dynamics of small continuous-time recurrent neural networks", Adaptive Behavior 3,
// 1995), j over the hidden neurons, k over the inputs of the cell's own state.
#pragma once

#include <memory>

#include "somas/sdk/controller.hpp"

#include "plugins/controllers/ctrnn/network.hpp"

namespace somas::ctrnn {

/// Memory of a cell: y of the hidden neurons, then of the outputs in channel order. Output channels
/// receive sigma(y + theta) after the step. Precondition: the network fits the layout.
[[nodiscard]] std::unique_ptr<Program> compile(const Network& network, const Layout& layout);

}  // namespace somas::ctrnn
