#include "core/model/springs.hpp"

#include <algorithm>

namespace somas::model {

namespace {

/// A kind: a state of an organism, which is given by its place in the world.
struct Kind {
  std::size_t organism;
  const Tree* tree;
  std::size_t index;

  [[nodiscard]] const State& state() const { return tree->states[index]; }
};

/// Of the trees of two organisms neither knows the other's states: the mean counts.
double adhesion_between(const Kind& a, const Kind& b) {
  if (a.organism == b.organism) return a.tree->adhesion_between(a.index, b.index);
  return 0.5 * (a.state().adhesion + b.state().adhesion);
}

Spring spring_between(const Kind& a, const Kind& b, Strangers strangers) {
  const bool kin = a.organism == b.organism;
  Spring spring;
  spring.stiffness = 0.5 * (a.state().stiffness + b.state().stiffness);
  spring.contact = kin || strangers.feed ? 1 : 0;
  if (!kin && !strangers.adhere) return spring;  // they collide only
  spring.adhesion = adhesion_between(a, b);
  spring.range = 0.5 * (a.state().adhesion_range + b.state().adhesion_range);
  return spring;
}

}  // namespace

void SpringTable::prepare(const WorldState& world) {
  const bool known = std::equal(
      trees_.begin(), trees_.end(), world.organisms.begin(), world.organisms.end(),
      [](const Tree* tree, const OrganismState& o) { return tree == o.phenotype->tree.get(); });
  if (!known) list(world);

  range_ = 1;
  uniform_ = true;
  const std::vector<CellRange>& ranges = world.cells.ranges;
  for (const CellRange& a : ranges) {
    for (const CellRange& b : ranges) {
      const Spring& spring = between(kind(a.organism, a.state), kind(b.organism, b.state));
      if (&a == &ranges.front() && &b == &ranges.front()) common_ = spring;
      range_ = std::max(range_, spring.range);
      uniform_ = uniform_ && spring == common_;
    }
  }
}

void SpringTable::list(const WorldState& world) {
  trees_.clear();
  first_kind_.clear();
  std::vector<Kind> all;
  for (const OrganismState& organism : world.organisms) {
    first_kind_.push_back(static_cast<std::uint32_t>(all.size()));
    const Tree* tree = organism.phenotype->tree.get();
    for (std::size_t s = 0; s < tree->states.size(); ++s) all.push_back({trees_.size(), tree, s});
    trees_.push_back(tree);
  }
  kinds_ = static_cast<std::uint32_t>(all.size());
  springs_.clear();
  for (const Kind& a : all)
    for (const Kind& b : all) springs_.push_back(spring_between(a, b, strangers_));
}

}  // namespace somas::model
