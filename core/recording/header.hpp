// What a simulation declares, as the header of a recording.
#pragma once

#include "core/model/ecosystem.hpp"
#include "core/model/world_state.hpp"
#include "core/recording/recording.hpp"

namespace somas::recording {

/// Everything but provenance, stride and whose recording it is.
[[nodiscard]] Header header_of(const model::Ecosystem& ecosystem, const model::WorldState& world);

}  // namespace somas::recording
