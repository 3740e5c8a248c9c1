#include "tests/plugins/experiments/goldens.hpp"

#include <gtest/gtest.h>

namespace somas::test {
namespace {

class Goldens : public testing::TestWithParam<std::string> {};

TEST_P(Goldens, AreMetWithOneTwoAndFourThreads) {
  const auto goldens = read_goldens(run::read_file(goldens_file));
  ASSERT_TRUE(goldens.contains(GetParam())) << "no line in goldens.txt; see ./dev goldens";
  for (const unsigned threads : {1u, 2u, 4u})
    EXPECT_EQ(golden_of(GetParam(), threads), goldens.at(GetParam()))
        << threads << " threads. If results were meant to change: ./dev goldens --why TEXT";
}

TEST_P(Goldens, AreMetWithTwoAndFourThreadsInEachWorld) {
  const auto goldens = read_goldens(run::read_file(goldens_file));
  ASSERT_TRUE(goldens.contains(GetParam())) << "no line in goldens.txt; see ./dev goldens";
  for (const unsigned world_threads : {2u, 4u})
    EXPECT_EQ(golden_of(GetParam(), 1, world_threads), goldens.at(GetParam()))
        << world_threads << " threads in each world";
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return name;
}
INSTANTIATE_TEST_SUITE_P(Shipped, Goldens, testing::ValuesIn(golden_names()), test_name);

TEST(GoldensFile, HasNoLineOfAnExperimentThatIsGone) {
  const std::vector<std::string> names = golden_names();
  for (const auto& [name, hashes] : read_goldens(run::read_file(goldens_file)))
    EXPECT_TRUE(std::find(names.begin(), names.end(), name) != names.end()) << name;
}

TEST(GoldensFile, SaysWhyItIsAsItIs) {
  EXPECT_NE(run::read_file(goldens_file).find("\n# why: "), std::string::npos);
}

}  // namespace
}  // namespace somas::test
