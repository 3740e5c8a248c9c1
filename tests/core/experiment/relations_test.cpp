// Relations between parameters, and the kinds beyond the plain ones: what is taken, and what is
// said of the rest.
#include <gmock/gmock.h>

#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string rest =
    "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
    "fitness: {plugin: toy_fitness}\n";

class Relations : public Files {
 protected:
  static std::string file_of(const std::string& lines) {
    return "environments:\n  toy_relations:\n" + lines + rest;
  }
  std::string about(const std::string& lines) const { return complaint(file_of(lines)); }
  // The names of what the plugin declared: it tells what it was given.
  std::string declared(const std::string& lines) const {
    std::string names;
    const Experiment experiment = load_toy(write("e.yaml", file_of(lines)));
    for (const model::Scalar& scalar : experiment.ecosystem->schema().scalars)
      names += scalar.name + "=" + std::to_string(static_cast<int>(scalar.initial)) + " ";
    return names;
  }
};

TEST_F(Relations, AtMostNamesBothKeysAndPlaces) {
  EXPECT_EQ(about("    low: 5\n    high: 3\n"),
            "e.yaml:3:10: environments.toy_relations.low: 5 is more than "
            "environments.toy_relations.high, 3 (e.yaml:4:11); allowed: at most high");
  EXPECT_EQ(about("    low: 5\n"),
            "e.yaml:3:10: environments.toy_relations.low: 5 is more than "
            "environments.toy_relations.high, by default 2; allowed: at most high");
  EXPECT_EQ(about("    high: 0.5\n"),
            "e.yaml:3:11: environments.toy_relations.low: 1 is more than "
            "environments.toy_relations.high, 0.5 (e.yaml:3:11); allowed: at most high");
  EXPECT_EQ(about("    low: 2\n"), "") << "equal is allowed";
}

TEST_F(Relations, HoldAcrossFiles) {
  write("base.yaml", file_of("    low: 5\n    high: 6\n"));
  EXPECT_EQ(complaint("extends: base.yaml\nenvironments: {toy_relations: {high: 4}}\n"),
            "base.yaml:3:10: environments.toy_relations.low: 5 is more than "
            "environments.toy_relations.high, 4 (e.yaml:2:38); allowed: at most high");
}

TEST_F(Relations, LessThanHoldsInGroupsAndLists) {
  EXPECT_EQ(about("    inner: {from: 1}\n"),
            "e.yaml:3:19: environments.toy_relations.inner.from: 1 is not less than "
            "environments.toy_relations.inner.to, by default 1; allowed: less than to");
  EXPECT_EQ(about("    spans: [{}, {from: 3, to: 2}]\n"),
            "e.yaml:3:24: environments.toy_relations.spans[1].from: 3 is not less than "
            "environments.toy_relations.spans[1].to, 2 (e.yaml:3:31); allowed: less than to");
}

TEST_F(Relations, DiffersComparesTexts) {
  EXPECT_EQ(about("    second: a\n"),
            "e.yaml:3:13: environments.toy_relations.first: a is the same as "
            "environments.toy_relations.second, a (e.yaml:3:13); the two must differ");
}

TEST_F(Relations, NeedsAsksForTheOther) {
  EXPECT_EQ(about("    label: many\n"),
            "e.yaml:3:5: environments.toy_relations.label: needs "
            "environments.toy_relations.count, which is left out; give both or neither");
  EXPECT_EQ(about("    label: many\n    count: 3\n"), "");
  EXPECT_EQ(about("    count: 3\n"), "") << "the other needs nothing";
  EXPECT_THAT(about("    loud: true\n"), HasSubstr("loud: needs"));
  EXPECT_EQ(about("    loud: false\n"), "");
  EXPECT_EQ(about("    loud: true\n    voice: deep\n"), "");
}

TEST_F(Relations, ExcludesRefusesBoth) {
  EXPECT_EQ(about("    rate: 2\n    period: 3\n"),
            "e.yaml:3:5: environments.toy_relations.rate: cannot stand beside "
            "environments.toy_relations.period, 3 (e.yaml:4:13); give one of the two");
  EXPECT_EQ(about("    rate: 2\n"), "");
}

TEST_F(Relations, WordsDecideWhatBelongs) {
  EXPECT_EQ(about("    shape: box\n    radius: 1\n"),
            "e.yaml:4:5: environments.toy_relations.radius: allowed only when shape is disc; there "
            "is environments.toy_relations.shape, box (e.yaml:3:12)");
  EXPECT_EQ(about("    radius: 1\n"),
            "e.yaml:3:5: environments.toy_relations.radius: allowed only when shape is disc; there "
            "is environments.toy_relations.shape, by default point");
  EXPECT_EQ(about("    shape: disc\n"),
            "e.yaml:3:5: environments.toy_relations.radius: missing; required by "
            "environments.toy_relations.shape, disc (e.yaml:3:12): Of a disc");
  EXPECT_EQ(about("    shape: box\n    width: 1\n"), "");
  EXPECT_THAT(about("    width: 1\n"), HasSubstr("only when shape is disc or box"));
}

TEST_F(Relations, AreNotToldOfAFieldThatIsWrongAlready) {
  EXPECT_EQ(about("    low: 5\n    high: much\n"),
            "e.yaml:4:11: environments.toy_relations.high: expected a number, found 'much'");
}

TEST_F(Relations, ListsHaveTheirNumberOfElements) {
  EXPECT_EQ(about("    ranks: [1]\n"),
            "e.yaml:3:12: environments.toy_relations.ranks: 1 element; allowed: 2 to 4 elements");
  EXPECT_EQ(about("    modes: []\n"),
            "e.yaml:3:12: environments.toy_relations.modes: 0 elements; allowed: at least 1 "
            "element");
  EXPECT_EQ(about("    spans: [{}, {}, {}]\n"),
            "e.yaml:3:12: environments.toy_relations.spans: 3 elements; allowed: at most 2 "
            "elements");
}

TEST_F(Relations, ElementsOfListsHaveTheirKind) {
  EXPECT_THAT(about("    ranks: [1, 2.5]\n"), HasSubstr("ranks[1]: expected an integer"));
  EXPECT_THAT(about("    ranks: [1, 10]\n"), HasSubstr("ranks[1]: 10 is out of range"));
  EXPECT_THAT(about("    names: [a, 2]\n"), HasSubstr("names[1]: expected a text"));
  EXPECT_THAT(about("    flags: [true, 1]\n"), HasSubstr("flags[1]: expected true or false"));
  EXPECT_THAT(about("    modes: [fats]\n"),
              HasSubstr("modes[0]: 'fats' is not among the choices; allowed: slow, fast; did you "
                        "mean 'fast'?"));
}

TEST_F(Relations, ValuesOfEveryKindReachThePlugin) {
  EXPECT_EQ(declared("    {}\n"), "count=-1 label.none=0 shape=0 rank.1=0 rank.2=0 mode.slow=0 ");
  EXPECT_EQ(declared("    count: 7\n    label: many\n    shape: box\n    ranks: [4, 5, 6]\n"
                     "    names: [x, y]\n    modes: [fast, slow]\n    flags: [true, false]\n"),
            "count=7 label.many=0 shape=2 rank.4=0 rank.5=0 rank.6=0 name.x=0 name.y=0 "
            "mode.fast=0 mode.slow=0 flag.0=1 flag.1=0 ");
}

}  // namespace
}  // namespace somas::experiment
