// A short reference simulation. An evaluator whose processor or build gives other bits than the
// coordinator's is found out before it does any work.
#pragma once

#include <cstdint>
#include <string>

#include "core/experiment/experiment.hpp"

namespace somas::evaluation {

/// The hash of the first steps of an organism of random genes, a pure function of the experiment
/// and the number. Throws what plugins throw.
[[nodiscard]] std::string canary_hash(const experiment::Experiment& experiment,
                                      std::uint32_t number);

}  // namespace somas::evaluation
