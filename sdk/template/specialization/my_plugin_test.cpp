// Returns 0 if all is well; any test framework will do as well.
#include "my_plugin.hpp"

#include <array>
#include <cstdio>

#include <somas/sdk/testing.hpp>

int main() {
  const std::array<somas::SkillInfo, 2> skills{{{"production", {}}, {"diffusion", {.maximum = 1}}}};

  // The contract of trees.
  auto failures = somas::testing::check_specialization<MyPlugin>({}, skills);

  // A rule of this one: a state for each skill, and the generalist.
  somas::testing::TestTreeSink tree(skills);
  MyPlugin({.common = 1, .best = 5}).grow({}, skills, tree);
  if (tree.states.size() != 3) failures.push_back("there are not three states");
  if (tree.states.size() == 3 && tree.states[1].skills != std::vector<double>{5, 0.5})
    failures.push_back("best_at_production has other points");

  for (const std::string& failure : failures) std::printf("%s\n", failure.c_str());
  return failures.empty() ? 0 : 1;
}
