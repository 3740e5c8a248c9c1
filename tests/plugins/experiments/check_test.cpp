// Every bundled plugin's file passes `somas-host check`.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// What has no default.
const std::map<std::string, std::string> settings = {
    {"seasons.somas.so",
     "seasons.cycles=[{parameter: nutrients.regeneration, period: 7, from: 3}]"},
    {"tree.somas.so",
     "tree.states=[{name: root}, {name: leaf, parent: root, skills: {production: 3}}]"},
};

std::vector<std::string> bundled() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(SOMAS_BINARY_DIR "/plugins"))
    if (entry.path().string().ends_with(".somas.so"))
      names.push_back(entry.path().filename().string());
  return names;
}

TEST(Check, PassesEveryBundledPlugin) {
  const std::vector<std::string> names = bundled();
  EXPECT_GT(names.size(), 10u);
  for (const std::string& name : names) {
    const test::Scratch scratch;
    std::vector<std::string> words = {"check", SOMAS_BINARY_DIR "/plugins/" + name};
    if (const auto entry = settings.find(name); entry != settings.end())
      words.insert(words.end(), {"--set", entry->second});
    test::HostProcess process(scratch.path(), words);
    EXPECT_EQ(process.wait(), 0) << name << process.err();
    EXPECT_THAT(process.out(), AllOf(Not(HasSubstr("  FAIL  ")), Not(HasSubstr("  warn  ")),
                                     Not(HasSubstr("  skip  ")), HasSubstr(" passed, 0 failed\n")));
  }
}

}  // namespace
}  // namespace somas
