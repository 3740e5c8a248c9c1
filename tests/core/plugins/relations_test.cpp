// Relations that a plugin's table states wrongly are refused; sound ones are told to people.
#include "core/plugins/relations.hpp"

#include <functional>

#include <gmock/gmock.h>

#include "core/plugins/check.hpp"
#include "core/plugins/describe.hpp"
#include "core/plugins/elf.hpp"

namespace somas::plugins {
namespace {

using testing::HasSubstr;

struct Members {
  double low = 1, high = 2;
  std::int64_t count = 3;
  std::optional<double> limit{};
  bool loud = false;
  std::string text{}, mode = "peak";
  std::vector<double> list{};

  void describe_all(Describe& d) {
    d("low", low, "Low");
    d("high", high, "High");
    d("count", count, "Count");
    d("limit", limit, "Limit");
    d("loud", loud, "Loud");
    d("text", text, "Text");
    d.choice("mode", mode, {"peak", "share"}, "Mode");
    d("list", list, "List", {.maximum_count = 3});
  }
};

// What check_table says of a fitness with these parameters; empty: nothing.
std::string refusal(const Describe& d) {
  const auto create = [](const Value*) -> void* { return nullptr; };
  ClassInfo info;
  info.kind = PluginKind::fitness;
  info.id = "toy";
  info.parameters = d.parameters().data();
  info.parameter_count = d.parameters().size();
  info.create = create;
  info.destroy = [](void*) {};
  PluginInfo table;
  table.fingerprint = SOMAS_FINGERPRINT;
  table.id = "toys";
  table.version = "1";
  table.classes = &info;
  table.class_count = 1;
  try {
    check_table(&table);
    return "";
  } catch (const BadPlugin& bad) {
    return bad.what();
  }
}

std::string refusal_of(const std::function<void(Describe&)>& relate, Members members = {}) {
  Describe d;
  members.describe_all(d);
  relate(d);
  return refusal(d);
}

TEST(Relations, OfSoundTablesAreTaken) {
  EXPECT_EQ(refusal_of([](Describe& d) {
              d.at_most("low", "high");
              d.at_most("limit", "high");
              d.less_than("low", "count");
              d.needs("limit", "text");
              d.excludes("loud", "list");
              d.only_when("limit", "mode", {"share"});
              d.required_when("limit", "mode", {"share"});
              d.only_when("text", "loud", {"true"});
            }),
            "");
}

TEST(Relations, ToUnknownParametersAreRefused) {
  EXPECT_EQ(refusal_of([](Describe& d) { d.at_most("low", "hihg"); }),
            "its table is unusable: toy.low: a relation is to 'hihg', which is no other parameter "
            "of its group; this is a fault of the plugin");
  EXPECT_THAT(refusal_of([](Describe& d) { d.at_most("low", "low"); }),
              HasSubstr("no other parameter"));
}

TEST(Relations, ThatCompareWhatIsNoNumberAreRefused) {
  EXPECT_THAT(refusal_of([](Describe& d) { d.at_most("low", "text"); }),
              HasSubstr("toy.low: the relation to 'text' compares what is no number"));
  EXPECT_THAT(refusal_of([](Describe& d) { d.differs("text", "low"); }),
              HasSubstr("compares what cannot be compared"));
}

TEST(Relations, AboutWhatAlwaysHasAValueAreRefused) {
  for (const char* other : {"limit", "high"})
    EXPECT_THAT(refusal_of([&](Describe& d) { d.needs("low", other); }),
                HasSubstr("is about a parameter that always has a value"));
  EXPECT_THAT(refusal_of([](Describe& d) { d.required_when("low", "mode", {"peak"}); }),
              HasSubstr("is about a parameter that always has a value"));
}

TEST(Relations, WithWordsThatAreNoneAreRefused) {
  EXPECT_THAT(refusal_of([](Describe& d) { d.only_when("limit", "mode", {"peek"}); }),
              HasSubstr("names 'peek', which is no word of the other"));
  EXPECT_THAT(refusal_of([](Describe& d) { d.only_when("limit", "mode", {}); }),
              HasSubstr("names no word"));
  EXPECT_THAT(refusal_of([](Describe& d) { d.only_when("limit", "loud", {"loud"}); }),
              HasSubstr("names 'loud', which is no word of the other"));
}

TEST(Relations, ThatTheDefaultsBreakAreRefused) {
  EXPECT_THAT(refusal_of([](Describe& d) { d.at_most("high", "low"); }),
              HasSubstr("toy.high: the defaults break its own rule: at most low"));
  EXPECT_EQ(refusal_of([](Describe& d) { d.required_when("limit", "mode", {"peak"}); }), "")
      << "a file can give it";
}

TEST(Relations, BeginWithWhatHasBeenDescribed) {
  Describe d;
  EXPECT_THROW(d.at_most("later", "low"), std::logic_error);
}

TEST(Relations, OfListsWithTooManyDefaultsAreRefused) {
  Members members;
  members.list = {1, 2, 3, 4};
  EXPECT_THAT(refusal_of([](Describe&) {}, members),
              HasSubstr("toy.list: its default has a wrong number of elements"));
}

TEST(Relations, AreDescribed) {
  Members members;
  Describe d;
  members.describe_all(d);
  d.at_most("low", "high");
  d.only_when("limit", "mode", {"peak", "share"});
  const std::string rows = markdown_rows(d.parameters());
  EXPECT_THAT(rows, HasSubstr("| `low` | number | `1` | at most high | Low |"));
  EXPECT_THAT(rows, HasSubstr("| `limit` | number | none | only when mode is peak or share |"));
  EXPECT_THAT(rows, HasSubstr("| `list` | list of numbers | `[]` | at most 3 elements | List |"));
}

}  // namespace
}  // namespace somas::plugins
