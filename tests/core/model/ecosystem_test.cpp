// Wiring: declarations, the specialization tree, ports and phenotypes.
#include "core/model/ecosystem.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

NamedEnvironment declaring(std::string name, std::function<void(Declare&)> declare) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = std::move(declare);
  return {std::move(name), toy};
}

/// What wiring two environments with these declarations says when it fails.
std::optional<std::string> complaint(std::function<void(Declare&)> first,
                                     std::function<void(Declare&)> second = {}) {
  Bench bench;
  const std::string culprit = second ? "beta" : "alpha";
  bench.environments = {declaring("alpha", std::move(first))};
  if (second) bench.environments.push_back(declaring("beta", std::move(second)));
  try {
    bench.wire();
  } catch (const PluginFailure& failure) {
    EXPECT_EQ(failure.instance(), culprit);
    EXPECT_EQ(failure.call(), "declare");
    return failure.what();
  }
  return {};
}

// ---- declarations -------------------------------------------------------------------------------

TEST(Declarations, HandlesCountFromZeroByCategory) {
  std::vector<Id> seen;
  EXPECT_FALSE(complaint([&](Declare& d) {
    const std::array<std::string_view, 1> columns{"x"};
    seen = {d.sensor("a"),         d.sensor("b"),    d.cell_value("a", OnDivision::copy),
            d.scalar("a", 0),      d.scalar("b", 0), d.grid("a", {.columns = 1, .rows = 1}),
            d.table("a", columns), d.purpose("a"),   d.purpose("b")};
  }));
  EXPECT_THAT(seen, ElementsAre(0u, 1u, 0u, 0u, 1u, 0u, 0u, 0u, 1u));
}

TEST(Declarations, SameSkillTwiceIsOneSkill) {
  Id first = no_id, second = no_id, other = no_id;
  EXPECT_FALSE(
      complaint([&](Declare& d) { first = d.skill("grip", {.fallback = 2, .maximum = 9}); },
                [&](Declare& d) {
                  second = d.skill("grip", {.fallback = 2, .maximum = 9});
                  other = d.skill("grasp", {.fallback = 2, .maximum = 9});
                }));
  EXPECT_EQ(first, second);
  EXPECT_NE(first, other);
}

TEST(Declarations, SkillsOfTheModelCanBeNamed) {
  EXPECT_FALSE(complaint([](Declare& d) {
    EXPECT_EQ(d.skill("capacity", core_schema().skills[skill_capacity].spec), Id{skill_capacity});
    EXPECT_EQ(d.skill("diffusion", core_schema().skills[skill_diffusion].spec),
              Id{skill_diffusion});
  }));
}

TEST(Declarations, SkillOfAnotherKindUnderTheSameNameIsRefused) {
  const std::array<SkillSpec, 4> others{SkillSpec{.fallback = 1}, SkillSpec{.minimum = -1},
                                        SkillSpec{.maximum = 5}, SkillSpec{.cost = 2}};
  for (const SkillSpec& other : others) {
    const auto said = complaint([](Declare& d) { (void)d.skill("grip", {}); },
                                [&](Declare& d) { (void)d.skill("grip", other); });
    ASSERT_TRUE(said);
    EXPECT_THAT(*said, HasSubstr("beta"));
    EXPECT_THAT(*said, HasSubstr("'grip'"));
  }
}

TEST(Declarations, SharedNamesClashAcrossEnvironments) {
  const std::map<std::string, std::function<void(Declare&)>> shared{
      {"sensor", [](Declare& d) { (void)d.sensor("thing"); }},
      {"cause of death", [](Declare& d) { (void)d.cause("thing"); }},
      {"cause of death ", [](Declare& d) { (void)d.hazard("thing", d.skill("r", {})); }},
      {"resource", [](Declare& d) {
         (void)d.resource("thing", d.grid("g", {.columns = 1, .rows = 1}), d.skill("p", {}));
       }}};
  for (const auto& [what, declare] : shared) {
    const auto said = complaint(declare, declare);
    ASSERT_TRUE(said) << what;
    EXPECT_THAT(*said, HasSubstr("beta"));
    EXPECT_THAT(*said, HasSubstr("'thing'"));
    EXPECT_THAT(*said, HasSubstr(what.substr(0, 5)));
    EXPECT_THAT(*said, HasSubstr("declared already"));
  }
}

