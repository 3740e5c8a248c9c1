#include "core/evolution/reproduction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evolution/ranking.hpp"
#include "tests/core/evolution/toy_heritable.hpp"

namespace somas::evolution {
namespace {

using test::ToyHeritable;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Ports that exist for their number alone.
struct ToyPorts {
  explicit ToyPorts(std::size_t outputs) : ports(outputs) { layout.outputs = ports; }
  std::vector<Port> ports;
  Layout layout;
};

std::shared_ptr<const Layout> ports(std::size_t outputs) {
  auto owner = std::make_shared<const ToyPorts>(outputs);
  return {owner, &owner->layout};
}

class Reproduction : public testing::Test {
 protected:
  static constexpr std::size_t genes = 8;

  Reproduction() { settings_.population = 100; }

  /// Generation 0 with fitness by gene sum.
  Population evaluated(Population population) const {
    for (Individual& one : population) {
      double sum = 0;
      for (const std::uint8_t gene : one.genome.controller) sum += gene;
      assign_fitness(one, {sum});
    }
    return population;
  }
  Population first(std::uint64_t seed = 1) const {
    return evaluated(initial(settings_, heredity_, seed));
  }

  ToyHeritable part_;
  Heredity heredity_{part_, ports(genes)};
  Settings settings_;
};

bool same(const Population& a, const Population& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Individual& x, const Individual& y) {
                      return x.id == y.id && x.genome == y.genome && x.parents == y.parents &&
                             x.origin == y.origin;
                    });
}

// ---- generation 0 ------------------------------------------------------------------------------

TEST_F(Reproduction, InitialIsAFunctionOfTheSeed) {
  EXPECT_TRUE(same(initial(settings_, heredity_, 7), initial(settings_, heredity_, 7)));
  EXPECT_FALSE(same(initial(settings_, heredity_, 7), initial(settings_, heredity_, 8)));
}

TEST_F(Reproduction, AnIndividualDoesNotDependOnTheSizeOfThePopulation) {
  const Population all = initial(settings_, heredity_, 3);
  settings_.population = 10;
  const Population few = initial(settings_, heredity_, 3);
  for (std::size_t i = 0; i < few.size(); ++i) EXPECT_EQ(few[i].genome, all[i].genome);
}

TEST_F(Reproduction, InitialIsRandomWithoutParents) {
  for (const Individual& one : initial(settings_, heredity_, 1)) {
    EXPECT_EQ(one.origin, Operator::random);
    EXPECT_THAT(one.parents, IsEmpty());
    EXPECT_THAT(one.genome.controller, SizeIs(genes));
  }
}

TEST_F(Reproduction, GivenGenomesComeFirstAndAreMadeToFit) {
  const std::vector<model::Genome> given = {{Genes(genes, 42), {}}, {Genes(3, 43), {}}};
  const Population population = initial(settings_, heredity_, 1, given);
  EXPECT_EQ(population[0].genome, given[0]);
  EXPECT_EQ(population[0].origin, Operator::seed);
  EXPECT_EQ(population[1].origin, Operator::seed);
  EXPECT_THAT(population[1].genome.controller, SizeIs(genes));
  EXPECT_EQ(population[1].genome.controller[2], 43);
  EXPECT_EQ(population[2].origin, Operator::random);
}

// ---- the next generation -----------------------------------------------------------------------

TEST_F(Reproduction, NextIsAFunctionOfItsArguments) {
  const Population parents = first();
  const Population next_one = next(settings_, heredity_, parents, 1, 1);
  EXPECT_TRUE(same(next_one, next(settings_, heredity_, parents, 1, 1)));
  EXPECT_FALSE(same(next_one, next(settings_, heredity_, parents, 2, 1)));
  EXPECT_FALSE(same(next_one, next(settings_, heredity_, parents, 1, 2)));
}

TEST_F(Reproduction, ElitesAreTwoPercentAndAtLeastOne) {
  const auto elites_of = [&](std::uint32_t population) {
    settings_.population = population;
    return elite_count(settings_);
  };
  EXPECT_EQ(elites_of(1), 1u);
  EXPECT_EQ(elites_of(49), 1u);
  EXPECT_EQ(elites_of(50), 1u);
  EXPECT_EQ(elites_of(100), 2u);
  EXPECT_EQ(elites_of(149), 2u);
  EXPECT_EQ(elites_of(150), 3u);
  EXPECT_EQ(elites_of(400), 8u);
  settings_.elite_fraction = 0.29;
  EXPECT_EQ(elites_of(100), 29u);
  settings_.elite_fraction = 0;
  EXPECT_EQ(elites_of(100), 1u);
}

