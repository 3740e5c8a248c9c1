#include "core/experiment/overlay.hpp"

#include <gmock/gmock.h>

#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class Extends : public Files {};

TEST_F(Extends, MergesMappingsAndReplacesTheRest) {
  write("base.yaml",
        "seed: 5\nworld:\n  radius: 30\n  max_steps: 10\n  morphogens:\n    kinds: [{}, {}]\n" +
            blocks);
  const Experiment merged = load_toy(
      write("e.yaml", "extends: base.yaml\nworld: {max_steps: 20, morphogens: {kinds: [{}]}}\n"));
  EXPECT_EQ(merged.seed, 5u);
  EXPECT_EQ(merged.ecosystem->config().radius, 30);
  EXPECT_EQ(merged.ecosystem->config().max_steps, 20u);
  EXPECT_EQ(merged.ecosystem->config().morphogens.kinds.size(), 1u);
  EXPECT_THAT(merged.resolved_yaml, Not(HasSubstr("extends")));
}

TEST_F(Extends, DoesNotInheritTheName) {
  write("base.yaml", "name: basis\n" + blocks);
  EXPECT_EQ(load_toy(write("derived.yaml", "extends: base.yaml\n")).name, "derived");
  EXPECT_EQ(load_toy(directory_ / "base.yaml").name, "basis");
}

TEST_F(Extends, IsRelativeToItsFileAndMayChain) {
  write("deep/base.yaml", "world: {radius: 7}\n" + blocks);
  write("deep/middle.yaml", "extends: base.yaml\nworld: {max_steps: 8}\n");
  const Experiment chained = load_toy(write("e.yaml", "extends: deep/middle.yaml\n"));
  EXPECT_EQ(chained.ecosystem->config().radius, 7);
  EXPECT_EQ(chained.ecosystem->config().max_steps, 8u);
}

TEST_F(Extends, ReplacesABlockWhosePluginDiffers) {
  write("base.yaml",
        "environments:\n  first: {plugin: toy_environment, content: 3}\n"
        "specialization: {plugin: toy_tree}\n"
        "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n");
  // The same plugin merges, another one starts from its own defaults.
  EXPECT_THAT(load_toy(write("e.yaml", "extends: base.yaml\nenvironments:\n  first: {hazard: 1}\n"))
                  .resolved_yaml,
              HasSubstr("    content: 3\n    regeneration: 0.1\n    hazard: 1\n"));
  EXPECT_THAT(
      load_toy(
          write("e.yaml", "extends: base.yaml\nenvironments:\n  first: {plugin: toy_parameters}\n"))
          .resolved_yaml,
      Not(HasSubstr("content")));
}

TEST_F(Extends, RemovesAnEnvironmentThatIsNull) {
  write("base.yaml", blocks);
  const Experiment without =
      load_toy(write("e.yaml", "extends: base.yaml\nenvironments:\n  toy_environment:\n"));
  EXPECT_TRUE(without.ecosystem->environments().empty());
  EXPECT_EQ(complaint("environments:\n  toy_environment:\nspecialization: {plugin: toy_tree}\n"
                      "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n"),
            "e.yaml:2:3: environments.toy_environment: null removes an inherited environment, but "
            "none is inherited; write {} for all defaults");
}

TEST_F(Extends, KeepsThePlaceWhereAValueStands) {
  write("base.yaml", "world:\n  radius: -1\n" + blocks);
  EXPECT_THAT(complaint("extends: base.yaml\nworld: {max_steps: 0}\n"),
              testing::AllOf(StartsWith("base.yaml:2:11: world.radius: -1 is out of range"),
                             HasSubstr("\ne.yaml:2:20: world.max_steps: 0 is out of range")));
}

TEST_F(Extends, RefusesACycleNamingTheChain) {
  write("a.yaml", "extends: b.yaml\n");
  write("b.yaml", "seed: 1\nextends: a.yaml\n");
  EXPECT_EQ(complaint("extends: a.yaml\n"),
            "b.yaml:2:10: extends: a cycle: e.yaml -> a.yaml -> b.yaml -> a.yaml");
  EXPECT_EQ(complaint_of(write("self.yaml", "extends: self.yaml\n")),
            "self.yaml:1:10: extends: a cycle: self.yaml -> self.yaml");
}

TEST_F(Extends, SaysWhichFileIsMissing) {
  EXPECT_EQ(complaint("extends: none.yaml\n"), "e.yaml:1:10: extends: none.yaml: no such file");
  EXPECT_EQ(complaint("extends: [a]\n"),
            "e.yaml:1:10: extends: expected a file's name, found a list");
}

class Overrides : public Files {
 protected:
  std::string resolved(std::vector<std::string> overrides) const {
    return load_toy(write("e.yaml", blocks), std::move(overrides)).resolved_yaml;
  }
  std::string refused(const std::string& assignment) const {
    return complaint(blocks, {assignment});
  }
};

TEST_F(Overrides, ApplyInOrderAndCreateWhatIsMissing) {
  const std::string text = resolved({"world.radius=12", "world.radius=13", "seed=9", "name=other"});
  EXPECT_THAT(text, HasSubstr("  radius: 13\n"));
  EXPECT_THAT(text, HasSubstr("seed: 9\n"));
  EXPECT_THAT(text, HasSubstr("name: other\n"));
}