TEST(Declarations, ModelsOwnCausesAreTaken) {
  for (const char* name : {"starvation", "apoptosis", "outside"})
    EXPECT_TRUE(complaint([=](Declare& d) { (void)d.cause(name); })) << name;
}

TEST(Declarations, ModelsOwnInputsAreTaken) {
  // A sensor of such a name would be a second port under the same key.
  for (const char* name : {"energy", "pressure", "ambrosia", "morphogen.0"})
    EXPECT_TRUE(complaint([=](Declare& d) { (void)d.sensor(name); })) << name;
}

TEST(Declarations, ResourcesNeedAProductionSkillEach) {
  const auto food = [](const char* name) {
    return [=](Declare& d) {
      (void)d.resource(name, d.grid("g", {.columns = 1, .rows = 1}), d.skill("production", {}));
    };
  };
  const auto said = complaint(food("sweet"), food("sour"));
  ASSERT_TRUE(said);
  EXPECT_THAT(*said, HasSubstr("'production' already takes up the resource 'sweet'"));
}

TEST(Declarations, OwnNamesClashWithinAnEnvironmentOnly) {
  const std::array<std::string_view, 1> columns{"x"};
  const std::map<std::string, std::function<void(Declare&)>> own{
      {"cell value", [](Declare& d) { (void)d.cell_value("thing", OnDivision::copy); }},
      {"scalar", [](Declare& d) { (void)d.scalar("thing", 1); }},
      {"grid", [](Declare& d) { (void)d.grid("thing", {.columns = 1, .rows = 1}); }},
      {"table", [&](Declare& d) { (void)d.table("thing", columns); }},
      {"purpose", [](Declare& d) { (void)d.purpose("thing"); }}};
  for (const auto& [what, declare] : own) {
    EXPECT_FALSE(complaint(declare, declare)) << what;
    const auto said = complaint([&, declare = declare](Declare& d) {
      declare(d);
      declare(d);
    });
    ASSERT_TRUE(said) << what;
    EXPECT_THAT(*said, HasSubstr(what));
    EXPECT_THAT(*said, HasSubstr("'thing'"));
  }
}

TEST(Declarations, HandlesNeverDeclaredAreRefused) {
  EXPECT_TRUE(complaint([](Declare& d) { (void)d.hazard("fire", 99); }));
  EXPECT_TRUE(complaint([](Declare& d) { (void)d.resource("food", 0, d.skill("p", {})); }));
  EXPECT_TRUE(complaint(
      [](Declare& d) { (void)d.resource("food", d.grid("g", {.columns = 1, .rows = 1}), 99); }));
}

TEST(Declarations, GridsNeedSquares) {
  for (const GridSpec& spec : {GridSpec{.columns = 0, .rows = 3}, GridSpec{.columns = 3, .rows = 0},
                               GridSpec{.columns = 3, .rows = 3, .side = 0},
                               GridSpec{.columns = 3, .rows = 3, .side = -1}}) {
    const auto said = complaint([&](Declare& d) { (void)d.grid("field", spec); });
    ASSERT_TRUE(said);
    EXPECT_THAT(*said, HasSubstr("'field'"));
  }
}

TEST(Declarations, OfTheFitnessCountToo) {
  class Measuring final : public Fitness {
   public:
    void declare(Declare& d) override { (void)d.scalar("best", 4.5); }
    [[nodiscard]] std::string_view objective() const override { return "best"; }
    [[nodiscard]] double score(const Outcome&) const override { return 0; }
  };
  const Ecosystem ecosystem(
      {}, {}, std::make_shared<FixedTree>(std::vector<StateDef>(1)),
      std::make_shared<ScriptedController>(Script{}, 0, std::make_shared<Stage>()),
      std::make_shared<Measuring>());
  ASSERT_EQ(ecosystem.schema().scalars.size(), 1u);
  EXPECT_EQ(ecosystem.schema().scalars[0].owner, "fitness");
  EXPECT_EQ(ecosystem.schema().scalars[0].initial, 4.5);
}

