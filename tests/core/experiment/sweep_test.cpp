// What a file and the command line say of a campaign, and what is refused.
#include "core/experiment/sweep.hpp"

#include <gmock/gmock.h>

#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class Sweep : public Files {
 protected:
  std::optional<Design> design(const std::string& text, DesignOptions options = {}) const {
    return read_design(write("e.yaml", text), options);
  }
  std::string complaint(const std::string& text, DesignOptions options = {}) const {
    try {
      static_cast<void>(design(text, std::move(options)));
      return "";
    } catch (const InputError& error) {
      std::string message = error.what();
      const std::string prefix = directory_.string() + "/";
      for (std::size_t at; (at = message.find(prefix)) != std::string::npos;)
        message.erase(at, prefix.size());
      return message;
    }
  }
  static std::vector<std::string> values(const Factor& factor) {
    std::vector<std::string> values;
    for (const Level& level : factor.levels) values.push_back(level.value);
    return values;
  }
};

TEST_F(Sweep, IsNoneWhereNobodySaysSo) {
  EXPECT_FALSE(design("seed: 3\n").has_value());
  EXPECT_TRUE(design("seed: 3\n", {.always = true})->is_one_run());
  EXPECT_TRUE(design("replicates: 1\nsweep: {}\n")->is_one_run());
}

TEST_F(Sweep, HasReplicatesAndFactorsInTheOrderOfTheFile) {
  const Design read = *design(
      "name: n\nseed: 7\nreplicates: 3\n"
      "sweep:\n  evolution.mutation: [0.2, 0.5]\n  world.radius: [10, 20, 30]\n");
  EXPECT_EQ(read.name, "n");
  EXPECT_EQ(read.seed, 7u);
  EXPECT_EQ(read.replicates, 3u);
  EXPECT_EQ(read.conditions(), 6u);
  ASSERT_EQ(read.factors.size(), 2u);
  EXPECT_EQ(read.factors[0].name, "evolution.mutation");
  EXPECT_THAT(values(read.factors[0]), ElementsAre("0.2", "0.5"));
  EXPECT_EQ(read.factors[0].levels[1].sets[0].text, "evolution.mutation=0.5");
  EXPECT_EQ(read.factors[0].levels[1].sets[0].position.line, 5u);
  EXPECT_THAT(values(read.factors[1]), ElementsAre("10", "20", "30"));
}

TEST_F(Sweep, LevelsMayBeAnyValue) {
  const Design read = *design(
      "sweep:\n"
      "  environments.walls: [null, {}, {plugin: walls, points: [1, 'a, b']}]\n"
      "  controller.table: [{a.b: 1}, \"text\", '5', true]\n");
  EXPECT_THAT(values(read.factors[0]),
              ElementsAre("null", "{}", "{plugin: walls, points: [1, \"a, b\"]}"));
  EXPECT_THAT(values(read.factors[1]), ElementsAre("{a.b: 1}", "text", "\"5\"", "true"));
}

TEST_F(Sweep, NamedLevelsSetSeveralKeys) {
  const Design read = *design(
      "sweep:\n"
      "  design:\n"
      "    plain: {}\n"
      "    rich: {world.radius: 30, controller.plugin: ctrnn}\n");
  EXPECT_EQ(read.factors[0].name, "design");
  EXPECT_THAT(values(read.factors[0]), ElementsAre("plain", "rich"));
  EXPECT_TRUE(read.factors[0].levels[0].sets.empty());
  EXPECT_EQ(read.factors[0].levels[1].sets[1].text, "controller.plugin=ctrnn");
}

TEST_F(Sweep, TheCommandLineReplacesAFactorInItsPlaceOrAddsOne) {
  const Design read =
      *design("sweep: {evolution.mutation: [0.1], world.radius: [10, 20]}\n",
              {.overrides = {"replicates=4"},
               .sweeps = {"evolution.mutation=0.3,0.4", "controller.list=[1, 2],[3]"}});
  EXPECT_EQ(read.replicates, 4u);
  EXPECT_EQ(read.factors[0].name, "evolution.mutation");
  EXPECT_THAT(values(read.factors[0]), ElementsAre("0.3", "0.4"));
  EXPECT_EQ(read.factors[1].name, "world.radius");
  EXPECT_THAT(values(read.factors[2]), ElementsAre("[1, 2]", "[3]"));
}

TEST_F(Sweep, TheCommandLineChoosesNamedLevels) {
  const std::string text = "sweep: {size: {small: {world.radius: 9}, large: {world.radius: 90}}}\n";
  const Design read = *design(text, {.sweeps = {"size=large"}});
  EXPECT_THAT(values(read.factors[0]), ElementsAre("large"));
  EXPECT_EQ(read.factors[0].levels[0].sets[0].text, "world.radius=90");
  EXPECT_THAT(complaint(text, {.sweeps = {"size=lrage"}}),
              HasSubstr("size: has no level 'lrage'; have: small, large; did you mean 'large'?"));
  EXPECT_THAT(complaint(text, {.sweeps = {"size=large,large"}}),
              HasSubstr("large is a level already"));
}

