#include "plugins/environments/cyclic_nutrients/cyclic_nutrients.hpp"

#include <algorithm>
#include <cmath>

namespace somas::environments {

GapSchedule::GapSchedule(std::uint64_t present, double first_gap, double gap_growth,
                         std::uint64_t max_steps) {
  double gap = first_gap;
  std::uint64_t step = 0;
  // Compared by difference, since a sum could overflow.
  while (present < max_steps - step) {
    step += present;
    switches_.push_back(step);
    if (!(std::ceil(gap) < static_cast<double>(max_steps - step))) return;
    step += static_cast<std::uint64_t>(std::ceil(gap));
    switches_.push_back(step);
    gap *= gap_growth;
  }
}

bool GapSchedule::present(std::uint64_t step) const {
  const auto next = std::upper_bound(switches_.begin(), switches_.end(), step);
  return (next - switches_.begin()) % 2 == 0;
}

bool GapSchedule::returns(std::uint64_t step) const {
  return step > 0 && present(step) && !present(step - 1);
}

void CyclicNutrients::declare(Declare& declare) {
  field_.declare(declare, parameters_.patches, {Region::Shape::square, parameters_.half_side});
  schedule_ = GapSchedule(static_cast<std::uint64_t>(parameters_.present), parameters_.first_gap,
                          parameters_.gap_growth, declare.world().max_steps);
  declare.acts_in(Phase::fields);
  declare.acts_in(Phase::sense);
}

void CyclicNutrients::begin(World& world) const { field_.set(world, parameters_.patches.capacity); }

void CyclicNutrients::act(Phase phase, World& world) const {
  if (phase == Phase::sense) return field_.sense(world);
  if (!schedule_.present(world.step())) return field_.set(world, 0);
  if (schedule_.returns(world.step())) return field_.set(world, parameters_.patches.capacity);
  field_.regenerate(world);
}

}  // namespace somas::environments
