#include "plugins/specialization/evolved_tree/evolved_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include <gmock/gmock.h>

#include "somas/sdk/testing/specialization.hpp"

#include "core/evolution/heredity.hpp"
#include "core/model/ecosystem.hpp"
#include "plugins/controllers/grn/grn.hpp"
#include "plugins/controllers/grn/network.hpp"
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

// Of three equal skills each has more than half of the budget in a quarter of all ways.
TEST(EvolvedTree, MutationsSpendAStatesPointsAnewInEveryWay) {
  const EvolvedTree tree = evolved({.budget = 10,
                                    .move_weight = 0,
                                    .add_weight = 0,
                                    .split_weight = 0,
                                    .remove_weight = 0,
                                    .redraw_weight = 1},
                                   std::vector<SkillInfo>{{"a", {}}, {"b", {}}, {"c", {}}});
  Genes genes = start(tree);
  Rng rng = test_rng(10);
  std::array<int, 3> more_than_half{};
  const int draws = 4000;
  for (int k = 0; k < draws; ++k) {
    tree.heritable()->mutate({}, rng, genes);
    const std::vector<double> points = decode(genes).states[0].points;
    EXPECT_NEAR(points[0] + points[1] + points[2], 10, 1e-9) << "all is spent";
    for (std::size_t s = 0; s < 3; ++s) more_than_half[s] += points[s] > 5;
  }
  for (const int count : more_than_half)
    EXPECT_NEAR(count, draws / 4.0, 4 * std::sqrt(draws * 3.0 / 16));
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

// The father has states that the mother lacks: the child's ports of grafted states are the
// father's.
TEST(EvolvedTree, AGraftedStateBringsTheGenesOfItsPorts) {
  Wired wired({.move_weight = 0, .add_weight = 1, .split_weight = 0, .remove_weight = 0});
  const evolution::Heredity heredity(wired.ecosystem);
  Rng rng = test_rng(9);
  const model::Genome mother = heredity.random(rng);
  model::Genome father = heredity.random(rng);
  while (decode(father.tree).states.size() < 3) heredity.mutate(father, rng);

  const auto inputs_of = [&](const model::Genome& genome) {
    return grn::decode(genome.controller).inputs;
  };
  const grn::PortProteins fathers = inputs_of(father), mothers = inputs_of(mother);
  std::size_t grafted = 0;
  for (int k = 0; k < 60; ++k) {
    const bool swap = k % 2 == 1;
    const model::Genome child = heredity.cross(swap ? father : mother, swap ? mother : father, rng);
    const grn::PortProteins inputs = inputs_of(child);
    for (std::size_t i = 0; i < inputs.keys.size(); ++i) {
      if (common::find_key(mothers.keys, inputs.keys[i])) continue;
      const auto at = common::find_key(fathers.keys, inputs.keys[i]);
      ASSERT_TRUE(at.has_value());
      EXPECT_EQ(inputs.proteins[i], fathers.proteins[*at]);
      ++grafted;
    }
  }
  EXPECT_GT(grafted, 0u);
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

// ---- attributes --------------------------------------------------------------------------------

const EvolvedTree::Parameters all_evolve{.budget = 9,
                                         .evolve_motility = true,
                                         .evolve_adhesion = true,
                                         .evolve_thresholds = true,
                                         .max_motility = 2,
                                         .max_adhesion = 5};

double attribute(const TreeGenes& genes, std::size_t state, const char* name) {
  const auto at = std::ranges::find(genes.attributes, stable_key(name));
  EXPECT_NE(at, genes.attributes.end()) << name;
  return genes.states[state].attributes[static_cast<std::size_t>(at - genes.attributes.begin())];
}

std::vector<somas::testing::GrownState> grown(const EvolvedTree& tree, GenesView genes) {
  somas::testing::TestTreeSink sink(skills);
  tree.grow(genes, skills, sink);
  return sink.states;
}

TEST(EvolvedTreeAttributes, DoNotEvolveUnlessTheExperimentSaysSo) {
  const EvolvedTree tree = evolved();
  Genes genes = start(tree);
  Rng rng = test_rng(1);
  for (int k = 0; k < 200; ++k) tree.heritable()->mutate({}, rng, genes);
  EXPECT_TRUE(decode(genes).attributes.empty());
  EXPECT_TRUE(decode(genes).pairs.empty());
  for (const auto& state : grown(tree, genes)) {
    EXPECT_EQ(state.motility, 0);
    EXPECT_EQ(state.adhesion, 3);
    EXPECT_EQ(state.thresholds, (std::array<double, 4>{}));
    EXPECT_TRUE(state.adhesion_with.empty());
  }
}

TEST(EvolvedTreeAttributes, BeginAsInATreeWhoseAttributesDoNotEvolve) {
  const EvolvedTree tree = evolved(all_evolve);
  const auto states = grown(tree, start(tree));
  ASSERT_EQ(states.size(), 1u);
  EXPECT_EQ(states[0].motility, 0);
  EXPECT_EQ(states[0].adhesion, 3);
  EXPECT_EQ(states[0].thresholds, (std::array<double, 4>{}));
}

TEST(EvolvedTreeAttributes, KeepTheLawsOfHeredity) {
  const EvolvedTree tree = evolved(all_evolve);
  somas::testing::expect_laws_of_heredity(*tree.heritable(), {}, 300);
}

TEST(EvolvedTreeAttributes, StayWithinTheirRangesForTenThousandMutations) {
  const EvolvedTree tree = evolved(all_evolve);
  Wired wired(all_evolve);
  Genes genes = start(tree), other = start(tree, 2), in_world = start(*wired.tree);
  Rng rng = test_rng(3);
  std::set<std::uint32_t> signals;
  bool down = false, up = false, set_pair = false, threshold = false;
  for (int event = 0; event < 10000; ++event) {
    tree.heritable()->mutate({}, rng, genes);
    wired.tree->heritable()->mutate({}, rng, in_world);
    if (event % 10 == 9) {
      Genes child;
      tree.heritable()->cross({}, genes, other, rng, child);
      other = std::exchange(genes, child);
    }
    ASSERT_NO_THROW(tree.heritable()->check({}, genes)) << event;
    ASSERT_NO_THROW(static_cast<void>(wired.ecosystem.grow(in_world))) << event;
    for (const auto& state : grown(tree, genes)) {
      ASSERT_LE(std::abs(state.motility), 2);
      ASSERT_TRUE(state.adhesion >= 0 && state.adhesion <= 5) << state.adhesion;
      for (const double strength : state.adhesion_with) ASSERT_LE(strength, 5);
      signals.insert(state.motility_signal);
      up = up || state.motility > 1.5;
      down = down || state.motility < -1.5;
      set_pair =
          set_pair || std::ranges::any_of(state.adhesion_with, [](double s) { return s > 4; });
      threshold = threshold || state.thresholds[1] > 0.9;
    }
  }
  EXPECT_EQ(signals, (std::set<std::uint32_t>{0, 1, 2})) << "all morphogens are followed";
  EXPECT_TRUE(up && down && set_pair && threshold) << "the ranges are used";
}

TEST(EvolvedTreeAttributes, SurviveJsonToTheLastBit) {
  const EvolvedTree tree = evolved(all_evolve);
  Genes genes = start(tree);
  Rng rng = test_rng(4);
  std::size_t most_pairs = 0;
  for (int k = 0; k < 500; ++k) {
    tree.heritable()->mutate({}, rng, genes);
    ASSERT_EQ(somas::testing::detail::through_json(*tree.heritable(), genes), genes);
    most_pairs = std::max(most_pairs, decode(genes).pairs.size());
  }
  EXPECT_GT(most_pairs, 0u);
}

TEST(EvolvedTreeAttributes, MutationDrawsOneAnew) {
  EvolvedTree::Parameters parameters = all_evolve;
  parameters.move_weight = parameters.add_weight = 0;
  parameters.split_weight = parameters.remove_weight = 0;
  const EvolvedTree tree = evolved(parameters);
  const Genes before = start(tree);
  const TreeState old = decode(before).states[0];
  Rng rng = test_rng(5);
  std::set<std::size_t> changed;
  for (int k = 0; k < 200; ++k) {
    Genes genes = before;
    tree.heritable()->mutate({}, rng, genes);
    const TreeState now = decode(genes).states[0];
    EXPECT_EQ(now.points, old.points);
    std::size_t differing = 0;
    for (std::size_t a = 0; a < old.attributes.size(); ++a)
      if (now.attributes[a] != old.attributes[a]) {
        ++differing;
        changed.insert(a);
      }
    EXPECT_LE(differing, 1u);
  }
  EXPECT_EQ(changed.size(), 7u) << "motility, its signal, adhesion, four thresholds";
}

TEST(EvolvedTreeAttributes, ANewStateIsACopyOfTheOneAbove) {
  EvolvedTree::Parameters parameters = all_evolve;
  parameters.move_weight = parameters.attribute_weight = 0;
  parameters.split_weight = parameters.remove_weight = 0;
  const EvolvedTree tree = evolved(parameters);
  TreeGenes genes = decode(start(tree));
  for (double& value : genes.states[0].attributes) value = 0.25;
  genes.add({7, 0, genes.states[0].points, genes.states[0].attributes});
  genes.set_adhesion(7, genes.states[0].key, 1.5);
  genes.sort();
  Genes bytes;
  encode(genes, bytes);
  Rng rng = test_rng(6);
  tree.heritable()->mutate({}, rng, bytes);
  const TreeGenes made = decode(bytes);
  ASSERT_EQ(made.states.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) EXPECT_EQ(attribute(made, s, "motility"), 0.25);
  ASSERT_EQ(made.pairs.size(), 2u) << "the copy adheres to others as its origin does";
  EXPECT_EQ(made.pairs[1].strength, 1.5);
}

TEST(EvolvedTreeAttributes, CrossingTakesEachAndEveryPairFromEitherParent) {
  const EvolvedTree tree = evolved(all_evolve);
  TreeGenes mother = decode(start(tree));
  mother.add({7, 0, mother.states[0].points, mother.states[0].attributes});
  TreeGenes father = mother;
  for (double& value : father.states[1].attributes) value = 0.5;
  father.set_adhesion(7, father.states[0].key, 4);
  Genes first, second;
  encode(mother, first);
  encode(father, second);
  std::set<double> motilities, thresholds;
  std::set<bool> paired;
  for (std::uint64_t k = 0; k < 100; ++k) {
    Rng rng = test_rng(k);
    Genes child;
    tree.heritable()->cross({}, first, second, rng, child);
    const TreeGenes made = decode(child);
    motilities.insert(attribute(made, 1, "motility"));
    thresholds.insert(attribute(made, 1, "division_threshold"));
    paired.insert(!made.pairs.empty());
  }
  EXPECT_EQ(motilities, (std::set<double>{0, 0.5}));
  EXPECT_EQ(thresholds, (std::set<double>{0, 0.5}));
  EXPECT_EQ(paired.size(), 2u);
}

TEST(EvolvedTreeAttributes, ConformToAnExperimentThatLetsOthersEvolve) {
  const EvolvedTree tree = evolved(all_evolve), plain = evolved({.budget = 9});
  EvolvedTree::Parameters narrow = all_evolve;
  narrow.evolve_thresholds = false;
  narrow.max_motility = 0.1;
  narrow.max_adhesion = 3;
  const EvolvedTree other = evolved(narrow);
  Genes genes = start(tree);
  Rng rng = test_rng(7);
  for (int k = 0; k < 100; ++k) tree.heritable()->mutate({}, rng, genes);
  for (const EvolvedTree* next : {&other, &plain, &tree}) {
    EXPECT_THROW(next->heritable()->check({}, genes), std::runtime_error);
    next->heritable()->conform({}, rng, genes);
    EXPECT_NO_THROW(next->heritable()->check({}, genes));
    const Genes before = genes;
    next->heritable()->conform({}, rng, genes);
    EXPECT_EQ(genes, before);
  }
}

TEST(EvolvedTreeAttributes, RefusesAStartBeyondTheirRange) {
  try {
    evolved({.evolve_adhesion = true, .max_adhesion = 2});
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_EQ(error.path(), "max_adhesion");
  }
}

// ---- returns -----------------------------------------------------------------------------------

// With a budget of 12 and all of it in three parts: 12 (1/3)^2 of each at its price.
TEST(EvolvedTree, AcceleratingReturnsFavourSpecialists) {
  const std::vector<SkillInfo> three = {{"a", {}}, {"b", {}}, {"c", {.maximum = 5, .cost = 2}}};
  const EvolvedTree linear = evolved({.budget = 12}, three);
  const EvolvedTree square = evolved({.budget = 12, .returns = 2}, three);
  TreeGenes genes = decode(start(linear));
  const auto values = [&](const EvolvedTree& tree, double a, double b, double c) {
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_a = genes.skills[k] == stable_key("a"),
                 is_b = genes.skills[k] == stable_key("b");
      genes.states[0].points[k] = is_a ? a : is_b ? b : c;
    }
    Genes bytes;
    encode(genes, bytes);
    somas::testing::TestTreeSink sink(three);
    tree.grow(bytes, three, sink);
    return sink.states[0].skills;
  };
  EXPECT_EQ(values(linear, 4, 4, 2), (std::vector<double>{4, 4, 2}));
  const std::vector<double> even = values(square, 4, 4, 2);
  EXPECT_NEAR(even[0], 12.0 / 9, 1e-12);
  EXPECT_NEAR(even[1], 12.0 / 9, 1e-12);
  EXPECT_NEAR(even[2], 12.0 / 9 / 2, 1e-12);
  EXPECT_NEAR(values(square, 12, 0, 0)[0], 12, 1e-12) << "a specialist has all of it";
  EXPECT_NEAR(values(square, 6, 6, 0)[0], 3, 1e-12) << "half of the budget buys a quarter";
  const EvolvedTree roots = evolved({.budget = 12, .returns = 0.5}, three);
  EXPECT_EQ(values(roots, 0, 0, 5)[2], 5) << "never beyond the range of the skill";
}

// What experiments/exp1_evolved_tree.yaml says: who takes up what a division costs a step, 0.12,
// and stores as much, has no points left to survive a particle of energy 1, whatever the division.
TEST(EvolvedTree, WithReturnsOfFourNoStateBothFeedsItselfAndSurvivesAHit) {
  const std::vector<SkillInfo> three = {{"capacity", {}}, {"production", {}}, {"resistance", {}}};
  const EvolvedTree quartic = evolved({.budget = 20, .returns = 4}, three);
  const EvolvedTree linear = evolved({.budget = 20}, three);
  const auto& quartic_trees = dynamic_cast<const TreeVariation&>(*quartic.heritable());
  const auto& linear_trees = dynamic_cast<const TreeVariation&>(*linear.heritable());
  double best_quartic = 0, best_linear = 0;
  for (double capacity = 0; capacity <= 20; capacity += 0.1)
    for (double production = 0; capacity + production <= 20; production += 0.1) {
      const double resistance = 20 - capacity - production;
      const auto best_of = [&](const TreeVariation& trees, double& best) {
        if (trees.bought(0, capacity) < 0.12 || trees.bought(0, production) < 0.12) return;
        best = std::max(best, trees.bought(0, resistance));
      };
      best_of(quartic_trees, best_quartic);
      best_of(linear_trees, best_linear);
    }
  EXPECT_LT(best_quartic, 1);
  EXPECT_GT(best_quartic, 0.5);
  EXPECT_GT(best_linear, 19) << "in proportion, armour costs the feeder next to nothing";
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