TEST(Declarations, ParameterErrorsKeepTheirPath) {
  Bench bench;
  bench.environments = {
      declaring("alpha", [](Declare&) { throw ParameterError("states[2].parent", "is nobody"); })};
  try {
    bench.wire();
    FAIL();
  } catch (const WiringError& error) {
    EXPECT_EQ(error.instance(), "alpha");
    EXPECT_EQ(error.path(), "states[2].parent");
    EXPECT_STREQ(error.what(), "is nobody");
  }
}

// ---- the tree -----------------------------------------------------------------------------------

/// What wiring a tree of these states says when it fails.
std::optional<std::string> complaint_about(std::vector<StateDef> states) {
  Bench bench;
  bench.states = std::move(states);
  try {
    bench.wire();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

TEST(Trees, ThatNoWorldCouldHoldAreRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const StateDef root{.name = "root"};
  const std::vector<std::pair<StateDef, const char*>> bad{
      {{.name = "x", .parent = no_state}, "root"},
      {{.name = "x", .parent = 1}, "parent"},
      {{.name = "x", .parent = 7}, "parent"},
      {{.name = "x", .parent = 0, .mass = 0}, "mass"},
      {{.name = "x", .parent = 0, .mass = nan}, "mass"},
      {{.name = "x", .parent = 0, .radius = -1}, "radius"},
      {{.name = "x", .parent = 0, .radius = infinity}, "radius"},
      {{.name = "x", .parent = 0, .stiffness = -0.1}, "stiffness"},
      {{.name = "x", .parent = 0, .adhesion = nan}, "adhesion"},
      {{.name = "x", .parent = 0, .adhesion_range = 0.99}, "range"},
      {{.name = "x", .parent = 0, .adhesion_range = infinity}, "range"},
      {{.name = "x", .parent = 0, .adhesion_with = {-1}}, "adhesion"},
      {{.name = "x", .parent = 0, .adhesion_with = {infinity}}, "adhesion"},
      {{.name = "x", .parent = 0, .adhesion_with = {1, 1}}, "before it"},
      {{.name = "x", .parent = 0, .motility = nan}, "motility"},
      {{.name = "x", .parent = 0, .motility = -infinity}, "motility"},
      {{.name = "x", .parent = 0, .motility = 1, .motility_signal = 3}, "motility_signal"},
      {{.name = "x", .parent = 0, .quiescence_threshold = -0.1}, "threshold"},
      {{.name = "x", .parent = 0, .division_threshold = 1.1}, "threshold"},
      {{.name = "x", .parent = 0, .specialization_threshold = nan}, "threshold"},
      {{.name = "x", .parent = 0, .apoptosis_threshold = infinity}, "threshold"},
      {{.name = "x", .parent = 0, .skills = {{"capacity", -1}}}, "skill"},
      {{.name = "x", .parent = 0, .skills = {{"diffusion", 1.5}}}, "skill"},
      {{.name = "x", .parent = 0, .skills = {{"energy_efficiency", 0}}}, "skill"},
      {{.name = "x", .parent = 0, .skills = {{"capacity", nan}}}, "skill"}};
  for (const auto& [state, what] : bad) {
    const auto said = complaint_about({root, state});
    ASSERT_TRUE(said) << what;
    EXPECT_THAT(*said, HasSubstr("specialization"));
    EXPECT_THAT(*said, HasSubstr("'x'"));
    EXPECT_THAT(*said, HasSubstr(what));
  }
  EXPECT_TRUE(complaint_about({root, {.name = "root", .parent = 0}}));
  EXPECT_TRUE(complaint_about({root, {.name = "root", .parent = 0, .key = 5}}));
  EXPECT_TRUE(complaint_about({root, {.name = "x", .parent = 0, .key = stable_key("root")}}));
  EXPECT_TRUE(complaint_about({{.name = ""}}));
  EXPECT_TRUE(complaint_about({}));
  EXPECT_TRUE(complaint_about({{.name = "first", .parent = 0}})) << "the first must be the root";
  EXPECT_FALSE(complaint_about({root, {.name = "x", .parent = 0}}));
}

TEST(Trees, OfNoMotileStateNeedNoMorphogens) {
  Bench bench;
  bench.config.morphogens.kinds.clear();
  EXPECT_NO_THROW(bench.wire());
  bench.states[0].motility = 1;
  EXPECT_THROW(bench.wire(), PluginFailure);
}

TEST(Trees, LearnHowManyMorphogensThereAre) {
  struct Asking final : FixedTree {
    using FixedTree::FixedTree;
    mutable std::uint32_t told = 0;
    void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override {
      told = tree.morphogens();
      FixedTree::grow(genes, skills, tree);
    }
  };
  const auto tree = std::make_shared<Asking>(std::vector<StateDef>{StateDef{}});
  Config config;
  config.morphogens.kinds.resize(5);
  const Ecosystem ecosystem(config, {}, tree,
                            std::make_shared<ScriptedController>(Script{}, 0, nullptr),
                            std::make_shared<ToyFitness>(nullptr));
  EXPECT_EQ(tree->told, 5u);
}

TEST(Trees, ResolveAdhesionForEveryTwoStates) {
  Bench bench;
  const double mean = std::numeric_limits<double>::quiet_NaN();
  bench.states = {{.name = "a", .adhesion = 2},
                  {.name = "b", .parent = 0, .adhesion = 4, .adhesion_with = {0.5}},
                  {.name = "c", .parent = 0, .adhesion = 6, .adhesion_with = {mean, 7}}};
  bench.wire();
  EXPECT_THAT(bench.ecosystem().fixed_tree()->adhesion, ElementsAre(2, 0.5, 4, 0.5, 4, 7, 4, 7, 6));
}

TEST(Trees, KeepAttributesAndResolveSkills) {
  Bench bench;
  bench.environments = {declaring("alpha", [](Declare& d) {
    (void)d.skill("grip", {.fallback = 0.5});
    (void)d.skill("sight", {});
  })};
  bench.states = {{.name = "root", .skills = {{"capacity", 4}}},
                  {.name = "x",
                   .parent = 0,
                   .mass = 2,
                   .radius = 1.5,
                   .stiffness = 8,
                   .adhesion = 1,
                   .adhesion_range = 1.3,
                   .skills = {{"grip", 7}},
                   .key = 99,
                   .motility = -2,
                   .motility_signal = 2,
                   .quiescence_threshold = 0.1,
                   .division_threshold = 0.2,
                   .specialization_threshold = 0.3,
                   .apoptosis_threshold = 0.4},
                  {.name = "y", .parent = 1},
                  {.name = "z", .parent = 0}};
  bench.wire();
  const Tree& tree = *bench.ecosystem().fixed_tree();
  ASSERT_EQ(tree.states.size(), 4u);
  EXPECT_THAT(tree.states[0].children, ElementsAre(1, 3));
  EXPECT_THAT(tree.states[1].children, ElementsAre(2));
  EXPECT_EQ(tree.states[0].key, stable_key("root"));
  const State& x = tree.states[1];
  EXPECT_EQ(x.key, 99u);
  EXPECT_EQ(x.parent, 0);
  EXPECT_EQ(x.mass, 2);
  EXPECT_EQ(x.radius, 1.5);
  EXPECT_EQ(x.stiffness, 8);
  EXPECT_EQ(x.adhesion, 1);
  EXPECT_EQ(x.adhesion_range, 1.3);
  EXPECT_EQ(x.motility, -2);
  EXPECT_EQ(x.motility_signal, 2u);
  EXPECT_EQ(x.thresholds.quiescence, 0.1f);
  EXPECT_EQ(x.thresholds.division, 0.2f);
  EXPECT_EQ(x.thresholds.specialization, 0.3f);
  EXPECT_EQ(x.thresholds.apoptosis, 0.4f);
  EXPECT_THAT(x.skills, ElementsAre(0, 1, 1, 7, 0));
  EXPECT_THAT(tree.states[0].skills, ElementsAre(4, 1, 1, 0.5, 0));
}

// ---- ports --------------------------------------------------------------------------------------

/// The bench with a given tree, a resource "food" and a sensor "light".
void ports_bench(Bench& bench, std::vector<StateDef> states) {
  bench.config.morphogens.kinds.resize(2);
  bench.states = std::move(states);
  bench.environments = {resource_grid("food", 1),
                        declaring("lamp", [](Declare& d) { (void)d.sensor("light"); })};
  bench.wire();
}

std::vector<std::string> names(std::span<const Port> ports) {
  std::vector<std::string> all;
  for (const Port& port : ports) all.emplace_back(port.name);
  return all;
}

TEST(PortsTest, AreNamedAndOrderedByChannel) {
  Bench bench;
  ports_bench(bench, {{.name = "n"}, {.name = "d", .parent = 0}});
  const Layout& layout = bench.ecosystem().fixed_ports()->layout();
  EXPECT_EQ(layout.input_channels, 6u);
  EXPECT_THAT(names(layout.inputs),
              ElementsAre("n/morphogen.0", "n/morphogen.1", "n/pressure", "n/energy", "n/ambrosia",
                          "n/light", "d/morphogen.0", "d/morphogen.1", "d/pressure", "d/energy",
                          "d/ambrosia", "d/light"));
  for (std::size_t i = 0; i < layout.inputs.size(); ++i) {
    EXPECT_EQ(layout.inputs[i].channel, i % 6);
    EXPECT_EQ(layout.inputs[i].state, i / 6);
  }
  EXPECT_THAT(names(layout.outputs),
              ElementsAre("quiescence", "division", "apoptosis", "specialize.d", "morphogen.0",
                          "morphogen.1", "conversion", "diffusion", "uptake.food"));
  for (std::size_t i = 0; i < layout.outputs.size(); ++i) {
    EXPECT_EQ(layout.outputs[i].channel, i);
    EXPECT_EQ(layout.outputs[i].state, i == 3 ? 1 : no_state);
  }
  ASSERT_EQ(layout.states.size(), 2u);
  EXPECT_EQ(layout.states[1].name, "d");
  EXPECT_EQ(layout.states[1].key, stable_key("d"));
  EXPECT_EQ(layout.states[1].parent, 0);
  EXPECT_EQ(layout.states[0].parent, no_state);
}

/// Key by name of all ports.
std::map<std::string, std::uint64_t> keys(const Layout& layout) {
  std::map<std::string, std::uint64_t> all;
  for (const Port& port : layout.inputs) all["in " + std::string(port.name)] = port.key;
  for (const Port& port : layout.outputs) all["out " + std::string(port.name)] = port.key;
  return all;
}

TEST(PortsTest, KeepTheirKeysWhenStatesAreAddedOrReordered) {
  Bench plain, grown;
  ports_bench(plain, {{.name = "n"}, {.name = "d", .parent = 0}});
  ports_bench(grown, {{.name = "n"},
                      {.name = "s", .parent = 0},
                      {.name = "t", .parent = 1},
                      {.name = "d", .parent = 0}});
  const auto before = keys(plain.ecosystem().fixed_ports()->layout());
  const auto after = keys(grown.ecosystem().fixed_ports()->layout());
  EXPECT_GT(after.size(), before.size());
  for (const auto& [name, key] : before) EXPECT_EQ(after.at(name), key) << name;
}

TEST(PortsTest, FollowTheStatesKeyRatherThanItsName) {
  Bench plain, renamed;
  ports_bench(plain, {{.name = "n"}, {.name = "d", .parent = 0, .key = 77}});
  ports_bench(renamed, {{.name = "n"}, {.name = "defensive", .parent = 0, .key = 77}});
  const auto before = keys(plain.ecosystem().fixed_ports()->layout());
  const auto after = keys(renamed.ecosystem().fixed_ports()->layout());
  EXPECT_EQ(before.at("in d/energy"), after.at("in defensive/energy"));
  EXPECT_EQ(before.at("out specialize.d"), after.at("out specialize.defensive"));
}

TEST(PortsTest, HaveKeysOfTheirOwn) {
  Bench bench;
  std::vector<StateDef> states{{.name = "n"}};
  for (int i = 0; i < 12; ++i) states.push_back({.name = "s" + std::to_string(i), .parent = 0});
  ports_bench(bench, states);
  const Layout& layout = bench.ecosystem().fixed_ports()->layout();
  std::set<std::uint64_t> inputs, outputs;
  for (const Port& port : layout.inputs) EXPECT_TRUE(inputs.insert(port.key).second) << port.name;
  for (const Port& port : layout.outputs) EXPECT_TRUE(outputs.insert(port.key).second) << port.name;
}

TEST(PortsTest, HaveKeysOfTheirOwnEvenWhenNamesRunTogether) {
  // "n" + "fresh_light" and "nfresh_" + "light" spell the same.
  Bench bench;
  bench.states = {{.name = "n"}, {.name = "nfresh_", .parent = 0}};
  bench.environments = {declaring("lamp", [](Declare& d) {
    (void)d.sensor("light");
    (void)d.sensor("fresh_light");
  })};
  bench.wire();
  std::set<std::uint64_t> seen;
  for (const Port& port : bench.ecosystem().fixed_ports()->layout().inputs)
    EXPECT_TRUE(seen.insert(port.key).second) << port.name;
}

TEST(PortsTest, MeaningsPointAtTheRightChannels) {
  Bench bench;
  ports_bench(bench, {{.name = "n"}, {.name = "d", .parent = 0}, {.name = "s", .parent = 0}});
  const Ports& ports = *bench.ecosystem().fixed_ports();
  const auto output = [&](std::uint32_t c) { return std::string(ports.layout().outputs[c].name); };
  EXPECT_EQ(output(ports.out().quiescence), "quiescence");
  EXPECT_EQ(output(ports.out().division), "division");
  EXPECT_EQ(output(ports.out().apoptosis), "apoptosis");
  EXPECT_EQ(output(ports.out().conversion), "conversion");
  EXPECT_EQ(output(ports.out().diffusion), "diffusion");
  EXPECT_EQ(output(ports.out().specialize[1]), "specialize.d");
  EXPECT_EQ(output(ports.out().specialize[2]), "specialize.s");
  EXPECT_EQ(output(ports.out().morphogens[1]), "morphogen.1");
  EXPECT_EQ(output(ports.out().uptakes[0]), "uptake.food");
  const auto input = [&](std::uint32_t c) { return std::string(ports.layout().inputs[c].name); };
  EXPECT_EQ(input(ports.in().pressure), "n/pressure");
  EXPECT_EQ(input(ports.in().energy), "n/energy");
  EXPECT_EQ(input(ports.in().ambrosia), "n/ambrosia");
  EXPECT_EQ(input(ports.in().first_sensor), "n/light");
}

// ---- phenotypes ---------------------------------------------------------------------------------

/// Emits the genes' first byte / 10 as the morphogen output, and remembers its layout.
class GeneController final : public Controller {
 public:
  struct GeneProgram final : Program {
    float value;
    std::uint32_t outputs;
    GeneProgram(float v, std::uint32_t n) : value(v), outputs(n) {}
    [[nodiscard]] std::uint32_t memory_per_cell() const override { return outputs % 3; }
    void step(const Batch& batch) const override {
      EXPECT_EQ(batch.out.channels, outputs);
      EXPECT_EQ(batch.memory.channels, outputs % 3);
      for (std::uint32_t c = 0; c < batch.out.channels; ++c)
        for (float& out : batch.out.channel(c)) out = 0;
      for (float& out : batch.out.channel(outputs - 3)) out = value;  // the last morphogen
    }
  };
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes,
                                                 const Layout& layout) const override {
    if (genes.empty()) throw std::runtime_error("no genes");
    return std::make_unique<GeneProgram>(static_cast<float>(genes[0]) / 10.0f,
                                         static_cast<std::uint32_t>(layout.outputs.size()));
  }

 private:
  NoGenes genes_;
};

TEST(Phenotypes, LiveTogetherEachByItsOwnGenesAndTree) {
  const std::vector<StateDef> states{{.name = "n", .skills = {{"capacity", 2}}},
                                     {.name = "d", .parent = 0},
                                     {.name = "s", .parent = 1}};
  Config config;
  const Ecosystem ecosystem(config, {}, std::make_shared<CountedTree>(states),
                            std::make_shared<GeneController>(),
                            std::make_shared<ToyFitness>(nullptr));
  EXPECT_EQ(ecosystem.fixed_tree(), nullptr);
  EXPECT_EQ(ecosystem.fixed_ports(), nullptr);
  const Phenotype small = ecosystem.express({.controller = {3}, .tree = {1}});
  const Phenotype large = ecosystem.express({.controller = {8}, .tree = {3}});
  EXPECT_EQ(small.tree->states.size(), 1u);
  EXPECT_EQ(large.tree->states.size(), 3u);
  EXPECT_EQ(small.ports->layout().outputs.size() + 2, large.ports->layout().outputs.size());

  const std::array<RosterEntry, 2> roster{RosterEntry{&small, 1, -20, 0},
                                          RosterEntry{&large, 2, 20, 0}};
  Simulation simulation(ecosystem, roster, 1);
  for (int i = 0; i < 3; ++i) simulation.step();
  const auto& organisms = simulation.state().organisms;
  EXPECT_FLOAT_EQ(organisms[0].fields.value(2, 22, 32), 0.3f);
  EXPECT_FLOAT_EQ(organisms[1].fields.value(2, 42, 32), 0.8f);
  EXPECT_EQ(simulation.census(1).size(), 3u);

  // The same phenotype serves several worlds at once, and none disturbs another.
  Simulation first(ecosystem, roster, 1), second(ecosystem, roster, 1);
  for (int i = 0; i < 3; ++i) first.step(), second.step();
  EXPECT_EQ(first.hash(), simulation.hash());
  EXPECT_EQ(second.hash(), simulation.hash());
}

TEST(Phenotypes, OfAFixedTreeShareTreeAndPorts) {
  Bench bench;
  bench.wire();
  const Phenotype a = bench.ecosystem().express({}), b = bench.ecosystem().express({});
  EXPECT_EQ(a.tree, b.tree);
  EXPECT_EQ(a.ports, b.ports);
  EXPECT_NE(a.program, b.program);
}

TEST(Phenotypes, ThatCannotBeExpressedSayWhy) {
  const Ecosystem ecosystem({}, {}, std::make_shared<FixedTree>(std::vector<StateDef>(1)),
                            std::make_shared<GeneController>(),
                            std::make_shared<ToyFitness>(nullptr));
  try {
    (void)ecosystem.express({});
    FAIL();
  } catch (const PluginFailure& failure) {
    EXPECT_EQ(failure.instance(), "controller");
    EXPECT_EQ(failure.call(), "express");
    EXPECT_THAT(failure.what(), HasSubstr("no genes"));
  }
}

TEST(Phenotypes, OfAnUnstableEvolvedTreeAreRefused) {
  const std::vector<StateDef> states{{.name = "n"}, {.name = "hard", .parent = 0, .stiffness = 60}};
  const Ecosystem ecosystem({}, {}, std::make_shared<CountedTree>(states),
                            std::make_shared<GeneController>(),
                            std::make_shared<ToyFitness>(nullptr));
  EXPECT_NO_THROW((void)ecosystem.express({.controller = {1}, .tree = {1}}));
  EXPECT_THROW((void)ecosystem.express({.controller = {1}, .tree = {2}}), UnstableTimeStep);
}

}  // namespace
}  // namespace somas::model::test
