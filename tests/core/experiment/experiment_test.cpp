#include "core/experiment/experiment.hpp"

#include <gmock/gmock.h>

#include "core/model/simulation.hpp"
#include "core/plugins/describe.hpp"
#include "core/plugins/registry.hpp"
#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

const std::filesystem::path bundled = SOMAS_BINARY_DIR "/plugins";
const std::filesystem::path experiments = SOMAS_SOURCE_DIR "/experiments";

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class Load : public Files {
 protected:
  // Toy blocks with one environment of toy_parameters; `line` is line 4, from column 5.
  static std::string with_parameters(const std::string& line) {
    return "environments:\n  probe:\n    plugin: toy_parameters\n    " + line +
           "\nspecialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
           "fitness: {plugin: toy_fitness}\n";
  }
  static double scalar(const Experiment& experiment, const std::string& name) {
    for (const model::Scalar& scalar : experiment.ecosystem->schema().scalars)
      if (scalar.name == name) return scalar.initial;
    ADD_FAILURE() << "no scalar " << name;
    return 0;
  }
};

TEST_F(Load, GivesAWiredExperiment) {
  const std::string text = "seed: 7\nevolution: {population: 10}\n" + blocks;
  const Experiment loaded = load_toy(write("first.yaml", text));
  EXPECT_EQ(loaded.name, "first");
  EXPECT_EQ(loaded.seed, 7u);
  EXPECT_EQ(loaded.evolution.population, 10u);
  EXPECT_EQ(loaded.original_yaml, text);
  ASSERT_NE(loaded.ecosystem, nullptr);
  ASSERT_EQ(loaded.ecosystem->environments().size(), 1u);
  EXPECT_EQ(loaded.ecosystem->environments()[0].name, "toy_environment");
  EXPECT_EQ(loaded.ecosystem->config().morphogens.kinds.size(), 3u);
}

TEST_F(Load, CanBeSimulated) {
  const Experiment loaded = load_toy(write("e.yaml", "world: {max_steps: 20}\n" + blocks));
  Rng rng(1, 0, 0, 0, 0);
  model::Genome genome;
  loaded.ecosystem->controller().heritable().random(loaded.ecosystem->fixed_ports()->layout(), rng,
                                                    genome.controller);
  const model::Phenotype phenotype = loaded.ecosystem->express(genome);
  const model::RosterEntry founder{&phenotype, 0, 0, 0};
  model::Simulation simulation(*loaded.ecosystem, {&founder, 1}, 1);
  simulation.run();
  EXPECT_GT(simulation.steps_done(), 0u);
}

TEST_F(Load, PassesEveryKindOfParameter) {
  const Experiment loaded = load_toy(
      write("e.yaml", with_parameters("number: 3\n    maybe: 0.5\n    integer: -2\n    flag: true\n"
                                      "    text: hello there\n    word: share\n"
                                      "    numbers: [7, 8, 9]\n    table: {b: 4}\n"
                                      "    inner: {depth: 6}\n    list: [{}, {depth: 2}]")));
  EXPECT_EQ(scalar(loaded, "number"), 3);
  EXPECT_EQ(scalar(loaded, "maybe"), 0.5);
  EXPECT_EQ(scalar(loaded, "integer"), -2);
  EXPECT_EQ(scalar(loaded, "flag"), 1);
  EXPECT_EQ(scalar(loaded, "text.hello there"), 0);
  EXPECT_EQ(scalar(loaded, "word.share"), 0);
  EXPECT_EQ(scalar(loaded, "numbers.2"), 9);
  EXPECT_EQ(scalar(loaded, "table.b"), 4);
  EXPECT_EQ(scalar(loaded, "inner.depth"), 6);
  EXPECT_EQ(scalar(loaded, "list.0"), 0.25);
  EXPECT_EQ(scalar(loaded, "list.1"), 2);
}

TEST_F(Load, SaysWhoReadsGenomes) {
  const Experiment loaded = load_toy(write("e.yaml", blocks));
  EXPECT_EQ(loaded.controller.id, "toy_controller");
  EXPECT_EQ(loaded.controller.version, "1.0");
  EXPECT_EQ(loaded.specialization.id, "toy_tree");
}

TEST_F(Load, ListsTheLibrariesInUse) {
  const Experiment loaded = load_toy(write("e.yaml", blocks));
  ASSERT_EQ(loaded.libraries.size(), 4u);
  EXPECT_EQ(loaded.libraries[0].plugin_id, "somas.test.environment");
  EXPECT_EQ(loaded.libraries[0].version, "1.0");
  EXPECT_THAT(loaded.libraries[0].classes, ElementsAre("toy_environment"));
}

// ---- the resolved file
// ---------------------------------------------------------------------------

