#include "core/plugins/registry.hpp"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/plugins/describe.hpp"

namespace somas::plugins {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string good = SOMAS_BINARY_DIR "/tests/fixtures/plugins";
const std::string bad = SOMAS_BINARY_DIR "/tests/fixtures/bad/";

Registry registry(const std::vector<std::string>& directories) {
  std::vector<SearchDirectory> path;
  for (const std::string& directory : directories) path.push_back({directory, "test"});
  return Registry(std::move(path));
}

std::string complaint(const Registry& from, PluginKind kind, const std::string& id) {
  try {
    static_cast<void>(from.find(kind, id));
    return "";
  } catch (const LookupError& error) {
    return error.what();
  }
}

TEST(Registry, FindsClassesByKindAndId) {
  const Registry found = registry({good});
  EXPECT_EQ(found.find(PluginKind::fitness, "toy_fitness").id(), "toy_fitness");
  EXPECT_EQ(found.find("toy_tree").info->kind, PluginKind::specialization);
  EXPECT_THAT(found.ids(PluginKind::environment),
              ElementsAre("toy_environment", "toy_parameters", "toy_relations"));
}

TEST(Registry, ListsAFileOnceHoweverItIsReached) {
  EXPECT_EQ(registry({good, good + "/../plugins"}).candidates().size(),
            registry({good}).candidates().size());
}

TEST(Registry, SaysWhatIsMissing) {
  const std::string text = bad + "text";
  EXPECT_EQ(complaint(registry({good, text, "/none"}), PluginKind::fitness, "toy_fitnes"),
            "no fitness 'toy_fitnes'; available: toy_fitness; did you mean 'toy_fitness'?\n"
            "  searched:\n    " +
                good + " (test)\n    " + text +
                " (test)\n    /none (test, does not exist)\n  rejected: " + text +
                "/text.somas.so: not a shared library (it has no ELF header); build it with "
                "somas_add_plugin");
}

TEST(Registry, SaysThatAnIdIsOfAnotherKind) {
  EXPECT_EQ(complaint(registry({good}), PluginKind::controller, "toy_environment"),
            "'toy_environment' is an environment, not a controller; available: toy_controller");
}

TEST(Registry, NamesBothFilesOfADuplicateId) {
  const Registry found = registry({good, bad + "duplicate_id"});
  EXPECT_EQ(complaint(found, PluginKind::fitness, "toy_fitness"),
            "two plugins define 'toy_fitness': " +
                std::filesystem::canonical(good + "/toy_fitness.somas.so").string() + " and " +
                std::filesystem::canonical(bad + "duplicate_id/duplicate_id.somas.so").string() +
                "; remove one of them, or its directory from the search path");
  // Others are not affected.
  EXPECT_EQ(found.find("toy_tree").id(), "toy_tree");
  EXPECT_THAT(listing(found), HasSubstr("defined more than once, so not usable: toy_fitness"));
}

TEST(Registry, KeepsRejectedFilesWithTheReason) {
  const Registry found = registry({bad + "truncated"});
  ASSERT_EQ(found.candidates().size(), 1u);
  EXPECT_EQ(found.candidates()[0].library, nullptr);
  EXPECT_THAT(found.candidates()[0].reason, HasSubstr("truncated: "));
  EXPECT_THAT(listing(found), HasSubstr("rejected: " + bad + "truncated/truncated.somas.so: "));
}

TEST(SearchPath, TakesTheEnvironmentVariableFirst) {
  ::setenv("SOMAS_PLUGIN_PATH", "/one::/two", 1);
  const std::vector<SearchDirectory> path = standard_search_path();
  ::unsetenv("SOMAS_PLUGIN_PATH");
  ASSERT_EQ(path.size(), 4u);
  EXPECT_EQ(path[0].directory, "/one");
  EXPECT_EQ(path[1].directory, "/two");
  EXPECT_EQ(path[2].source, "installation");
  EXPECT_EQ(path[3].source, "build tree");
}

TEST(Listing, ShowsClassesAndSearchPath) {
  const std::string text = listing(registry({good}));
  EXPECT_THAT(text, HasSubstr("somas.test.fitness 1.0  " + good +
                              "/toy_fitness.somas.so\n"
                              "  toy_fitness (fitness): Steps survived, up to a limit\n"));
  EXPECT_THAT(text, HasSubstr("search path:\n  " + good + " (test)\n"));
  EXPECT_THAT(listing(registry({})), HasSubstr("no plugins\n"));
}

TEST(Describe, ShowsParametersAsText) {
  const PluginClass described = registry({good}).find("toy_parameters");
  const std::string text = describe(described, DescribeFormat::text);
  EXPECT_THAT(text, HasSubstr("toy_parameters (environment): One parameter of every kind\n"));
  EXPECT_THAT(text, HasSubstr("  number: number, default 1.5, allowed 0 to 10 [1/step]\n"));
  EXPECT_THAT(text, HasSubstr("  maybe: number, default none, allowed greater than 0\n"));
  EXPECT_THAT(text, HasSubstr("  table: names to numbers, default {a: 1}, allowed at least 0\n"));
  EXPECT_THAT(text, HasSubstr("  list[].depth: number, default 0.25, allowed [length]\n"));
}

TEST(Describe, ShowsAPageAsMarkdown) {
  const PluginClass described = registry({good}).find("toy_controller");
  EXPECT_EQ(describe(described, DescribeFormat::markdown),
            "# `toy_controller` (controller)\n\nConstant outputs from a byte each.\n\n"
            "In the library `somas.test.controller`; in an experiment:\n\n"
            "```yaml\ncontroller: {plugin: toy_controller}\n```\n\n## Parameters\n\n"
            "| key | type | default | allowed | meaning |\n|---|---|---|---|---|\n"
            "| `gain` | number | `1` | 0 to 2 | Factor on every output |\n");
}

TEST(Describe, ShowsYamlToPaste) {
  const PluginClass described = registry({good}).find("toy_fitness");
  EXPECT_EQ(
      describe(described, DescribeFormat::yaml),
      "# Steps survived, up to a limit\nfitness:\n  plugin: toy_fitness\n"
      "  # stop_at:  # Step at which to stop; left out: never; at least 1 [step] (optional)\n");
}

}  // namespace
}  // namespace somas::plugins
