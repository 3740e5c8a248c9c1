// Returns 0 if all is well; any test framework will do as well.
#include "my_plugin.hpp"

#include <cstdio>

#include <somas/sdk/testing.hpp>

namespace {

/// A rule of this plugin: whether the cells are pushed in the step after `steps` others.
bool blows_after(int steps) {
  const somas::testing::EnvironmentStage stage(
      std::make_unique<MyPlugin>(MyPlugin::Parameters{.strength = 2, .start = 3}), {});
  const auto world = stage.world(1);
  world->begin();
  for (int i = 0; i < steps; ++i) world->advance();
  world->advance();
  for (const double force : world->pushed_x())
    if (force != 2) return false;
  return true;
}

}  // namespace

int main() {
  // The contract of environments; the wind has to blow within the steps of the check.
  auto failures = somas::testing::check_environment<MyPlugin>({.strength = 2, .start = 3});
  if (blows_after(2)) failures.push_back("the wind blows before its start");
  if (!blows_after(3)) failures.push_back("the wind does not blow at its start");

  for (const std::string& failure : failures) std::printf("%s\n", failure.c_str());
  return failures.empty() ? 0 : 1;
}
