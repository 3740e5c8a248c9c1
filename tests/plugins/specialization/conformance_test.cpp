// Every bundled specialization keeps the contract of the SDK.
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "somas/sdk/testing/specialization.hpp"

#include "plugins/specialization/evolved_tree/evolved_tree.hpp"
#include "plugins/specialization/tree/tree.hpp"

namespace somas::specialization {
namespace {

/// The model's own, and those of a nutrient and a hazard.
const std::vector<SkillInfo> skills = {
    {"capacity", {}},
    {"diffusion", {.fallback = 1, .minimum = 0, .maximum = 1, .cost = 0}},
    {"energy_efficiency", {.fallback = 1, .minimum = 1e-3, .cost = 0}},
    {"production", {}},
    {"resistance", {.fallback = 1, .cost = 2}},
};

struct Case {
  std::string name;
  std::function<somas::testing::Failures()> check;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

template <class S>
Case conforms(std::string name, typename S::Parameters parameters = {}) {
  return {std::move(name),
          [=] { return somas::testing::check_specialization<S>(parameters, skills); }};
}

Tree::Parameters three_states() {
  Tree::Parameters parameters;
  parameters.states.resize(3);
  parameters.states[0].name = "late";
  parameters.states[0].parent = "root";
  parameters.states[1].name = "later";
  parameters.states[1].parent = "late";
  parameters.states[1].skills = {{"production", 3}, {"diffusion", 0.5}};
  parameters.states[2].name = "root";
  parameters.budget = 9;
  return parameters;
}

class SpecializationConformance : public ::testing::TestWithParam<Case> {};

TEST_P(SpecializationConformance, KeepsTheContract) {
  EXPECT_THAT(GetParam().check(), ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Bundled, SpecializationConformance,
                         ::testing::Values(conforms<Tree>("tree", three_states()),
                                           conforms<EvolvedTree>("evolved_tree", {.budget = 9}),
                                           conforms<EvolvedTree>("evolved_tree_attributes",
                                                                 {.returns = 2.5,
                                                                  .evolve_motility = true,
                                                                  .evolve_adhesion = true,
                                                                  .evolve_thresholds = true})),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace somas::specialization
