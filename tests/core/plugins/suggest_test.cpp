#include "core/plugins/suggest.hpp"

#include <gtest/gtest.h>

namespace somas::plugins {
namespace {

const std::vector<std::string> keys = {"radius", "max_steps", "max_cells", "particle_aggression"};

TEST(EditDistance, CountsSwappedNeighboursAsOneEdit) {
  EXPECT_EQ(edit_distance("radius", "radius"), 0u);
  EXPECT_EQ(edit_distance("radius", "raduis"), 1u);
  EXPECT_EQ(edit_distance("radius", "rdius"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(EditDistance, TakesNoNoticeOfCaseAndDashes) {
  EXPECT_EQ(edit_distance("Max-Steps", "max_steps"), 0u);
}

TEST(Suggest, FindsTheNearest) {
  EXPECT_EQ(suggest("max_stepz", keys), "max_steps");
  EXPECT_EQ(suggest("maxsteps", keys), "max_steps");
  EXPECT_EQ(suggest("aggression", keys), "particle_aggression");
}

TEST(Suggest, FindsNothingFarAway) {
  EXPECT_EQ(suggest("temperature", keys), "");
  EXPECT_EQ(suggest("", keys), "");
  EXPECT_EQ(suggest(std::string(100000, 'x'), keys), "");
}

TEST(Suggest, MakesAQuestion) {
  EXPECT_EQ(did_you_mean("raduis", keys), "; did you mean 'radius'?");
  EXPECT_EQ(did_you_mean("zzz", keys), "");
}

TEST(Plural, CountsOneAsOne) {
  EXPECT_EQ(plural(0, "generation"), "0 generations");
  EXPECT_EQ(plural(1, "generation"), "1 generation");
  EXPECT_EQ(plural(2, "generation"), "2 generations");
}

}  // namespace
}  // namespace somas::plugins
