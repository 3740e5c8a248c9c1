#include "plugins/environments/two_nutrients/two_nutrients.hpp"

#include <algorithm>

namespace somas::environments {

TwoNutrients::TwoNutrients(const Parameters& parameters) : parameters_(parameters) {
  if (parameters.initial && *parameters.initial > parameters.capacity)
    throw ParameterError("initial", "'initial' is more than 'capacity'");
  if (parameters.skill_a == parameters.skill_b)
    throw ParameterError("skill_b", "'skill_a' and 'skill_b' must be two skills");
}

void TwoNutrients::declare(Declare& declare) {
  GridSpec spec;
  spec.columns = spec.rows = static_cast<std::uint32_t>(parameters_.resolution);
  spec.side = parameters_.side;
  spec.left = spec.bottom = -0.5 * parameters_.side * static_cast<double>(parameters_.resolution);
  spec.initial = parameters_.initial.value_or(parameters_.capacity);

  const std::string skills[] = {parameters_.skill_a, parameters_.skill_b};
  for (std::size_t n = 0; n < 2; ++n) {
    const std::string letter = n == 0 ? "a" : "b";
    const std::string name = std::string(declare.instance()) + "_" + letter;
    Nutrient& nutrient = nutrients_[n];
    nutrient.content = declare.grid(letter, spec);
    nutrient.before = declare.grid(letter + "_before", spec);
    nutrient.sensor = declare.sensor(name);
    declare.resource(name, nutrient.content, declare.skill(skills[n], {}));
  }
  regeneration_ =
      declare.parameter("regeneration", {.value = parameters_.regeneration, .minimum = 0});
  declare.acts_in(Phase::fields);
  declare.acts_in(Phase::sense);
}

void TwoNutrients::act(Phase phase, World& world) const {
  if (phase == Phase::fields) grow(world);
  if (phase == Phase::sense) sense(world);
}

void TwoNutrients::grow(World& world) const {
  const Grid a = world.grid(nutrients_[0].content), b = world.grid(nutrients_[1].content);
  const Grid a_before = world.grid(nutrients_[0].before);
  const Grid b_before = world.grid(nutrients_[1].before);
  const double growth = world.parameter(regeneration_);
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double eaten_a = a_before.values[i] - a.values[i];
    const double eaten_b = b_before.values[i] - b.values[i];
    a.values[i] =
        std::min(parameters_.capacity, a.values[i] + parameters_.yield * eaten_b + growth);
    b.values[i] =
        std::min(parameters_.capacity, b.values[i] + parameters_.yield * eaten_a + growth);
    a_before.values[i] = a.values[i];
    b_before.values[i] = b.values[i];
  }
}

void TwoNutrients::sense(World& world) const {
  const Cells& cells = world.cells();
  for (const Nutrient& nutrient : nutrients_) {
    const Grid grid = world.grid(nutrient.content);
    const std::span<float> sensed = world.sensor(nutrient.sensor);
    for (std::uint32_t i = 0; i < cells.count; ++i) {
      const std::int64_t patch = grid.index_of(cells.x[i], cells.y[i]);
      sensed[i] = patch < 0 ? 0.0f : static_cast<float>(grid.values[patch] / parameters_.capacity);
    }
  }
}

}  // namespace somas::environments
