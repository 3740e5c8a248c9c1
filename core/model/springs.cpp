#include "core/model/springs.hpp"

#include <algorithm>
#include <utility>

namespace somas::model {

namespace {

Spring spring_between(const State& a, const State& b, bool kin, Strangers strangers) {
  Spring spring;
  spring.stiffness = 0.5 * (a.stiffness + b.stiffness);
  spring.contact = kin || strangers.feed ? 1 : 0;
  if (!kin && !strangers.adhere) return spring;  // they collide only
  spring.adhesion = 0.5 * (a.adhesion + b.adhesion);
  spring.range = 0.5 * (a.adhesion_range + b.adhesion_range);
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
  std::vector<std::pair<std::size_t, const State*>> all;
  for (const OrganismState& organism : world.organisms) {
    first_kind_.push_back(static_cast<std::uint32_t>(all.size()));
    for (const State& state : organism.phenotype->tree->states)
      all.emplace_back(trees_.size(), &state);
    trees_.push_back(organism.phenotype->tree.get());
  }
  kinds_ = static_cast<std::uint32_t>(all.size());
  springs_.clear();
  for (const auto& [organism_a, a] : all)
    for (const auto& [organism_b, b] : all)
      springs_.push_back(spring_between(*a, *b, organism_a == organism_b, strangers_));
}

}  // namespace somas::model
