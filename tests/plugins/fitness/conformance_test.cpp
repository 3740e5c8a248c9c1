// Every bundled fitness keeps the contract of the SDK.
#include <functional>
#include <ostream>
#include <string>

#include <gmock/gmock.h>

#include "somas/sdk/testing/fitness.hpp"

#include "plugins/fitness/competition/competition.hpp"
#include "plugins/fitness/survival_time/survival_time.hpp"

namespace somas::fitness {
namespace {

struct Case {
  std::string name;
  std::function<somas::testing::Failures()> check;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

template <class F>
Case conforms(std::string name, typename F::Parameters parameters = typename F::Parameters()) {
  return {std::move(name), [=] { return somas::testing::check_fitness<F>(parameters); }};
}

class FitnessConformance : public ::testing::TestWithParam<Case> {};

TEST_P(FitnessConformance, KeepsTheContract) {
  EXPECT_THAT(GetParam().check(), ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Bundled, FitnessConformance,
                         ::testing::Values(conforms<SurvivalTime>("survival_time"),
                                           conforms<Competition>("competition")),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace somas::fitness
