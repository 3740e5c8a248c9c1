// The part under examination in worlds of the host itself, beside companions.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "somas/sdk/testing/environment.hpp"

#include "core/conformance/watched.hpp"
#include "core/model/ecosystem.hpp"

namespace somas::conformance {

/// Variable parameters of other instances that an environment asks for.
using Taps = std::vector<testing::EnvironmentOptions::OfOthers>;

/// An experiment of the part and its companions. Throws what wiring throws.
[[nodiscard]] std::shared_ptr<const model::Ecosystem> wired(const Making& making, const Taps& taps);

/// Looks at lives of the part in the host: that there are any, whether the same seed gives the same
/// bytes again and beside another life, and whether a life goes on after saving and restoring.
[[nodiscard]] testing::Checks host_checks(const Making& making, const Taps& taps);

}  // namespace somas::conformance
