// What a simulation declares, as the header of a recording.
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/ecosystem.hpp"
#include "core/model/world_state.hpp"
#include "core/recording/recording.hpp"

namespace somas::recording {

/// Everything but provenance, stride and whose recording it is.
[[nodiscard]] Header header_of(const model::Ecosystem& ecosystem, const model::WorldState& world);

/// Squares of a grid whose centre lies in the world.
[[nodiscard]] std::vector<std::uint32_t> squares_in_world(const Grid& grid, double radius);

}  // namespace somas::recording
