#include "plugins/specialization/evolved_tree/evolved_tree.hpp"

#include <memory>
#include <set>

#include <gmock/gmock.h>

#include "core/model/ecosystem.hpp"
#include "plugins/controllers/grn/grn.hpp"
#include "plugins/fitness/survival_time/survival_time.hpp"
#include "tests/plugins/controllers/support.hpp"

namespace somas::specialization {
namespace {

using somas::testing::test_rng;
using ::testing::HasSubstr;

const std::vector<SkillInfo> skills = {
    {"capacity", {}},
    {"diffusion", {.fallback = 0.5, .minimum = 0, .maximum = 1, .cost = 0}},
    {"production", {.minimum = 0.25, .maximum = 5}},
    {"resistance", {.cost = 2}},
};

EvolvedTree evolved(const EvolvedTree::Parameters& parameters = {},
                    std::span<const SkillInfo> known = skills) {
  EvolvedTree tree(parameters);
  tree.declare(known);
  return tree;
}

Genes start(const EvolvedTree& tree, std::uint64_t number = 1) {
  Rng rng = test_rng(number);
  Genes genes;
  tree.heritable()->random({}, rng, genes);
  return genes;
}

double spent(const TreeState& state, const TreeGenes& genes) {
  double sum = 0;
  for (std::size_t k = 0; k < genes.skills.size(); ++k)
    for (const SkillInfo& skill : skills)
      if (stable_key(skill.name) == genes.skills[k]) sum += state.points[k] * skill.spec.cost;
  return sum;
}

TEST(EvolvedTree, BeginsAsOneStateThatIsMediocreAtEverything) {
  const EvolvedTree tree = evolved({.budget = 12});
  const TreeGenes genes = decode(start(tree));
  ASSERT_EQ(genes.states.size(), 1u);
  ASSERT_EQ(genes.skills.size(), 3u) << "diffusion has no price and does not evolve";
  for (std::size_t k = 0; k < 3; ++k) {
    const bool dear = genes.skills[k] == stable_key("resistance");
    EXPECT_NEAR(genes.states[0].points[k], dear ? 2 : 4, 0.15);
  }
  EXPECT_NEAR(spent(genes.states[0], genes), 12, 0.2);
}

TEST(EvolvedTree, KeepsTheLawsOfHeredity) {
  const EvolvedTree tree = evolved();
  somas::testing::expect_laws_of_heredity(*tree.heritable(), {}, 300);
}

/// Whatever the core asks of a tree, by way of a whole ecosystem.
class Wired {
 public:
  explicit Wired(const EvolvedTree::Parameters& parameters)
      : tree(std::make_shared<EvolvedTree>(parameters)),
        ecosystem({}, {}, tree, std::make_shared<grn::Grn>(grn::Parameters{}),
                  std::make_shared<fitness::SurvivalTime>(fitness::SurvivalTime::Parameters{})) {}

