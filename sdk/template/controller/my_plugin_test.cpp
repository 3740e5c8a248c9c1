// Returns 0 if all is well; any test framework will do as well.
#include "my_plugin.hpp"

#include <cstdio>

#include <somas/sdk/testing.hpp>

namespace {

/// The only output of one cell with two inputs, for weights of 0.5 and inputs of 1.
float output_of_ones() {
  const somas::testing::PortTable ports({"root"}, {"energy", "pressure"}, {"division"});
  const somas::Layout layout = ports.layout();
  const std::uint64_t output = layout.outputs[0].key;
  Weights weights{{{output, 0}, 0.5f}};
  for (const somas::Port& input : layout.inputs) weights[{output, input.key}] = 0.5f;

  const std::array<float, 2> in{1, 1};
  float out = 0;
  somas::Batch batch;
  batch.count = 1;
  batch.in = {in.data(), 2, 1, 1};
  batch.out = {&out, 1, 1, 1};
  LinearProgram(weights, layout).step(batch);
  return out;
}

}  // namespace

int main() {
  // The contract of controllers, and the laws of their genes.
  auto failures = somas::testing::check_controller<MyPlugin>({});

  // A rule of this one.
  if (output_of_ones() != 1.5f) failures.push_back("the sum is wrong");

  for (const std::string& failure : failures) std::printf("%s\n", failure.c_str());
  return failures.empty() ? 0 : 1;
}
