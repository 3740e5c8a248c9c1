// How long a plugin's steps take, for authors.
#pragma once

#include <span>
#include <string>

#include "core/conformance/host_world.hpp"

namespace somas::conformance {

/// "12.3 ns a cell and step, 1000 cells". Throws what the plugin throws.
[[nodiscard]] std::string time_of_environment(const Making& making, const Taps& taps);
[[nodiscard]] std::string time_of_controller(const Making& making);
[[nodiscard]] std::string time_of_specialization(const Making& making,
                                                 std::span<const SkillInfo> skills);
[[nodiscard]] std::string time_of_fitness(const Making& making);

}  // namespace somas::conformance
