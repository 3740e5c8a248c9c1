#include "core/plugins/values.hpp"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "core/plugins/yaml_text.hpp"

namespace somas::plugins {
namespace {

ParameterInfo ranged(double minimum, double maximum, bool open = false, const char* unit = "") {
  ParameterInfo info;
  info.kind = ParameterKind::number;
  info.minimum = minimum;
  info.maximum = maximum;
  info.minimum_open = open ? 1 : 0;
  info.unit = unit;
  return info;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(RangeText, NamesBothEnds) {
  EXPECT_EQ(range_text(ranged(0, 1)), "0 to 1");
  EXPECT_EQ(range_text(ranged(0, infinity, false, "length")), "at least 0 [length]");
  EXPECT_EQ(range_text(ranged(0, infinity, true)), "greater than 0");
  EXPECT_EQ(range_text(ranged(0, 1, true)), "greater than 0, at most 1");
  EXPECT_EQ(range_text(ranged(-infinity, 1e6)), "at most 1000000");
  EXPECT_EQ(range_text(ranged(1, 1)), "1");
  EXPECT_EQ(range_text(ranged(-infinity, infinity)), "");
}

TEST(InRange, RespectsAnOpenMinimum) {
  EXPECT_TRUE(in_range(ranged(0, 1), 0));
  EXPECT_FALSE(in_range(ranged(0, 1, true), 0));
  EXPECT_FALSE(in_range(ranged(0, 1), 1.01));
}

RC_GTEST_PROP(FormatNumber, ReadsBackAsTheSameNumber, (double number)) {
  RC_PRE(std::isfinite(number));
  RC_ASSERT(std::strtod(format_number(number).c_str(), nullptr) == number);
}

TEST(FormatNumber, IsShort) {
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(1e6), "1000000");
  EXPECT_EQ(format_number(1e22), "1e+22");
  EXPECT_EQ(format_number(1.0 / 30), "0.03333333333333333");
}

TEST(PackedValue, GivesTheSdkTheWholeTree) {
  ParameterValue number;
  number.kind = ParameterKind::number;
  number.number = 2;
  number.key = "depth";
  ParameterValue left_out;
  ParameterValue group;
  group.kind = ParameterKind::group;
  group.items = {left_out, number};
  const PackedValue packed(group);
  ASSERT_EQ(packed.value().count, 1u);
  EXPECT_STREQ(packed.value().items[0].key, "depth");
  EXPECT_EQ(packed.value().items[0].number, 2);
  EXPECT_EQ(copy_of(packed.value()).find("depth")->number, 2);
}

TEST(YamlText, QuotesWhatIsNotPlain) {
  EXPECT_EQ(yaml_text("nutritive"), "nutritive");
  EXPECT_EQ(yaml_text("a-b.c/d_1"), "a-b.c/d_1");
  for (const char* word : {"", "no", "True", "null", "12", "1e3", ".nan", "a: b", "- a", "#x", "~"})
    EXPECT_EQ(yaml_text(word).front(), '"') << word;
  EXPECT_EQ(yaml_text("say \"hi\"\n\x01"), "\"say \\\"hi\\\"\\n\\x01\"");
}

}  // namespace
}  // namespace somas::plugins
