#include "core/run/json.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace somas::run {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RC_GTEST_PROP(Json, DoublesSurviveExactly, (std::uint64_t bits)) {
  const double value = std::bit_cast<double>(bits);
  RC_PRE(std::isfinite(value));
  Json json;
  JsonBuilder(json).number("x", value);
  const Json read = parse_json(to_text(json), "test");
  const double back = JsonView(read, "test").member("x").number();
  RC_ASSERT(std::bit_cast<std::uint64_t>(back) == bits);
}

RC_GTEST_PROP(Json, KeysAndBytesSurvive, (std::uint64_t key, std::vector<std::uint8_t> bytes)) {
  RC_ASSERT(parse_hex64(hex64(key)) == key);
  RC_ASSERT(parse_hex_bytes(hex_bytes(bytes)) == bytes);
}

TEST(Json, WriterAndReaderAgreeOnNesting) {
  Json json;
  JsonBuilder out(json);
  out.text("name", "a \"b\"\n");
  out.open_list("points");
  out.open_object("");
  out.number("x", 0.1);
  out.key64("key", 0xFEDCBA9876543210ull);
  out.close();
  out.integer("", -3);
  out.close();
  out.integer("after", std::numeric_limits<std::int64_t>::min());

  const Json read = parse_json(to_text(json), "test");
  const JsonView in(read, "test");
  EXPECT_EQ(in.member("name").text(), "a \"b\"\n");
  ASSERT_EQ(in.member("points").size(), 2u);
  EXPECT_EQ(in.member("points").item(0).member("x").number(), 0.1);
  EXPECT_EQ(in.member("points").item(0).member("key").key64(), 0xFEDCBA9876543210ull);
  EXPECT_EQ(in.member("points").item(1).integer(), -3);
  EXPECT_EQ(in.member("after").integer(), std::numeric_limits<std::int64_t>::min());
  EXPECT_TRUE(in.has("after"));
  EXPECT_FALSE(in.has("before"));
}

TEST(Json, WriterRefusesWhatWouldNotReadBack) {
  Json json;
  JsonBuilder out(json);
  EXPECT_THROW(out.number("x", std::nan("")), std::logic_error);
  out.integer("x", 1);
  EXPECT_THROW(out.integer("x", 2), std::logic_error);
  EXPECT_THROW(out.integer("", 2), std::logic_error);
  EXPECT_THROW(out.close(), std::logic_error);
}

std::string complaint(const std::string& text, void (*read)(const JsonView&)) {
  const Json json = parse_json(text, "file.json");
  try {
    read(JsonView(json, "file.json"));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Json, ReaderNamesThePlaceOfAnError) {
  EXPECT_EQ(complaint(R"({"a": [1, {"b": "x"}]})",
                      [](const JsonView& in) {
                        static_cast<void>(in.member("a").item(1).member("b").number());
                      }),
            "file.json.a[1].b: expected a number, found string");
  EXPECT_EQ(complaint("{}", [](const JsonView& in) { static_cast<void>(in.member("a")); }),
            "file.json: \"a\" is missing");
  EXPECT_EQ(complaint("[1]", [](const JsonView& in) { static_cast<void>(in.item(1)); }),
            "file.json: has 1 items, item 1 is missing");
  EXPECT_EQ(complaint("[-1]", [](const JsonView& in) { static_cast<void>(in.item(0).natural()); }),
            "file.json[0]: expected an integer, 0 or more, found number");
  EXPECT_EQ(
      complaint("[\"12\"]", [](const JsonView& in) { static_cast<void>(in.item(0).key64()); }),
      "file.json[0]: expected 16 hexadecimal digits, found string");
}

TEST(Json, BrokenTextNamesTheLine) {
  try {
    static_cast<void>(parse_json("{\n\"a\": 1,\n}", "file.json"));
    FAIL() << "no exception";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("file.json:3: not valid JSON"));
  }
}

TEST(Json, ComplaintsAreNotTheLibrarys) {
  try {
    static_cast<void>(parse_json("{\"a\": 1e999}", "file.json"));
    FAIL() << "no exception";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("file.json: not valid JSON: number overflow"));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("json.exception")));
  }
}

TEST(Json, LongListsFillLines) {
  Json json;
  for (int i = 0; i < 200; ++i) json["list"].push_back(i);
  const std::string text = to_text(json);
  std::size_t longest = 0, lines = 0;
  for (std::size_t start = 0; start < text.size(); ++lines) {
    const std::size_t end = text.find('\n', start);
    longest = std::max(longest, end - start);
    start = end + 1;
  }
  EXPECT_LE(longest, 100u);
  EXPECT_LE(lines, 15u);
  EXPECT_EQ(parse_json(text, "test"), json);
}

}  // namespace
}  // namespace somas::run
