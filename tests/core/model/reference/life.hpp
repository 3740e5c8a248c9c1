// A life in the reference: from the founders, or from any state of an engine's life, step by step.
#pragma once

#include <span>
#include <vector>

#include "core/model/simulation.hpp"
#include "tests/core/model/reference/world.hpp"

namespace somas::reference {

/// The world before step 0. The ecosystem and phenotypes must outlive it.
[[nodiscard]] World found(const model::Ecosystem& ecosystem,
                          std::span<const model::RosterEntry> roster, std::uint64_t seed);
/// The world of a simulation between two steps, which must outlive it.
[[nodiscard]] World copy_of(const model::Simulation& simulation);

/// The ten phases of docs/model.md, section 0.
void step(World& world);

/// What Simulation::hash says of such a world.
[[nodiscard]] std::uint64_t hash_of(const World& world);
/// One per roster entry, in roster order.
[[nodiscard]] std::vector<Outcome> outcomes_of(const World& world);

}  // namespace somas::reference