TEST_F(Sweep, IsInheritedAndNullRemovesAFactor) {
  write("base.yaml", "replicates: 2\nsweep: {evolution.mutation: [0.1, 0.2], world.radius: [1]}\n");
  const Design read =
      *design("extends: base.yaml\nsweep: {world.radius: null, evolution.crossover: [0, 1]}\n");
  EXPECT_EQ(read.replicates, 2u);
  EXPECT_EQ(read.conditions(), 4u);
  EXPECT_EQ(read.factors[1].name, "evolution.crossover");
}

TEST_F(Sweep, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(complaint("replicates: 0\n"),
            "e.yaml:1:13: replicates: 0 is out of range; allowed: 1 to 10000 [runs]");
  EXPECT_THAT(complaint("sweep: [1]\n"),
              StartsWith("e.yaml:1:8: sweep: expected a mapping of factors"));
  EXPECT_THAT(complaint("sweep:\n  evolution.mutation: 0.5\n"),
              StartsWith("e.yaml:2:23: sweep.evolution.mutation: expected a list of levels"));
  EXPECT_EQ(complaint("sweep:\n  evolution.mutation: []\n"),
            "e.yaml:2:23: sweep.evolution.mutation: no levels; a factor has one at least");
  EXPECT_EQ(complaint("sweep:\n  evolution.mutation: [0.5, 0.2, 0.50]\n"),
            "e.yaml:2:34: sweep.evolution.mutation: 0.50 is a level already (e.yaml:2:24)");
  EXPECT_THAT(complaint("sweep:\n  evolutoin.mutation: [1]\n"),
              AllOf(StartsWith("e.yaml:2:3: sweep.evolutoin.mutation: no key of an experiment "
                               "begins with 'evolutoin'"),
                    HasSubstr("did you mean 'evolution'?")));
  EXPECT_EQ(complaint("sweep:\n  seed: [1, 2]\n"),
            "e.yaml:2:3: sweep.seed: 'seed' cannot be swept; 'replicates: N' runs N seeds");
  EXPECT_THAT(complaint("sweep:\n  world..radius: [1, 2]\n"),
              HasSubstr("a part of the path is empty"));
  // Nested as in the file itself: likely, and wrong.
  EXPECT_THAT(complaint("sweep:\n  evolution:\n    mutation: [0.1, 0.2]\n"),
              HasSubstr("levels of one key: 'evolution.mutation: [VALUE, ...]'"));
  EXPECT_THAT(complaint("sweep:\n  best: {a: {}, b: {world.radius: 3}}\n"),
              HasSubstr("a column of index.csv or summary.csv has this name"));
  EXPECT_THAT(complaint("sweep:\n  controller: [{plugin: a}]\n  controller.gain: [1, 2]\n"),
              AllOf(StartsWith("e.yaml:3:3: sweep.controller.gain: sets controller.gain"),
                    HasSubstr("(e.yaml:2:3); a key belongs to one factor")));
  EXPECT_THAT(complaint("seed: 9223372036854775800\nreplicates: 100\n"),
              StartsWith("e.yaml:1:7: seed: leaves no seeds for 100 replicates"));
  EXPECT_THAT(complaint("replicates: 9999\nsweep: {world.radius: [1, 2]}\n"),
              HasSubstr("more than 10000 runs"));
}

TEST_F(Sweep, SaysWhatIsWrongOnTheCommandLine) {
  const auto by_hand = [&](const std::string& sweep) {
    return complaint("seed: 1\n", {.sweeps = {sweep}});
  };
  EXPECT_THAT(by_hand("world.radius"), HasSubstr("expected KEY=VALUE,VALUE,..."));
  EXPECT_THAT(by_hand("world.radius="), HasSubstr("no levels"));
  EXPECT_THAT(by_hand("world.radius=1,1.0"), HasSubstr("1.0 is a level already"));
  EXPECT_THAT(by_hand("wrold.radius=1"), HasSubstr("did you mean 'world'?"));
  EXPECT_THAT(complaint("seed: 1\n", {.sweeps = {"world.radius=1", "world.radius=2"}}),
              HasSubstr("was swept before"));
  EXPECT_THAT(complaint("sweep: {world.radius: [1, 2]}\n", {.overrides = {"world.radius=3"}}),
              AllOf(StartsWith("--set world.radius=3: world.radius: the sweep sets it"),
                    HasSubstr("--single leaves the sweep out")));
  EXPECT_THAT(complaint("seed: 1\n", {.overrides = {"sweep={}"}}), HasSubstr("use --sweep"));
}

}  // namespace
}  // namespace somas::experiment
