// One test a message: the exact place, key and text.
#include "core/experiment/validate.hpp"

#include <gmock/gmock.h>

#include "core/experiment/keys.hpp"
#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class Messages : public Files {
 protected:
  // The complaint about a parameter of toy_parameters, in line 3 from column 5.
  std::string about_parameter(const std::string& line) const {
    return complaint("environments:\n  toy_parameters:\n    " + line +
                     "\nspecialization: {plugin: toy_tree}\n"
                     "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n");
  }
  std::string about_world(const std::string& line) const {
    return complaint("world:\n  " + line + "\n" + blocks);
  }
};

TEST_F(Messages, UnknownKey) {
  EXPECT_EQ(
      about_world("raduis: 5"),
      "e.yaml:2:3: world.raduis: unknown key; allowed: radius, max_steps, max_cells, "
      "warm_up_steps, morphogens, mechanics, metabolism, strangers, cycle; did you mean 'radius'?");
  EXPECT_EQ(about_parameter("nummer: 5"),
            "e.yaml:3:5: environments.toy_parameters.nummer: unknown key; allowed: number, maybe, "
            "integer, flag, text, word, numbers, table, inner, list, fault, plugin; did you mean "
            "'number'?");
  EXPECT_EQ(complaint("wurld: {}\n" + blocks),
            "e.yaml:1:1: wurld: unknown key; allowed: somas, name, seed, replicates, world, "
            "evolution, record, "
            "extends, sweep, "
            "plugins, environments, specialization, controller, fitness; did you mean 'world'?");
  EXPECT_EQ(about_world("morphogens: {kinds: [{}, {evaporate: 1}]}"),
            "e.yaml:2:29: world.morphogens.kinds[1].evaporate: unknown key; allowed: attenuation, "
            "evaporation; did you mean 'evaporation'?");
}

TEST_F(Messages, WrongTypeOfNumber) {
  EXPECT_EQ(about_world("radius: wide"),
            "e.yaml:2:11: world.radius: expected a number, found 'wide'");
  EXPECT_EQ(about_world("radius: [1]"),
            "e.yaml:2:11: world.radius: expected a number, found a list");
  EXPECT_EQ(about_world("radius: {a: 1}"),
            "e.yaml:2:11: world.radius: expected a number, found a mapping");
  EXPECT_EQ(about_world("radius: '5'"),
            "e.yaml:2:11: world.radius: expected a number, found the text '5'; remove the quotes");
  EXPECT_EQ(about_world("radius: 0x10"),
            "e.yaml:2:11: world.radius: expected a number, found '0x10'");
}

TEST_F(Messages, WrongTypeOfInteger) {
  EXPECT_EQ(about_world("max_steps: 1.5"),
            "e.yaml:2:14: world.max_steps: expected an integer, found '1.5'");
  EXPECT_EQ(about_world("max_steps: 1e3"),
            "e.yaml:2:14: world.max_steps: expected an integer, found '1e3'; write 1000");
  EXPECT_EQ(about_world("max_steps: 20.0"),
            "e.yaml:2:14: world.max_steps: expected an integer, found '20.0'; write 20");
  EXPECT_EQ(complaint("seed: 99999999999999999999\n" + blocks),
            "e.yaml:1:7: seed: 99999999999999999999 is beyond 64 bits; allowed: 0 to "
            "9223372036854775807");
}

TEST_F(Messages, WrongTypeOfBoolean) {
  const std::string start = "e.yaml:3:11: environments.toy_parameters.flag: expected true or false";
  EXPECT_EQ(about_parameter("flag: yes"), start + ", found 'yes'");
  EXPECT_EQ(about_parameter("flag: 1"), start + ", found '1'");
  EXPECT_EQ(about_parameter("flag: 'true'"), start + ", found the text 'true'; remove the quotes");
}

TEST_F(Messages, WrongTypeOfText) {
  EXPECT_EQ(about_parameter("text: 12"),
            "e.yaml:3:11: environments.toy_parameters.text: expected a text, found '12'; put it in "
            "quotes");
  EXPECT_EQ(about_parameter("text: [a]"),
            "e.yaml:3:11: environments.toy_parameters.text: expected a text, found a list");
}

TEST_F(Messages, WrongTypeOfListGroupAndTable) {
  const std::string start = "environments.toy_parameters.";
  EXPECT_EQ(
      about_parameter("numbers: 3"),
      "e.yaml:3:14: " + start +
          "numbers: expected a list, found '3'; write [a, b] or a line '- a' for each element");
  EXPECT_EQ(about_parameter("numbers: [1, x]"),
            "e.yaml:3:18: " + start + "numbers[1]: expected a number, found 'x'");
  EXPECT_EQ(about_parameter("inner: 3"),
            "e.yaml:3:12: " + start + "inner: expected a mapping, found '3'");
  EXPECT_EQ(about_parameter("table: [1]"),
            "e.yaml:3:12: " + start + "table: expected a mapping, found a list");
  EXPECT_EQ(about_parameter("table: {b: -1}"),
            "e.yaml:3:16: " + start + "table.b: -1 is out of range; allowed: at least 0");
}

