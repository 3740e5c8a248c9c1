// Competition: how long an organism lived, and how much of the living matter it was meanwhile.
#pragma once

#include <string_view>

#include "somas/sdk/fitness.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::fitness {

/// score = survival_weight x steps survived + share_weight x share of biomass. An organism alone
/// has all of the biomass, so there the score orders as survival does.
class Competition final : public Fitness {
 public:
  static constexpr About about{"competition",
                               "Steps survived and share of the world's live cells, weighted"};

  struct Parameters {
    double survival_weight = 1;
    double share_weight = 1000;
    void describe(Describe& d) {
      d("survival_weight", survival_weight, "Points for a step survived",
        {.unit = "1/step", .minimum = 0, .maximum = 1e9});
      d("share_weight", share_weight,
        "Points for having all live cells of the world, averaged over its steps",
        {.minimum = 0, .maximum = 1e9});
    }
  };

  /// Throws ParameterError when both weights are 0: then everybody would be as good.
  explicit Competition(const Parameters& p) : p_(p) {
    if (p.survival_weight == 0 && p.share_weight == 0)
      throw ParameterError("share_weight",
                           "both weights are 0, so that all score alike; allowed: one above 0");
  }

  [[nodiscard]] std::string_view objective() const override { return "competition"; }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    return p_.survival_weight * static_cast<double>(outcome.survival) +
           p_.share_weight * outcome.biomass_share;
  }

 private:
  Parameters p_;
};

}  // namespace somas::fitness