TEST_F(Load, ResolvesToAFileThatResolvesToItself) {
  const Experiment first = load_toy(
      write("e.yaml",
            "name: \"no: \\\"plain\\\" name\"\nworld: {radius: 1e-3, mechanics: "
            "{pressure_scale: 0.1}}\n" +
                with_parameters("maybe: 0.3\n    list: [{}, {depth: 1e300}]\n    table: {}\n"
                                "    text: 'true'")));
  const Experiment second = load_toy(write("again/resolved.yaml", first.resolved_yaml));
  EXPECT_EQ(second.resolved_yaml, first.resolved_yaml);
  EXPECT_EQ(second.name, first.name);
  EXPECT_THAT(first.resolved_yaml, HasSubstr("    maybe: 0.3\n"));
  EXPECT_THAT(first.resolved_yaml, HasSubstr("    text: \"true\"\n"));
}

TEST_F(Load, LeavesOptionalParametersWithoutValueOut) {
  const Experiment loaded = load_toy(write("e.yaml", with_parameters("flag: true")));
  EXPECT_THAT(loaded.resolved_yaml, testing::Not(HasSubstr("maybe")));
  EXPECT_EQ(scalar(loaded, "maybe"), -1);
}

TEST_F(Load, FindsPluginsRelativeToTheFileAndResolvesThemAbsolutely) {
  std::filesystem::create_directory_symlink(toy_plugins, directory_ / "mine");
  const Experiment first = load(write("e.yaml", "plugins: [mine]\n" + blocks));
  EXPECT_THAT(first.resolved_yaml,
              HasSubstr("plugins:\n  - " + (directory_ / "mine").string() + "\n"));
  EXPECT_EQ(load(write("elsewhere/r.yaml", first.resolved_yaml)).resolved_yaml,
            first.resolved_yaml);
}

// ---- plugins that are not there
// ------------------------------------------------------------------

TEST_F(Load, SaysWhichPluginIsMissing) {
  EXPECT_THAT(
      complaint("environments:\n  toy_environmnt: {}\nspecialization: {plugin: toy_tree}\n"
                "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n"),
      StartsWith(
          "e.yaml:2:3: environments.toy_environmnt: no environment "
          "'toy_environmnt'; available: toy_environment, toy_parameters, toy_relations; did you "
          "mean 'toy_environment'?\n  searched:\n    " +
          toy_plugins.string() + " (--plugin-path)\n"));
  EXPECT_THAT(complaint("specialization: {plugin: toy_tree}\ncontroller:\n  plugin: grn\nfitness: "
                        "{plugin: toy_fitness}\n"),
              StartsWith("e.yaml:3:11: controller.plugin: no controller 'grn'; available: "
                         "toy_controller\n"));
}

TEST_F(Load, SaysThatAPluginIsOfAnotherKind) {
  EXPECT_EQ(complaint("specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_fitness}\n"
                      "fitness: {plugin: toy_fitness}\n"),
            "e.yaml:2:22: controller.plugin: 'toy_fitness' is a fitness, not a controller; "
            "available: toy_controller");
}

TEST_F(Load, SaysThatABlockIsMissing) {
  EXPECT_EQ(complaint("seed: 1\nspecialization: {plugin: toy_tree}\ncontroller: {gain: 1}\n"),
            "e.yaml:3:1: controller.plugin: missing; available: toy_controller\n"
            "e.yaml:1:1: fitness: missing; write 'fitness: {plugin: ID}'; available: toy_fitness");
}