TEST_F(Reproduction, ElitesAreTheBestUnchangedAndUnevaluated) {
  const Population parents = first();
  const std::vector<std::size_t> ranking = rank(parents);
  const Population children = next(settings_, heredity_, parents, 1, 1);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(children[i].origin, Operator::elite);
    EXPECT_EQ(children[i].genome, parents[ranking[i]].genome);
    EXPECT_THAT(children[i].parents, ElementsAre(parents[ranking[i]].id));
    EXPECT_THAT(children[i].trials, IsEmpty());
  }
  EXPECT_NE(children[2].origin, Operator::elite);
}

TEST_F(Reproduction, IdsAreUniqueInARun) {
  std::set<std::uint64_t> seen;
  Population population = first();
  for (std::uint64_t generation = 1; generation <= 5; ++generation) {
    for (const Individual& one : population) EXPECT_TRUE(seen.insert(one.id).second);
    population = evaluated(next(settings_, heredity_, population, 1, generation));
  }
}

TEST_F(Reproduction, LineageNamesRealParentsAndTellsTheOperator) {
  const Population parents = first();
  std::map<std::uint64_t, const Individual*> by_id;
  for (const Individual& parent : parents) by_id[parent.id] = &parent;

  for (const Individual& child : next(settings_, heredity_, parents, 1, 1)) {
    const bool crossed =
        child.origin == Operator::crossover || child.origin == Operator::crossover_mutation;
    ASSERT_THAT(child.parents, SizeIs(crossed ? 2 : 1));
    for (const std::uint64_t id : child.parents) ASSERT_TRUE(by_id.contains(id));
    const Genes& mother = by_id[child.parents.front()]->genome.controller;
    const Genes& father = by_id[child.parents.back()]->genome.controller;
    // Each gene is a parent's, but for the one that a mutation raised.
    std::size_t strange = 0;
    for (std::size_t i = 0; i < genes; ++i)
      strange += child.genome.controller[i] != mother[i] && child.genome.controller[i] != father[i];
    const bool mutated =
        child.origin == Operator::mutation || child.origin == Operator::crossover_mutation;
    EXPECT_LE(strange, mutated ? 1u : 0u);
    const bool changed = crossed || child.origin == Operator::mutation;
    EXPECT_TRUE(changed || child.genome.controller == mother);
    EXPECT_TRUE(child.origin != Operator::mutation || child.genome.controller != mother);
    EXPECT_TRUE(!crossed || child.parents[0] != child.parents[1]);
  }
}

// The seeds are fixed, so the bounds (4 standard deviations) either hold for ever or never.
TEST_F(Reproduction, OperatorsAreAsFrequentAsTheSettingsSay) {
  settings_.population = 20000;
  const Population parents = first();
  std::map<Operator, double> count;
  for (const Individual& child : next(settings_, heredity_, parents, 1, 1))
    count[child.origin] += 1;
  const double n = settings_.population - elite_count(settings_);
  const auto expect_share = [&](Operator op, double p) {
    EXPECT_NEAR(count[op] / n, p, 4 * std::sqrt(p * (1 - p) / n)) << name_of(op);
  };
  EXPECT_EQ(count[Operator::elite], 400);
  expect_share(Operator::crossover_mutation, 0.5 * 0.8);
  expect_share(Operator::crossover, 0.5 * 0.2);
  expect_share(Operator::mutation, 0.5 * 0.8);
  expect_share(Operator::copy, 0.5 * 0.2);
}

TEST_F(Reproduction, ProbabilitiesOfZeroAndOneAreCertain) {
  const Population parents = first();
  settings_.crossover = 0;
  settings_.mutation = 0;
  for (const Individual& child : next(settings_, heredity_, parents, 1, 1))
    EXPECT_TRUE(child.origin == Operator::copy || child.origin == Operator::elite);
  settings_.mutation = 1;
  for (const Individual& child : next(settings_, heredity_, parents, 1, 1))
    EXPECT_TRUE(child.origin == Operator::mutation || child.origin == Operator::elite);
}

TEST_F(Reproduction, APopulationOfOneIsItsOwnElite) {
  settings_.population = 1;
  const Population children = next(settings_, heredity_, first(), 1, 1);
  ASSERT_THAT(children, SizeIs(1));
  EXPECT_EQ(children[0].origin, Operator::elite);
}

// ---- selection ---------------------------------------------------------------------------------

