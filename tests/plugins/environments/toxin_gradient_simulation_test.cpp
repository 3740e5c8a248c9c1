// The toxin gradient in a whole simulation.
#include <gtest/gtest.h>

#include "plugins/environments/toxin_gradient/toxin_gradient.hpp"
#include "tests/plugins/environments/resting_life.hpp"

namespace somas::environments {
namespace {

TEST(ToxinGradientSimulation, KillsInTheStepInWhichTheAbsorbedDoseExceedsTheResistance) {
  // Nothing spreads or decays: the founder's square holds t + 1 in step t, so that the doses
  // absorbed by then are 1, 3, 6, 10, 15, ...
  ToxinGradient::Parameters toxin;
  toxin.diffusion = 0;
  toxin.decay = 0;
  toxin.toxicity = 1;
  toxin.sources.push_back({.x = 0, .y = 0, .rate = 4});
  const auto last_step = [&](double resistance) {
    return live({named<ToxinGradient>("toxin", toxin)},
                {{"capacity", 10}, {"toxin_resistance", resistance}})
        .outcome.survival;
  };
  EXPECT_EQ(last_step(0), 0u);
  EXPECT_EQ(last_step(5.5), 2u);
  EXPECT_EQ(last_step(9.5), 3u);
  EXPECT_EQ(last_step(10), 4u);
  EXPECT_EQ(last_step(14.5), 4u);
}

}  // namespace
}  // namespace somas::environments
