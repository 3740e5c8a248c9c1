// What may evolve of a state beside its points.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "somas/sdk/specialization.hpp"

#include "plugins/specialization/evolved_tree/genes.hpp"
#include "plugins/specialization/evolved_tree/parameters.hpp"

namespace somas::specialization {

/// An attribute that evolves: a number in a range for each state.
struct EvolvingAttribute {
  std::string_view name;  ///< a literal
  std::uint64_t key = 0;
  double minimum = 0, maximum = 1;
  double start = 0;  ///< where evolution begins: as in a tree whose attributes do not evolve
};

/// The attributes that the parameters let evolve, by ascending key. Throws ParameterError when the
/// adhesion that all states begin with is stronger than the strongest that may evolve.
[[nodiscard]] std::vector<EvolvingAttribute> evolving_attributes(const EvolvedTreeParameters& p);

/// Sets the members of `spec` that evolve from a state's genes. Of `morphogens` signals the gene
/// in [0, 1] names one: they share the interval in equal parts.
void set_attributes(std::span<const EvolvingAttribute> attributes, const TreeState& state,
                    std::uint32_t morphogens, StateSpec& spec);

}  // namespace somas::specialization
