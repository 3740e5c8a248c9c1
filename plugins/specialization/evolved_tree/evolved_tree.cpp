#include "plugins/specialization/evolved_tree/evolved_tree.hpp"

#include <algorithm>
#include <string>

#include "plugins/common/keys.hpp"

namespace somas::specialization {

void EvolvedTree::grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const {
  const TreeGenes grown = variation_.fitting(genes);
  for (const TreeState& state : grown.states) {
    const bool root = state.parent == no_parent;
    const std::string name = root ? "root" : "s" + common::key_text(state.key);
    std::vector<double> values;
    for (const SkillInfo& skill : skills) {
      const auto at = std::ranges::find(grown.skills, stable_key(skill.name));
      values.push_back(at == grown.skills.end()
                           ? skill.spec.fallback
                           : state.points[static_cast<std::size_t>(at - grown.skills.begin())]);
    }
    tree.add({.name = name,
              .key = state.key,
              .parent = root ? no_state : static_cast<std::uint16_t>(state.parent),
              .mass = parameters_.mass,
              .radius = parameters_.radius,
              .stiffness = parameters_.stiffness,
              .adhesion = parameters_.adhesion,
              .adhesion_range = parameters_.adhesion_range,
              .skills = values});
  }
}

}  // namespace somas::specialization