// P(the winner's place is r or worse) = ((n - r) / n)^k for k draws with replacement from n.
TEST_F(Reproduction, TournamentFollowsItsClosedForm) {
  constexpr std::size_t n = 10;
  constexpr double draws = 100000;
  for (const std::uint32_t k : {1u, 2u, 4u}) {
    Rng rng(11, 0, 0, 0, k);
    std::array<double, n> wins{};
    for (int i = 0; i < static_cast<int>(draws); ++i) wins[tournament(n, k, rng)] += 1;
    for (std::size_t r = 0; r < n; ++r) {
      const double worse = static_cast<double>(n - r - 1) / n;
      const double p = std::pow(static_cast<double>(n - r) / n, k) - std::pow(worse, k);
      EXPECT_NEAR(wins[r] / draws, p, 4 * std::sqrt(p * (1 - p) / draws)) << k << " " << r;
    }
  }
}

TEST_F(Reproduction, SelectionFindsTheOptimumOfATrivialProblem) {
  settings_.elite_fraction = 0.02;
  Population population = first();
  const double start = statistics(population).best;
  for (std::uint64_t generation = 1; generation <= 40; ++generation)
    population = evaluated(next(settings_, heredity_, population, 1, generation));
  EXPECT_GT(statistics(population).median, start);
}

// ---- seeds of the evaluations ------------------------------------------------------------------

TEST(TrialSeed, DiffersByRunGenerationAndTrial) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed : {1u, 2u})
    for (std::uint64_t generation : {0u, 1u, 2u})
      for (std::uint32_t trial : {0u, 1u}) seeds.insert(trial_seed(seed, generation, trial));
  EXPECT_THAT(seeds, SizeIs(12));
  EXPECT_EQ(trial_seed(1, 2, 3), trial_seed(1, 2, 3));
}

// ---- trees that evolve -------------------------------------------------------------------------

/// The tree's single gene is the number of ports, 1 to 4.
class EvolvingTree : public testing::Test {
 protected:
  static std::size_t ports_for(GenesView genes) { return 1u + genes[0] % 4u; }

  ToyHeritable controller_, tree_;
  Heredity heredity_{controller_, tree_, [](GenesView genes) { return ports(ports_for(genes)); }};
  Settings settings_;
};

TEST_F(EvolvingTree, ControllersFitTheirOwnTreeForGenerations) {
  settings_.population = 60;
  Population population = initial(settings_, heredity_, 5);
  for (std::uint64_t generation = 1; generation <= 20; ++generation) {
    for (Individual& one : population) {
      ASSERT_EQ(one.genome.controller.size(), ports_for(one.genome.tree));
      heredity_.check(one.genome);
      assign_fitness(one, {static_cast<double>(one.genome.controller[0])});
    }
    population = next(settings_, heredity_, population, 5, generation);
  }
}

TEST_F(EvolvingTree, MutationsFallOnEitherPart) {
  Rng rng(1, 2, 3, 4, 5);
  int in_tree = 0;
  for (int i = 0; i < 1000; ++i) {
    model::Genome genome{Genes(1, 10), Genes(1, 0)};
    heredity_.mutate(genome, rng);
    in_tree += genome.tree[0] != 0;
    EXPECT_EQ(genome.controller.size(), ports_for(genome.tree));
  }
  EXPECT_NEAR(in_tree, 500, 65);
}

TEST_F(EvolvingTree, AGenomeWithoutTreeGenesIsGivenSome) {
  Rng rng(1, 2, 3, 4, 5);
  model::Genome genome{Genes(9, 1), {}};
  heredity_.conform(genome, rng);
  heredity_.check(genome);
}

// ---- plugins that fail -------------------------------------------------------------------------

TEST(Heredity, NamesThePartAndTheCallThatFailed) {
  const ToyHeritable part;
  const Heredity heredity(part, part, [](GenesView) -> Heredity::SharedLayout {
    throw ParameterError("states", "a tree without leaves");
  });
  Rng rng(1, 1, 1, 1, 1);
  try {
    static_cast<void>(heredity.random(rng));
    FAIL() << "no exception";
  } catch (const model::PluginFailure& failure) {
    EXPECT_EQ(failure.instance(), "specialization");
    EXPECT_EQ(failure.call(), "grow");
    EXPECT_THAT(failure.what(), HasSubstr("a tree without leaves"));
  }
}

TEST_F(Reproduction, WhatAChildWillCostIsGuessedFromItsParents) {
  Population parents = first();
  for (Individual& parent : parents) parent.cost = static_cast<double>(parent.id);
  for (const Individual& child : next(settings_, heredity_, parents, 1, 1)) {
    double sum = 0;
    for (const std::uint64_t parent : child.parents) sum += static_cast<double>(parent);
    EXPECT_EQ(child.cost, sum / static_cast<double>(child.parents.size()));
  }
}

}  // namespace
}  // namespace somas::evolution
