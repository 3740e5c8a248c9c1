// Describe: collecting a struct's parameters and reading values back.
#include "somas/sdk/parameters.hpp"

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace somas {
namespace {

struct Inner {
  double depth = 2.5;
  bool open = true;
  void describe(Describe& d) {
    d("depth", depth, "How deep", {.unit = "m"});
    d("open", open, "Whether open");
  }
};

struct Item {
  std::string name = "nameless";
  std::vector<double> weights = {1, 2};
  std::vector<Inner> holes;
  void describe(Describe& d) {
    d("name", name, "Its name", {.required = true});
    d("weights", weights, "Its weights", {.minimum = 0});
    d.list("holes", holes, "Its holes");
  }
};

struct Everything {
  double rate = 1.25;
  std::optional<double> limit;
  std::optional<double> given = 4;
  std::int64_t count = 7;
  bool on = true;
  std::string title = "plain";
  std::string mode = "peak";
  std::vector<double> numbers = {3, 1, 4};
  std::map<std::string, double> skills = {{"grip", 2}, {"sight", 0.5}};
  Inner inner;
  std::vector<Item> items;
  void describe(Describe& d) {
    d("rate", rate, "Particles a step",
      {.unit = "1/step", .minimum = 0, .maximum = 9, .minimum_open = true});
    d("limit", limit, "None if left out");
    d("given", given, "Optional with a default");
    d("count", count, "How many", {.minimum = 1});
    d("on", on, "Whether on");
    d("title", title, "Any text");
    d.choice("mode", mode, {"peak", "share"}, "How to weigh");
    d("numbers", numbers, "Some numbers", {.maximum = 5});
    d.table("skills", skills, "Points by skill", {.minimum = 0});
    d.group("inner", inner, "A group");
    d.list("items", items, "A list", true);
  }
};

/// A Value tree with the storage behind it.
class Tree {
 public:
  static Value number(double x) {
    Value v;
    v.kind = ParameterKind::number;
    v.number = x;
    return v;
  }
  static Value integer(std::int64_t x, ParameterKind kind = ParameterKind::integer) {
    Value v;
    v.kind = kind;
    v.integer = x;
    return v;
  }
  static Value text(const char* x, ParameterKind kind = ParameterKind::text) {
    Value v;
    v.kind = kind;
    v.text = x;
    return v;
  }
  Value of(ParameterKind kind, std::vector<Value> items) {
    storage_.push_back(std::move(items));
    Value v;
    v.kind = kind;
    v.items = storage_.back().data();
    v.count = storage_.back().size();
    return v;
  }
  static Value named(const char* key, Value v) {
    v.key = key;
    return v;
  }

 private:
  std::deque<std::vector<Value>> storage_;
};

const ParameterInfo& find(const Describe& described, const std::string& name) {
  for (const ParameterInfo& info : described.parameters())
    if (info.name == name) return info;
  throw std::logic_error("no parameter " + name);
}

TEST(Collecting, ListsEveryMemberInOrderWithItsKind) {
  Everything everything;
  Describe d;
  everything.describe(d);
  std::vector<std::pair<std::string, ParameterKind>> listed;
  for (const ParameterInfo& info : d.parameters()) listed.emplace_back(info.name, info.kind);
  const std::vector<std::pair<std::string, ParameterKind>> expected{
      {"rate", ParameterKind::number},  {"limit", ParameterKind::number},
      {"given", ParameterKind::number}, {"count", ParameterKind::integer},
      {"on", ParameterKind::boolean},   {"title", ParameterKind::text},
      {"mode", ParameterKind::choice},  {"numbers", ParameterKind::list},
      {"skills", ParameterKind::table}, {"inner", ParameterKind::group},
      {"items", ParameterKind::list}};
  EXPECT_EQ(listed, expected);
}

TEST(Collecting, TakesDefaultsFromTheStruct) {
  Everything everything;
  everything.rate = 0.75;
  everything.title = "changed";
  Describe d;
  everything.describe(d);
  everything.title = "overwritten later";
  EXPECT_EQ(find(d, "rate").fallback.number, 0.75);
  EXPECT_EQ(find(d, "rate").fallback.kind, ParameterKind::number);
  EXPECT_EQ(find(d, "limit").fallback.kind, ParameterKind::none) << "may be left out";
  EXPECT_EQ(find(d, "limit").required, 0u);
  EXPECT_EQ(find(d, "given").fallback.number, 4);
  EXPECT_EQ(find(d, "count").fallback.integer, 7);
  EXPECT_EQ(find(d, "on").fallback.integer, 1);
  EXPECT_STREQ(find(d, "title").fallback.text, "changed") << "a copy of its own";
  EXPECT_STREQ(find(d, "mode").fallback.text, "peak");
  const Value& numbers = find(d, "numbers").fallback;
  ASSERT_EQ(numbers.count, 3u);
  EXPECT_EQ(numbers.items[0].number, 3);
  EXPECT_EQ(numbers.items[2].number, 4);
  EXPECT_EQ(numbers.items[2].kind, ParameterKind::number);
  const Value& skills = find(d, "skills").fallback;
  ASSERT_EQ(skills.count, 2u);
  EXPECT_STREQ(skills.items[0].key, "grip");
  EXPECT_EQ(skills.items[1].number, 0.5);
}

enum class Shade { dark, light };

struct More {
  std::optional<std::int64_t> count{};
  std::optional<std::string> label = "given";
  std::vector<std::int64_t> ranks = {3, 4};
  std::vector<std::string> names = {"x"};
  std::vector<bool> flags = {true, false};
  std::vector<std::string> modes = {"fast"};
  Shade shade = Shade::light;
  std::optional<std::string> voice{};
  void describe(Describe& d) {
    d("count", count, "How many");
    d("label", label, "A label");
    d("ranks", ranks, "Ranks", {.minimum = 0, .minimum_count = 1, .maximum_count = 5});
    d("names", names, "Names");
    d("flags", flags, "Flags");
    d.choices("modes", modes, {"slow", "fast"}, "Modes");
    d.choice("shade", shade, {{"dark", Shade::dark}, {"light", Shade::light}}, "Shade");
    d.choice("voice", voice, {"high", "low"}, "Voice");
    d.needs("count", "label");
    d.only_when("count", "shade", {"dark"});
  }
};

TEST(Collecting, TakesOptionalsListsAndEnumerations) {
  More more;
  Describe d;
  more.describe(d);
  EXPECT_EQ(find(d, "count").kind, ParameterKind::integer);
  EXPECT_EQ(find(d, "count").fallback.kind, ParameterKind::none);
  EXPECT_STREQ(find(d, "label").fallback.text, "given");
  const ParameterInfo& ranks = find(d, "ranks");
  EXPECT_EQ(ranks.minimum_count, 1u);
  EXPECT_EQ(ranks.maximum_count, 5u);
  EXPECT_EQ(ranks.fields[0].kind, ParameterKind::integer);
  EXPECT_EQ(ranks.fallback.items[1].integer, 4);
  EXPECT_STREQ(find(d, "names").fallback.items[0].text, "x");
  EXPECT_EQ(find(d, "flags").fallback.items[0].integer, 1);
  EXPECT_EQ(find(d, "flags").fallback.items[1].integer, 0);
  EXPECT_EQ(find(d, "modes").fields[0].kind, ParameterKind::choice);
  EXPECT_EQ(find(d, "modes").fields[0].choice_count, 2u);
  EXPECT_EQ(find(d, "modes").fallback.items[0].kind, ParameterKind::choice);
  EXPECT_STREQ(find(d, "shade").fallback.text, "light");
  EXPECT_STREQ(find(d, "shade").choices[0], "dark");
  EXPECT_EQ(find(d, "voice").fallback.kind, ParameterKind::none);
}

TEST(Collecting, KeepsRelationsWithTheParameterTheyBeginWith) {
  More more;
  Describe d;
  more.describe(d);
  const ParameterInfo& count = find(d, "count");
  ASSERT_EQ(count.relation_count, 2u);
  EXPECT_EQ(count.relations[0].kind, RelationKind::needs);
  EXPECT_STREQ(count.relations[0].other, "label");
  EXPECT_EQ(count.relations[1].kind, RelationKind::only_when);
  ASSERT_EQ(count.relations[1].word_count, 1u);
  EXPECT_STREQ(count.relations[1].words[0], "dark");
  EXPECT_EQ(find(d, "label").relation_count, 0u);
}

TEST(Reading, SetsOptionalsListsAndEnumerations) {
  Tree tree;
  const Value values = tree.of(
      ParameterKind::group,
      {Tree::named("count", Tree::integer(9)),
       Tree::named("ranks", tree.of(ParameterKind::list, {Tree::integer(5)})),
       Tree::named("names", tree.of(ParameterKind::list, {Tree::text("a"), Tree::text("b")})),
       Tree::named("flags",
                   tree.of(ParameterKind::list, {Tree::integer(0, ParameterKind::boolean)})),
       Tree::named("modes",
                   tree.of(ParameterKind::list, {Tree::text("slow", ParameterKind::choice)})),
       Tree::named("shade", Tree::text("dark", ParameterKind::choice)),
       Tree::named("voice", Tree::text("low", ParameterKind::choice))});
  More more;
  Describe reader(values);
  more.describe(reader);
  EXPECT_EQ(more.count, 9);
  EXPECT_EQ(more.label, "given") << "left out";
  EXPECT_EQ(more.ranks, std::vector<std::int64_t>{5});
  EXPECT_EQ(more.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(more.flags, std::vector<bool>{false});
  EXPECT_EQ(more.modes, std::vector<std::string>{"slow"});
  EXPECT_EQ(more.shade, Shade::dark);
  EXPECT_EQ(more.voice, "low");
}

TEST(Collecting, KeepsDocUnitAndLimits) {
  Everything everything;
  Describe d;
  everything.describe(d);
  const ParameterInfo& rate = find(d, "rate");
  EXPECT_STREQ(rate.doc, "Particles a step");
  EXPECT_STREQ(rate.unit, "1/step");
  EXPECT_EQ(rate.minimum, 0);
  EXPECT_EQ(rate.maximum, 9);
  EXPECT_EQ(rate.minimum_open, 1u);
  EXPECT_EQ(rate.required, 0u);
  EXPECT_EQ(rate.size, sizeof(ParameterInfo));
  EXPECT_EQ(find(d, "count").minimum, 1);
  EXPECT_EQ(find(d, "count").minimum_open, 0u);
  EXPECT_EQ(find(d, "on").maximum, std::numeric_limits<double>::infinity());
  const ParameterInfo& mode = find(d, "mode");
  ASSERT_EQ(mode.choice_count, 2u);
  EXPECT_STREQ(mode.choices[0], "peak");
  EXPECT_STREQ(mode.choices[1], "share");
  EXPECT_EQ(find(d, "skills").minimum, 0);
  ASSERT_EQ(find(d, "numbers").field_count, 1u);
  EXPECT_EQ(find(d, "numbers").fields[0].kind, ParameterKind::number);
  EXPECT_EQ(find(d, "numbers").fields[0].maximum, 5);
}

TEST(Collecting, DescendsIntoGroupsAndLists) {
  Everything everything;
  everything.inner.depth = 6;
  Describe d;
  everything.describe(d);
  const ParameterInfo& inner = find(d, "inner");
  ASSERT_EQ(inner.field_count, 2u);
  EXPECT_STREQ(inner.fields[0].name, "depth");
  EXPECT_STREQ(inner.fields[0].unit, "m");
  EXPECT_EQ(inner.fields[0].fallback.number, 6);
  EXPECT_EQ(inner.fields[1].kind, ParameterKind::boolean);

  const ParameterInfo& items = find(d, "items");
  EXPECT_EQ(items.required, 1u);
  EXPECT_EQ(items.fallback.kind, ParameterKind::none);
  ASSERT_EQ(items.field_count, 1u);
  const ParameterInfo& element = items.fields[0];
  EXPECT_EQ(element.kind, ParameterKind::group);
  ASSERT_EQ(element.field_count, 3u);
  EXPECT_STREQ(element.fields[0].name, "name");
  EXPECT_EQ(element.fields[0].required, 1u);
  EXPECT_EQ(element.fields[0].fallback.kind, ParameterKind::none) << "required: no default";
  EXPECT_EQ(element.fields[1].fallback.count, 2u) << "the element's own defaults";
  const ParameterInfo& holes = element.fields[2];
  EXPECT_EQ(holes.required, 0u);
  ASSERT_EQ(holes.fields[0].field_count, 2u);
  EXPECT_STREQ(holes.fields[0].fields[0].name, "depth");
}

TEST(Reading, SetsEveryKindFromTheGroup) {
  Tree t;
  const auto hole = [&](double depth) {
    return t.of(ParameterKind::group, {Tree::named("depth", Tree::number(depth))});
  };
  const Value item = t.of(ParameterKind::group,
                          {Tree::named("holes", t.of(ParameterKind::list, {hole(8), hole(9)})),
                           Tree::named("weights", t.of(ParameterKind::list, {Tree::number(5)})),
                           Tree::named("name", Tree::text("first"))});
  const Value second = t.of(ParameterKind::group, {Tree::named("name", Tree::text("second"))});
  const Value values = t.of(
      ParameterKind::group,
      {Tree::named("items", t.of(ParameterKind::list, {item, second})),
       Tree::named("inner", t.of(ParameterKind::group,
                                 {Tree::named("open", Tree::integer(0, ParameterKind::boolean))})),
       Tree::named("skills", t.of(ParameterKind::table, {Tree::named("wit", Tree::number(3))})),
       Tree::named("numbers", t.of(ParameterKind::list, {Tree::number(9), Tree::number(8)})),
       Tree::named("mode", Tree::text("share", ParameterKind::choice)),
       Tree::named("title", Tree::text("read")),
       Tree::named("on", Tree::integer(0, ParameterKind::boolean)),
       Tree::named("count", Tree::integer(-5)), Tree::named("limit", Tree::number(11)),
       Tree::named("rate", Tree::number(0.5))});
  Everything everything;
  Describe reader(values);
  everything.describe(reader);
  EXPECT_EQ(everything.rate, 0.5);
  EXPECT_EQ(everything.limit, 11);
  EXPECT_EQ(everything.given, 4) << "left out: the default stays";
  EXPECT_EQ(everything.count, -5);
  EXPECT_FALSE(everything.on);
  EXPECT_EQ(everything.title, "read");
  EXPECT_EQ(everything.mode, "share");
  EXPECT_EQ(everything.numbers, (std::vector<double>{9, 8})) << "replaced, not appended";
  EXPECT_EQ(everything.skills, (std::map<std::string, double>{{"wit", 3}}));
  EXPECT_EQ(everything.inner.depth, 2.5);
  EXPECT_FALSE(everything.inner.open);
  ASSERT_EQ(everything.items.size(), 2u);
  EXPECT_EQ(everything.items[0].name, "first");
  EXPECT_EQ(everything.items[0].weights, (std::vector<double>{5}));
  ASSERT_EQ(everything.items[0].holes.size(), 2u);
  EXPECT_EQ(everything.items[0].holes[1].depth, 9);
  EXPECT_TRUE(everything.items[0].holes[1].open);
  EXPECT_EQ(everything.items[1].name, "second");
  EXPECT_EQ(everything.items[1].weights, (std::vector<double>{1, 2}));
}

TEST(Reading, EmptyGroupLeavesAllDefaults) {
  Tree t;
  Everything everything;
  const Value nothing = t.of(ParameterKind::group, {});
  Describe reader(nothing);
  everything.describe(reader);
  EXPECT_EQ(everything.rate, 1.25);
  EXPECT_FALSE(everything.limit.has_value());
  EXPECT_EQ(everything.skills.size(), 2u);
  EXPECT_TRUE(everything.items.empty());
}

TEST(Reading, ValueOfAnotherKindIsIgnored) {
  Tree t;
  const Value values = t.of(ParameterKind::group,
                            {Tree::named("rate", Tree::text("fast")), Tree::named("given", Value{}),
                             Tree::named("title", Tree::number(3))});
  Everything everything;
  Describe reader(values);
  everything.describe(reader);
  EXPECT_EQ(everything.rate, 1.25);
  EXPECT_EQ(everything.given, 4);
  EXPECT_EQ(everything.title, "plain");
}

TEST(Reading, CollectedDefaultsReadBackAsTheyWere) {
  Everything source;
  source.rate = 0.125;
  source.count = 99;
  source.on = false;
  source.mode = "share";
  source.numbers = {};
  source.skills = {{"a", 1}};
  source.inner = {.depth = 12, .open = false};
  Describe d;
  source.describe(d);
  std::vector<Value> fields;
  for (const ParameterInfo& info : d.parameters()) {
    if (info.fallback.kind == ParameterKind::none) continue;
    fields.push_back(info.fallback);
    fields.back().key = info.name;
  }
  Tree t;
  const Value values = t.of(ParameterKind::group, fields);
  Everything target;
  Describe reader(values);
  target.describe(reader);
  EXPECT_EQ(target.rate, 0.125);
  EXPECT_EQ(target.count, 99);
  EXPECT_FALSE(target.on);
  EXPECT_EQ(target.mode, "share");
  EXPECT_TRUE(target.numbers.empty());
  EXPECT_EQ(target.skills, source.skills);
  EXPECT_EQ(target.inner.depth, 12);
  EXPECT_FALSE(target.inner.open);
}

TEST(Reading, DefaultListOfGroupsReadsBackElementByElement) {
  struct Row {
    std::vector<Inner> holes;
    void describe(Describe& d) { d.list("holes", holes, "Holes"); }
  };
  Row source{.holes = {{.depth = 1, .open = true}, {.depth = 2, .open = false}}};
  Describe d;
  source.describe(d);
  ASSERT_EQ(d.parameters().size(), 1u);
  Value holes = d.parameters()[0].fallback;
  ASSERT_EQ(holes.count, 2u);
  holes.key = "holes";
  Tree t;
  const Value values = t.of(ParameterKind::group, {holes});
  Row target;
  Describe reader(values);
  target.describe(reader);
  ASSERT_EQ(target.holes.size(), 2u);
  EXPECT_EQ(target.holes[0].depth, 1);
  EXPECT_TRUE(target.holes[0].open);
  EXPECT_EQ(target.holes[1].depth, 2);
  EXPECT_FALSE(target.holes[1].open);
}

}  // namespace
}  // namespace somas
