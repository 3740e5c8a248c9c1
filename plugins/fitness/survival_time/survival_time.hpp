// Survival time: the paper's only fitness (model, section 7). An organism scores the steps it
// lived.
#pragma once

#include <string_view>

#include "somas/sdk/fitness.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::fitness {

class SurvivalTime final : public Fitness {
 public:
  static constexpr About about{"survival_time", "Steps from the start to the last cell's death"};

  struct Parameters {
    void describe(Describe&) {}
  };

  explicit SurvivalTime(const Parameters&) {}

  [[nodiscard]] std::string_view objective() const override { return "survival"; }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    return static_cast<double>(outcome.survival);
  }
};

}  // namespace somas::fitness