TEST_F(Load, RefusesADirectoryThatIsNone) {
  EXPECT_EQ(complaint("plugins: [none]\n" + blocks),
            "e.yaml:1:11: plugins[0]: no such directory: none");
  try {
    static_cast<void>(load(write("e.yaml", blocks), {{}, {"/none"}}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--plugin-path /none: no such directory");
  }
}

TEST_F(Load, NamesBothFilesOfADuplicateId) {
  try {
    static_cast<void>(
        load(write("e.yaml", blocks), {{}, {toy_plugins, bad_plugins / "duplicate_id"}}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("e.yaml:5:19: fitness.plugin: two plugins define "
                                        "'toy_fitness': "));
  }
}

TEST_F(Load, RefusesReservedAndStrangeNames) {
  EXPECT_EQ(complaint("environments:\n  fitness: {plugin: toy_environment}\n"
                      "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
                      "fitness: {plugin: toy_fitness}\n"),
            "e.yaml:2:3: environments.fitness: this name is taken by the block 'fitness'");
  EXPECT_EQ(complaint("environments:\n  a b: {plugin: toy_environment}\n"
                      "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
                      "fitness: {plugin: toy_fitness}\n"),
            "e.yaml:2:3: environments.a b: a name has letters, digits, '_' and '-' only");
}

// ---- faults of plugins and of the wiring
// ---------------------------------------------------------

TEST_F(Load, PlacesAFaultyParameter) {
  EXPECT_EQ(complaint(with_parameters("inner: {depth: 4}\n    fault: parameter")),
            "e.yaml:4:13: environments.probe.inner.depth: too deep");
  // The key is not in the file: the nearest that is.
  EXPECT_EQ(complaint(with_parameters("fault: parameter")),
            "e.yaml:2:3: environments.probe.inner.depth: too deep");
}

TEST_F(Load, PlacesAConstructorsFailure) {
  EXPECT_EQ(complaint(with_parameters("fault: construct")),
            "e.yaml:2:3: environments.probe: the plugin 'toy_parameters' cannot be created: asked "
            "to fail");
  EXPECT_EQ(complaint(with_parameters("fault: strange")),
            "e.yaml:2:3: environments.probe: the plugin 'toy_parameters' cannot be created: it "
            "threw something that is no std::exception");
}

TEST_F(Load, NamesOfStatesFitColumnsAndKeys) {
  const std::string rest = "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n";
  EXPECT_THAT(
      complaint("specialization:\n  plugin: toy_tree\n  states:\n    - name: a b\n" + rest),
      testing::HasSubstr("e.yaml:4:13: specialization: the state 'a b': a name has letters"));
}

TEST_F(Load, NamesAreShortPlainText) {
  const std::string rest =
      "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
      "fitness: {plugin: toy_fitness}\n";
  EXPECT_THAT(complaint("name: \"a\\tb\"\n" + rest),
              testing::HasSubstr(":7: name: a name must not contain control characters; byte 2"));
  EXPECT_THAT(complaint("name: \"a\\x85b\"\n" + rest), testing::HasSubstr("byte 2"));
  EXPECT_THAT(complaint("name: " + std::string(101, 'n') + "\n" + rest),
              testing::HasSubstr("a name of 101 bytes; allowed: at most 100"));
}

TEST_F(Load, PlacesAWiringError) {
  EXPECT_EQ(complaint(with_parameters("list:\n      - {}\n      - depth: 3\n    fault: wiring")),
            "e.yaml:6:9: environments.probe.list[1].depth: too deep");
  EXPECT_EQ(complaint("specialization:\n  plugin: toy_tree\n  states:\n    - name: a\n"
                      "    - {name: b, parent: c}\ncontroller: {plugin: toy_controller}\n"
                      "fitness: {plugin: toy_fitness}\n"),
            "e.yaml:5:17: specialization.states[1].parent: no state before it is called 'c'");
}

TEST_F(Load, PlacesAFailureWhileWiring) {
  EXPECT_EQ(complaint(with_parameters("fault: declare")),
            "e.yaml:2:3: environments.probe: probe: declare: asked to fail");
  EXPECT_THAT(complaint(with_parameters("fault: clash")),
              StartsWith("e.yaml:2:3: environments.probe: probe: declare: "));
}

TEST_F(Load, PlacesAnUnstableTimeStep) {
  EXPECT_THAT(complaint("world:\n  mechanics:\n    time_step: 0.1\n" + blocks),
              StartsWith("e.yaml:3:5: world.mechanics.time_step: a substep of 0.1 is unstable"));
  // Not in the file: the stiffness made the default unstable.
  EXPECT_THAT(complaint("specialization: {plugin: toy_tree, states: [{name: a, stiffness: 1000}]}\n"
                        "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n"),
              StartsWith("e.yaml:1:1: world.mechanics.time_step: a substep of 0.0333333 is "
                         "unstable"));
}

// ---- the bundled experiments
// ---------------------------------------------------------------------

TEST_F(Load, TakesWhatDescribePrints) {
  const std::string base = write("base.yaml", blocks).string();
  const plugins::Registry toys({{toy_plugins, "test"}});
  for (const std::string& id : toys.ids()) {
    const std::string text = plugins::describe(toys.find(id), plugins::DescribeFormat::yaml);
    EXPECT_EQ(complaint("extends: " + base + "\n" + text), "") << text;
  }
}

TEST_F(Load, TakesWhatDescribePrintsOfTheBundledPlugins) {
  const plugins::Registry registry({{bundled, "test"}});
  if (registry.candidates().empty()) GTEST_SKIP() << "built without them";
  for (const std::string& id : registry.ids()) {
    const std::string text = plugins::describe(registry.find(id), plugins::DescribeFormat::yaml);
    const auto file =
        write("e.yaml", "extends: " + (experiments / "exp1.yaml").string() + "\n" + text);
    // A second source of food takes the place of the first: both feed by the same skill.
    std::vector<std::string> overrides;
    if (text.find("cyclic_nutrients:") != std::string::npos)
      overrides.emplace_back("environments.nutrients=null");
    EXPECT_NO_THROW(static_cast<void>(load(file, {overrides, {bundled}}))) << text;
  }
}

TEST(Experiments, LoadWithTheBundledPlugins) {
  const bool built = !plugins::Registry({{bundled, "test"}}).candidates().empty();
  if (!built || !std::filesystem::exists(experiments)) GTEST_SKIP() << "built without them";
  for (const auto& entry : std::filesystem::directory_iterator(experiments)) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(static_cast<void>(load(entry.path(), {{}, {bundled}}))) << entry.path();
  }
}

}  // namespace
}  // namespace somas::experiment
