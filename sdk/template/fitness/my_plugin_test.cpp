// Returns 0 if all is well; any test framework will do as well.
#include "my_plugin.hpp"

#include <cstdio>

#include <somas/sdk/testing.hpp>

int main() {
  // The contract of fitnesses.
  auto failures = somas::testing::check_fitness<MyPlugin>({.bonus = 2});

  // A rule of this one.
  const MyPlugin fitness({.bonus = 2});
  somas::Outcome outcome;
  outcome.survival = 100;
  outcome.divisions = 7;
  if (fitness.score(outcome) != 114) failures.push_back("the score is wrong");

  for (const std::string& failure : failures) std::printf("%s\n", failure.c_str());
  return failures.empty() ? 0 : 1;
}
