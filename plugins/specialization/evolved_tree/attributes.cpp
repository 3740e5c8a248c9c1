#include "plugins/specialization/evolved_tree/attributes.hpp"

#include <algorithm>
#include <string>

namespace somas::specialization {

namespace {

constexpr std::string_view signal_name = "motility_signal";

/// The member of a state that an attribute sets; null for the signal, which is no double.
double* member_of(StateSpec& spec, std::string_view name) {
  if (name == "motility") return &spec.motility;
  if (name == "adhesion") return &spec.adhesion;
  if (name == "quiescence_threshold") return &spec.quiescence_threshold;
  if (name == "division_threshold") return &spec.division_threshold;
  if (name == "specialization_threshold") return &spec.specialization_threshold;
  if (name == "apoptosis_threshold") return &spec.apoptosis_threshold;
  return nullptr;
}

std::uint32_t signal_of(double gene, std::uint32_t morphogens) {
  if (morphogens == 0) return 0;
  const double place = gene * morphogens;
  return place >= morphogens ? morphogens - 1 : static_cast<std::uint32_t>(place);
}

}  // namespace

std::vector<EvolvingAttribute> evolving_attributes(const EvolvedTreeParameters& p) {
  std::vector<EvolvingAttribute> all;
  const auto add = [&](std::string_view name, double minimum, double maximum, double start) {
    all.push_back({name, stable_key(name), minimum, maximum, start});
  };
  if (p.evolve_motility) {
    add("motility", -p.max_motility, p.max_motility, 0);
    add(signal_name, 0, 1, 0);
  }
  if (p.evolve_adhesion) {
    if (p.adhesion > p.max_adhesion)
      throw ParameterError("max_adhesion", "`adhesion`, with which all states begin, is greater");
    add("adhesion", 0, p.max_adhesion, p.adhesion);
  }
  if (p.evolve_thresholds)
    for (const std::string_view name : {"quiescence_threshold", "division_threshold",
                                        "specialization_threshold", "apoptosis_threshold"})
      add(name, 0, 1, 0);
  std::ranges::sort(all, {}, &EvolvingAttribute::key);
  return all;
}

void set_attributes(std::span<const EvolvingAttribute> attributes, const TreeState& state,
                    std::uint32_t morphogens, StateSpec& spec) {
  for (std::size_t k = 0; k < attributes.size(); ++k) {
    const double gene = state.attributes[k];
    if (attributes[k].name == signal_name)
      spec.motility_signal = signal_of(gene, morphogens);
    else
      *member_of(spec, attributes[k].name) = gene;
  }
  // Where there are no signals nothing can be followed.
  if (morphogens == 0) spec.motility = 0;
}

}  // namespace somas::specialization