  std::shared_ptr<EvolvedTree> tree;
  model::Ecosystem ecosystem;
};

TEST(EvolvedTree, IsValidAndWithinItsBudgetAfterTenThousandMutations) {
  const EvolvedTree::Parameters parameters{.max_states = 7, .max_depth = 3, .budget = 9};
  const EvolvedTree tree = evolved(parameters);
  Wired wired(parameters);  // where capacity alone has a price
  Genes genes = start(tree), other = start(tree, 2), in_world = start(*wired.tree);
  Rng rng = test_rng(3);
  std::set<std::size_t> sizes;
  for (int event = 0; event < 10000; ++event) {
    if (event % 10 == 9) {
      Genes child;
      tree.heritable()->cross({}, genes, other, rng, child);
      std::swap(other, genes);
      genes = child;
    } else {
      tree.heritable()->mutate({}, rng, genes);
      wired.tree->heritable()->mutate({}, rng, in_world);
    }
    ASSERT_NO_THROW(tree.heritable()->check({}, genes)) << event;
    const TreeGenes grown = decode(genes);
    ASSERT_LE(grown.states.size(), 7u);
    ASSERT_LE(grown.depth(), 3u);
    for (const TreeState& state : grown.states) ASSERT_LE(spent(state, grown), 9 * (1 + 1e-9));
    sizes.insert(grown.states.size());
    ASSERT_NO_THROW(static_cast<void>(wired.ecosystem.grow(in_world))) << event;
  }
  EXPECT_EQ(sizes.size(), 7u) << "all sizes are reached";
}

TEST(EvolvedTree, MutationsGrowSplitAndRemoveStates) {
  const auto only = [](double move, double add, double split, double remove) {
    return evolved(
        {.move_weight = move, .add_weight = add, .split_weight = split, .remove_weight = remove});
  };
  Rng rng = test_rng(4);
  Genes genes = start(evolved());
  only(0, 1, 0, 0).heritable()->mutate({}, rng, genes);
  ASSERT_EQ(decode(genes).states.size(), 2u);
  EXPECT_EQ(decode(genes).depth(), 2u);
  only(0, 0, 1, 0).heritable()->mutate({}, rng, genes);
  ASSERT_EQ(decode(genes).states.size(), 3u);
  EXPECT_EQ(decode(genes).depth(), 3u) << "between the other two";
  const Genes before = genes;
  only(1, 0, 0, 0).heritable()->mutate({}, rng, genes);
  EXPECT_NE(genes, before);
  EXPECT_EQ(decode(genes).states.size(), 3u);
  only(0, 0, 0, 1).heritable()->mutate({}, rng, genes);
  only(0, 0, 0, 1).heritable()->mutate({}, rng, genes);
  EXPECT_EQ(decode(genes).states.size(), 1u);
  EXPECT_EQ(decode(genes).states[0].key, stable_key("root")) << "the root stays";
}

TEST(EvolvedTree, ASurvivingStateKeepsItsPortsGenes) {
  Wired wired({.move_weight = 0, .add_weight = 1, .split_weight = 0, .remove_weight = 0});
  const Heritable& network = wired.ecosystem.controller().heritable();
  Genes tree = start(*wired.tree);
  Rng rng = test_rng(5);
  auto ports = wired.ecosystem.ports_of(*wired.ecosystem.grow(tree));
  const Layout one = ports->layout();
  Genes small;
  network.random(one, rng, small);

  wired.tree->heritable()->mutate({}, rng, tree);
  const auto more_ports = wired.ecosystem.ports_of(*wired.ecosystem.grow(tree));
  Genes large = small;
  network.conform(more_ports->layout(), rng, large);
  EXPECT_GT(large.size(), small.size());
  network.conform(one, rng, large);
  EXPECT_EQ(large, small) << "what the root's ports learned has come through unchanged";
}

TEST(EvolvedTree, CrossingTakesPointsOfCommonStatesAndGraftsOthers) {
  const EvolvedTree tree = evolved();
  Rng rng = test_rng(6);
  Genes mother = start(tree), father = start(tree, 2);
  for (int k = 0; k < 30; ++k) tree.heritable()->mutate({}, rng, father);
  bool grafted = false, twin = false;
  for (int k = 0; k < 50; ++k) {
    Genes child;
    tree.heritable()->cross({}, mother, father, rng, child);
    const TreeGenes made = decode(child);
    grafted = grafted || made.states.size() > 1;
    twin = twin || made.states[0].points == decode(father).states[0].points;
  }
  EXPECT_EQ(grafted, decode(father).states.size() > 1);
  EXPECT_TRUE(twin);
}

TEST(EvolvedTree, ConformsToOtherSkillsAndLimits) {
  const EvolvedTree tree = evolved({.budget = 10});
  Rng rng = test_rng(7);
  Genes genes = start(tree);
  for (int k = 0; k < 60; ++k) tree.heritable()->mutate({}, rng, genes);
  const std::vector<SkillInfo> others = {{"capacity", {}}, {"speed", {.minimum = 1}}};
  const EvolvedTree small = evolved({.max_states = 2, .max_depth = 2, .budget = 5}, others);
  EXPECT_THROW(small.heritable()->check({}, genes), std::runtime_error);
  small.heritable()->conform({}, rng, genes);
  EXPECT_NO_THROW(small.heritable()->check({}, genes));
  const Genes before = genes;
  small.heritable()->conform({}, rng, genes);
  EXPECT_EQ(genes, before);
}

TEST(EvolvedTree, RefusesDamagedGenesWithoutCrashing) {
  const EvolvedTree tree = evolved();
  Rng rng = test_rng(8);
  Genes genes = start(tree);
  for (int k = 0; k < 40; ++k) tree.heritable()->mutate({}, rng, genes);
  for (std::size_t cut = 0; cut < genes.size(); ++cut)
    EXPECT_THROW(tree.heritable()->check({}, GenesView(genes).first(cut)), std::runtime_error);
  for (std::size_t at = 0; at < genes.size(); ++at)
    for (const int bit : {0, 6, 7}) {
      Genes damaged = genes;
      damaged[at] ^= static_cast<std::uint8_t>(1 << bit);
      try {
        tree.heritable()->check({}, damaged);
      } catch (const std::runtime_error&) {
      }
    }
}

TEST(EvolvedTree, RefusesABudgetThatDoesNotPayTheLeastPoints) {
  try {
    evolved({.budget = 0.1});
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_EQ(error.path(), "budget");
    EXPECT_THAT(error.what(), HasSubstr("more than the budget"));
  }
}

}  // namespace
}  // namespace somas::specialization
