// What a reference says that a class declares, on the toy plugins.
#include "core/plugins/declarations.hpp"

#include <gmock/gmock.h>

#include "core/plugins/describe.hpp"
#include "core/plugins/registry.hpp"

namespace somas::plugins {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

PluginClass toy(const std::string& id) {
  const SearchDirectory fixtures{SOMAS_BINARY_DIR "/tests/fixtures/plugins", "test"};
  return Registry({fixtures}).find(id);
}

TEST(Declarations, OfAnEnvironmentAreThoseOfItsDefaults) {
  EXPECT_EQ(
      declarations(toy("toy_environment")),
      "With the defaults:\n\n"
      "| what | name | more |\n|---|---|---|\n"
      "| phase | `fields` | every step |\n"
      "| skill | `production` | default 0, at least 0; costs 1 of a budget |\n"
      "| skill | `resistance` | default 0, at least 0; costs 1 of a budget |\n"
      "| resource | `toy_environment` | output `uptake.toy_environment`; from grid "
      "`resource`, at most the points in `production` a step |\n"
      "| hazard | `toy_hazard` | a cause of death, when more is absorbed than the points in "
      "`resistance` |\n"
      "| grid | `resource` | 30 x 30 squares of side 4, from x = -60, y = -60; 2 at the start "
      "|\n");
}

TEST(Declarations, OfAFitnessNameItsObjective) {
  EXPECT_EQ(declarations(toy("toy_fitness")),
            "With the defaults:\n\nIts objective is `survival`.\n");
}

TEST(Declarations, OfATreeSayWhetherItEvolves) {
  EXPECT_EQ(declarations(toy("toy_tree")),
            "With the defaults:\n\nThe tree is fixed: it is the same for all genomes.\n");
}

TEST(Declarations, OfAControllerThereAreNone) {
  EXPECT_EQ(declarations(toy("toy_controller")), "");
}

TEST(Declarations, ShowWhatStandsForRequiredParameters) {
  Describe described;
  double depth = 0;
  std::vector<std::string> names;
  described("depth", depth, "How deep", {.minimum = 3, .required = true});
  described("names", names, "Who", {.required = true, .minimum_count = 2});
  ClassInfo info = *toy("toy_environment").info;
  info.parameters = described.parameters().data();
  info.parameter_count = described.parameters().size();
  const PluginClass demanding{toy("toy_environment").library, &info};
  EXPECT_THAT(describe(demanding, DescribeFormat::markdown),
              HasSubstr("```yaml\nenvironments:\n  toy_environment:\n    depth: 3\n"
                        "    names: [example, example]\n```\n"));
  EXPECT_THAT(declarations(demanding),
              StartsWith("With the defaults, and with what is required as above:\n\n| what |"));
}

// A class whose defaults cannot be had still has a reference.
TEST(Declarations, SayWhyAClassRefusesItsDefaults) {
  ClassInfo info = *toy("toy_environment").info;
  info.create = [](const Value*) -> void* { throw std::runtime_error("the sky is missing"); };
  EXPECT_EQ(declarations({toy("toy_environment").library, &info}),
            "With the defaults:\n\nIt refuses them: the sky is missing.\n");
}

TEST(Declarations, EndTheReferenceOfTheClass) {
  const std::string page = describe(toy("toy_environment"), DescribeFormat::markdown);
  EXPECT_THAT(page,
              StartsWith("# `toy_environment` (environment)\n\nA uniform resource and a "
                         "steady hazard.\n\nIn the library `somas.test.environment`; in an "
                         "experiment:\n\n```yaml\nenvironments:\n  toy_environment: {}\n```\n"));
  EXPECT_THAT(page, HasSubstr("\n## Parameters\n\n| key | type | default | allowed | meaning |\n"));
  EXPECT_THAT(page, HasSubstr("\n## What it declares\n\nWith the defaults:\n"));
  EXPECT_THAT(describe(toy("toy_controller"), DescribeFormat::markdown),
              Not(HasSubstr("declares")));
}

}  // namespace
}  // namespace somas::plugins