TEST_F(Messages, OutOfRange) {
  EXPECT_EQ(about_world("radius: 0"),
            "e.yaml:2:11: world.radius: 0 is out of range; allowed: 0.001 to 1000000 [length]");
  EXPECT_EQ(about_parameter("number: 11"),
            "e.yaml:3:13: environments.toy_parameters.number: 11 is out of range; allowed: 0 to 10 "
            "[1/step]");
  EXPECT_EQ(
      about_parameter("integer: -6"),
      "e.yaml:3:14: environments.toy_parameters.integer: -6 is out of range; allowed: -5 to 5");
  EXPECT_EQ(complaint("somas: 2\n" + blocks), "e.yaml:1:8: somas: 2 is out of range; allowed: 1");
}

TEST_F(Messages, NotFinite) {
  EXPECT_EQ(about_world("radius: .nan"),
            "e.yaml:2:11: world.radius: '.nan' is not a finite number; allowed: 0.001 to "
            "1000000 [length]");
  for (const char* word : {"nan", "NaN", ".inf", "-.inf", "inf", "Infinity", "+.INF"})
    EXPECT_THAT(about_world(std::string("radius: ") + word), HasSubstr("is not a finite number"));
  EXPECT_EQ(about_world("radius: 1e999"),
            "e.yaml:2:11: world.radius: 1e999 is beyond what a double can hold");
}

TEST_F(Messages, NotAChoice) {
  EXPECT_EQ(
      about_world("morphogens: {deposit: peek}"),
      "e.yaml:2:25: world.morphogens.deposit: 'peek' is not among the choices; allowed: peak, "
      "share; did you mean 'peak'?");
  EXPECT_EQ(about_parameter("word: [peak]"),
            "e.yaml:3:11: environments.toy_parameters.word: expected one of peak, share, found a "
            "list");
}

TEST_F(Messages, Null) {
  EXPECT_EQ(about_world("radius:"),
            "e.yaml:3:1: world.radius: expected a number, found nothing (null)");
  EXPECT_EQ(about_world("radius: ~"),
            "e.yaml:2:11: world.radius: expected a number, found nothing (null)");
  EXPECT_EQ(about_world("cycle: null"),
            "e.yaml:2:10: world.cycle: expected a mapping, found nothing (null); write {} for all "
            "defaults");
}

TEST_F(Messages, MissingRequiredParameter) {
  EXPECT_EQ(complaint("specialization:\n  plugin: toy_tree\n  states:\n    - production: 3\n"
                      "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n"),
            "e.yaml:4:7: specialization.states[0].name: missing; expected a text: Name of the "
            "state");
}

TEST_F(Messages, EvenMorphogenGrid) {
  EXPECT_EQ(about_world("morphogens: {size: 64}"),
            "e.yaml:2:22: world.morphogens.size: 64 is even; allowed: odd numbers, so that one "
            "square is at the centre");
}

TEST_F(Messages, SeveralAtOnce) {
  EXPECT_EQ(complaint("seed: x\nworld:\n  radius: -1\n  max_steps: y\n" + blocks),
            "e.yaml:1:7: seed: expected an integer, found 'x'\n"
            "e.yaml:3:11: world.radius: -1 is out of range; allowed: 0.001 to 1000000 [length]\n"
            "e.yaml:4:14: world.max_steps: expected an integer, found 'y'");
  std::string many = "world:\n";
  for (int i = 0; i < 15; ++i) many += "  key" + std::to_string(i) + ": 1\n";
  EXPECT_THAT(complaint(many + blocks), testing::EndsWith("\n(and 5 more)"));
}

TEST_F(Messages, KnowTheirFirstPosition) {
  try {
    load_toy(write("e.yaml", "world: {radius: x}\n" + blocks));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.position().line, 1u);
    EXPECT_EQ(error.position().column, 17u);
  }
}

TEST(KeysReference, ListsEveryCoreKey) {
  const std::string text = keys_reference();
  for (const char* row :
       {"| `environments` | mapping | `{}` |", "| `seed` | integer | `1` | at least 0 |",
        "| `world.max_steps` | integer | `3000` | 1 to 1000000000 [steps] |",
        "| `world.morphogens.kinds[].attenuation` | number |", "| `evolution.trials` | integer |"})
    EXPECT_THAT(text, HasSubstr(row));
}

}  // namespace
}  // namespace somas::experiment
