// Two nutrients, each of which grows out of what was eaten of the other (cross-feeding).
//
// In every patch of a grid, once a step, with e the amount that cells took up since the last step:
//
//   A <- min(capacity, A + yield e_B + regeneration)
//   B <- min(capacity, B + yield e_A + regeneration)
//
// Cells take up each of them by a skill of its own. A body that eats one of them only has the
// regeneration to live on; one that eats both has the yield of its own meals besides. What exceeds
// the capacity is lost.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

class TwoNutrients final : public Environment {
 public:
  static constexpr About about{"two_nutrients",
                               "Two nutrients, each growing out of what was eaten of the other"};

  struct Parameters {
    double capacity = 2;
    std::optional<double> initial{};
    double yield = 0.9;
    double regeneration = 0.01;
    std::int64_t resolution = 64;
    double side = 2;
    std::string skill_a = "production_a";
    std::string skill_b = "production_b";

    void describe(Describe& d) {
      d("capacity", capacity, "Most that a patch holds of either nutrient",
        {.unit = "nutrient", .minimum = 1e-9, .maximum = 1e9});
      d("initial", initial, "Content of a patch at the start, at most capacity; left out: full",
        {.unit = "nutrient", .minimum = 0, .maximum = 1e9});
      d("yield", yield, "Part of what was eaten of one that comes back as the other",
        {.minimum = 0, .maximum = 1});
      d("regeneration", regeneration, "What grows of either in a patch by itself",
        {.unit = "nutrient/step", .minimum = 0, .maximum = 1e9});
      d("resolution", resolution, "Patches along an edge of the grid",
        {.unit = "patches", .minimum = 1, .maximum = 1024});
      d("side", side, "Edge of a patch", {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("skill_a", skill_a, "Skill that limits how much of the first a cell takes up in a step");
      d("skill_b", skill_b, "The same of the second; must be another skill");
      d.at_most("initial", "capacity");
      d.differs("skill_a", "skill_b");
    }
  };

  /// Throws ParameterError for an initial content above the capacity.
  explicit TwoNutrients(const Parameters& parameters);
  /// Resources and sensors are named like the instance, with "_a" and "_b" behind.
  void declare(Declare& declare) override;
  void act(Phase phase, World& world) const override;

 private:
  /// One of the two.
  struct Nutrient {
    Id content = no_id;  ///< grid
    Id before = no_id;   ///< grid: the content when we last left it
    Id sensor = no_id;
  };
  void grow(World& world) const;
  void sense(World& world) const;

  Parameters parameters_;
  std::array<Nutrient, 2> nutrients_;
  Id regeneration_ = no_id;
};

}  // namespace somas::environments
