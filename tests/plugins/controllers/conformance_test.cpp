// Every bundled controller keeps the contract of the SDK.
#include <functional>
#include <ostream>
#include <string>

#include <gmock/gmock.h>

#include "somas/sdk/testing/controller.hpp"

#include "plugins/controllers/ctrnn/ctrnn.hpp"
#include "plugins/controllers/grn/grn.hpp"

namespace somas {
namespace {

struct Case {
  std::string name;
  std::function<somas::testing::Failures()> check;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

template <class C>
Case conforms(std::string name, typename C::Parameters parameters = typename C::Parameters()) {
  return {std::move(name), [=] { return somas::testing::check_controller<C>(parameters); }};
}

class ControllerConformance : public ::testing::TestWithParam<Case> {};

TEST_P(ControllerConformance, KeepsTheContract) {
  EXPECT_THAT(GetParam().check(), ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Bundled, ControllerConformance,
    ::testing::Values(conforms<grn::Grn>("grn"),
                      conforms<grn::Grn>("grn_as_printed",
                                         {.affinity = "distance", .max_edits = 12}),
                      conforms<grn::Grn>("grn_without_regulators",
                                         {.initial_regulators = 0, .max_regulators = 0}),
                      conforms<ctrnn::Ctrnn>("ctrnn"),
                      conforms<ctrnn::Ctrnn>("ctrnn_without_hidden_neurons", {.hidden = 0})),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace somas
