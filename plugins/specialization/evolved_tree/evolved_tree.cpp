#include "plugins/specialization/evolved_tree/evolved_tree.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "plugins/common/keys.hpp"

namespace somas::specialization {

std::vector<double> EvolvedTree::values_of(const TreeState& state,
                                           std::span<const SkillInfo> skills) const {
  const std::span<const EvolvingSkill> evolving = variation_.skills();
  std::vector<double> values;
  for (const SkillInfo& skill : skills) {
    const auto at = std::ranges::find(evolving, skill.name, &EvolvingSkill::name);
    const auto k = static_cast<std::size_t>(at - evolving.begin());
    values.push_back(at == evolving.end() ? skill.spec.fallback
                                          : variation_.bought(k, state.points[k]));
  }
  return values;
}

void EvolvedTree::grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const {
  const TreeGenes grown = variation_.fitting(genes);
  for (std::size_t s = 0; s < grown.states.size(); ++s) {
    const TreeState& state = grown.states[s];
    const bool root = state.parent == no_parent;
    const std::string name = root ? "root" : "s" + common::key_text(state.key);
    const std::vector<double> values = values_of(state, skills);
    constexpr double mean_of_both = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> adhesion_with;
    for (std::size_t other = 0; other < s && !grown.pairs.empty(); ++other)
      adhesion_with.push_back(
          grown.adhesion(state.key, grown.states[other].key).value_or(mean_of_both));
    StateSpec spec{.name = name,
                   .key = state.key,
                   .parent = root ? no_state : static_cast<std::uint16_t>(state.parent),
                   .mass = parameters_.mass,
                   .radius = parameters_.radius,
                   .stiffness = parameters_.stiffness,
                   .adhesion = parameters_.adhesion,
                   .adhesion_range = parameters_.adhesion_range,
                   .skills = values,
                   .adhesion_with = adhesion_with};
    set_attributes(variation_.attributes(), state, tree.morphogens(), spec);
    tree.add(spec);
  }
}

}  // namespace somas::specialization
