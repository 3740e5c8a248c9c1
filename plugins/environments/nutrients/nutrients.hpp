// Nutrients: food that grows back, everywhere or in a region round the centre (model, section 2).
//
// Each step every patch of a grid gains `regeneration` up to `capacity`; cells eat through the
// host, at most their points in the production skill a step. Cells sense how full their patch is.
// A second type of nutrient is a second instance under another name, with a skill of its own.
#pragma once

#include <optional>
#include <string>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

#include "plugins/environments/common/nutrient_field.hpp"

namespace somas::environments {

class Nutrients final : public Environment {
 public:
  static constexpr About about{"nutrients", "Nutrients on a grid that regenerate every step"};

  struct Parameters {
    PatchParameters patches{};
    std::optional<double> initial{};
    std::string region = "everywhere";
    std::optional<double> half_side{};
    std::optional<double> radius{};

    void describe(Describe& d) {
      patches.describe(d);
      d("initial", initial, "Content of a patch at the start, at most capacity; left out: full",
        {.unit = "nutrient", .minimum = 0, .maximum = 1e9});
      d.choice("region", region, {"everywhere", "square", "disc"},
               "Where nutrients are: the patches with their centre inside, round the origin");
      d("half_side", half_side, "Half the side of the square; for region square only",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("radius", radius, "Radius of the disc; for region disc only",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d.at_most("initial", "capacity");
      d.only_when("half_side", "region", {"square"});
      d.required_when("half_side", "region", {"square"});
      d.only_when("radius", "region", {"disc"});
      d.required_when("radius", "region", {"disc"});
    }
  };

  explicit Nutrients(const Parameters& parameters);
  void declare(Declare& declare) override;
  void begin(World& world) const override;
  void act(Phase phase, World& world) const override;

 private:
  Parameters parameters_;
  NutrientField field_;
};

}  // namespace somas::environments
