// Cyclic nutrients: food in a centred square that comes and goes, the gaps growing (model, section
// 8, experiment 2).
//
// Present for `present` steps from step 0, absent for ceil(first_gap * gap_growth^n) steps, present
// again, and so on, n = 0, 1, ... counting the gaps. Absent means empty; on return every patch is
// full; while present it regenerates like `nutrients`. Presence depends on the step alone.
#pragma once

#include <cstdint>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

#include "plugins/environments/common/nutrient_field.hpp"

namespace somas::environments {

/// The steps at which nutrients vanish and return.
class GapSchedule {
 public:
  GapSchedule() = default;
  /// Lists the switches before `max_steps`. The gaps come from repeated multiplication: the same
  /// bits on every CPU, which a library's pow does not promise.
  GapSchedule(std::uint64_t present, double first_gap, double gap_growth, std::uint64_t max_steps);

  [[nodiscard]] bool present(std::uint64_t step) const;
  /// Whether `step` is the first one after a gap.
  [[nodiscard]] bool returns(std::uint64_t step) const;
  /// Ascending: vanish, return, vanish, ...
  [[nodiscard]] const std::vector<std::uint64_t>& switches() const { return switches_; }

 private:
  std::vector<std::uint64_t> switches_;
};

class CyclicNutrients final : public Environment {
 public:
  static constexpr About about{"cyclic_nutrients",
                               "Nutrients in a centred square that come and go, the gaps growing"};

  struct Parameters {
    PatchParameters patches{};
    double half_side = 12;
    std::int64_t present = 60;
    double first_gap = 5;
    double gap_growth = 1.25;

    void describe(Describe& d) {
      patches.describe(d);
      d("half_side", half_side,
        "Half the side of the square round the origin: patches with their centre inside belong",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("present", present, "How long nutrients are present each time",
        {.unit = "steps", .minimum = 1, .maximum = 1e9});
      d("first_gap", first_gap, "Length of the first gap; gaps are rounded up to whole steps",
        {.unit = "steps", .minimum = 1e-9, .maximum = 1e9});
      d("gap_growth", gap_growth, "Length of a gap over the one before, before rounding",
        {.minimum = 1, .maximum = 1e6});
    }
  };

  explicit CyclicNutrients(const Parameters& parameters) : parameters_(parameters) {}
  void declare(Declare& declare) override;
  void begin(World& world) const override;
  void act(Phase phase, World& world) const override;

 private:
  Parameters parameters_;
  NutrientField field_;
  GapSchedule schedule_;
};

}  // namespace somas::environments