TEST_F(Overrides, GoThroughEnvironmentsAndTakeYaml) {
  EXPECT_THAT(resolved({"environments.toy_environment.hazard=2"}), HasSubstr("    hazard: 2\n"));
  EXPECT_THAT(resolved({"environments.toy_environment={hazard: 3, mode: nowhere}"}),
              HasSubstr("    mode: nowhere\n"));
  EXPECT_THAT(resolved({"environments.toy_environment=null"}), HasSubstr("environments: {}\n"));
}

TEST_F(Overrides, ReachElementsOfLists) {
  const std::string element = "      - attenuation: 0.7\n        evaporation: 0.05\n";
  // The default, and a list that the file gives.
  EXPECT_THAT(resolved({"world.morphogens.kinds.0.attenuation=0.7"}), HasSubstr(element));
  EXPECT_THAT(load_toy(write("l.yaml", "world: {morphogens: {kinds: [{}, {}]}}\n" + blocks),
                       {"world.morphogens.kinds.1.attenuation=0.7"})
                  .resolved_yaml,
              HasSubstr(element));
}

TEST_F(Overrides, ChooseAPluginBeforeItsParameters) {
  const std::string text = resolved({"environments.toy_environment.number=2",
                                     "environments.toy_environment.plugin=toy_parameters"});
  EXPECT_THAT(text, HasSubstr("  toy_environment:\n    plugin: toy_parameters\n    number: 2\n"));
}

TEST_F(Overrides, NameTheEnvironmentThatWasMeant) {
  EXPECT_EQ(refused("environments.toy_enviroment.hazard=0"),
            "--set environments.toy_enviroment.hazard=0: environments.toy_enviroment: there is no "
            "such environment; have: toy_environment; did you mean 'toy_environment'? (a new one "
            "needs its plugin: --set environments.toy_enviroment.plugin=ID)");
  // Nothing near in use, but a plugin is.
  EXPECT_EQ(refused("environments.toy_paramters={number: 2}"),
            "--set environments.toy_paramters={number: 2}: environments.toy_paramters: there is no "
            "such environment; have: toy_environment; did you mean 'toy_parameters'? (a new one "
            "needs its plugin: --set environments.toy_paramters.plugin=ID)");
  // One that the file names keeps the message of its plugin.
  EXPECT_THAT(complaint("environments:\n  field: {plugin: toy_environment}\n" + blocks.substr(36),
                        {"environments.field={hazard: 1}"}),
              HasSubstr("no environment 'field'; available: toy_environment"));
}

TEST_F(Overrides, AddAnEnvironment) {
  // By the name of its plugin, or by a name of its own.
  EXPECT_THAT(resolved({"environments.toy_parameters.number=2"}),
              HasSubstr("  toy_parameters:\n    plugin: toy_parameters\n    number: 2\n"));
  EXPECT_THAT(resolved({"environments.other.number=2", "environments.other.plugin=toy_parameters"}),
              HasSubstr("  other:\n    plugin: toy_parameters\n    number: 2\n"));
}

TEST_F(Overrides, NameUnknownPaths) {
  EXPECT_EQ(refused("world.raduis=5"),
            "--set world.raduis=5: world.raduis: unknown key; allowed: radius, max_steps, "
            "max_cells, warm_up_steps, morphogens, mechanics, metabolism, strangers, cycle; did "
            "you mean 'radius'?");
  EXPECT_EQ(refused("world.morphogens.kinds.3.attenuation=0"),
            "--set world.morphogens.kinds.3.attenuation=0: world.morphogens.kinds.3: no such "
            "element; the list has 3");
  EXPECT_EQ(complaint("world: {morphogens: {kinds: [{}]}}\n" + blocks,
                      {"world.morphogens.kinds.1.attenuation=0"}),
            "--set world.morphogens.kinds.1.attenuation=0: world.morphogens.kinds: a list of 1 "
            "element (0 to 0), '1' is none of them");
  EXPECT_EQ(refused("environments.toy_enviroment=null"),
            "--set environments.toy_enviroment=null: environments.toy_enviroment: there is no such "
            "environment; have: toy_environment; did you mean 'toy_environment'?");
  EXPECT_EQ(refused("controller.plugin.x=1"),
            "--set controller.plugin.x=1: controller.plugin: is 'toy_controller', there is no 'x' "
            "below it");
}

TEST_F(Overrides, RefuseWhatIsNoAssignment) {
  EXPECT_EQ(refused("world"), "--set world: expected path.to.key=value");
  EXPECT_EQ(refused("=3"), "--set =3: expected path.to.key=value");
  EXPECT_EQ(refused("world..radius=3"),
            "--set world..radius=3: world..radius: a part of the path is empty");
  EXPECT_THAT(refused("world=[1"), StartsWith("--set world=[1: not valid YAML: "));
  EXPECT_EQ(refused("seed="), "--set seed=: seed: expected an integer, found nothing (null)");
}

TEST_F(Overrides, RefuseBadValuesLikeFiles) {
  EXPECT_EQ(refused("world.radius=0"),
            "--set world.radius=0: world.radius: 0 is out of range; allowed: 0.001 to "
            "1000000 [length]");
}

}  // namespace
}  // namespace somas::experiment
