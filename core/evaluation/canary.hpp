// A short reference simulation. An evaluator whose processor or build gives other bits than the
// coordinator's is found out before it does any work.
#pragma once

#include <cstdint>
#include <string>

#include "core/model/ecosystem.hpp"

namespace somas::evaluation {

/// How many are tried until one neither throws nor crashes.
inline constexpr std::uint32_t most_canaries = 8;

/// The hash of the first steps of an organism of random genes, a pure function of the experiment
/// and the number. Throws what plugins throw.
[[nodiscard]] std::string canary_hash(const model::Ecosystem& ecosystem, std::uint32_t number);

}  // namespace somas::evaluation
