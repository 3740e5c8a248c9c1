#include "core/evolution/ranking.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace somas::evolution {
namespace {

using testing::ElementsAre;

Individual individual(double fitness, std::size_t length) {
  Individual made;
  made.fitness = fitness;
  made.genome.controller.resize(length);
  return made;
}

TEST(Rank, PutsTheFittestFirst) {
  const Population population = {individual(1, 1), individual(3, 9), individual(2, 1)};
  EXPECT_THAT(rank(population), ElementsAre(1, 2, 0));
}

TEST(Rank, BreaksTiesByShorterGenomeThenByIndex) {
  const Population population = {individual(5, 8), individual(5, 7), individual(5, 8),
                                 individual(5, 7)};
  EXPECT_THAT(rank(population), ElementsAre(1, 3, 0, 2));
}

TEST(Rank, CountsBothChromosomesAsLength) {
  Population population = {individual(5, 3), individual(5, 2)};
  population[1].genome.tree.resize(2);
  EXPECT_THAT(rank(population), ElementsAre(0, 1));
}

TEST(Rank, PutsThoseThatWereSetAsideLast) {
  Population population = {individual(0, 1), individual(1, 9), individual(4, 2), individual(0, 3)};
  population[0].set_aside = population[3].set_aside = true;
  assign_worst_fitness(population);
  EXPECT_THAT(rank(population), ElementsAre(2, 1, 0, 3));
}

TEST(WorstFitness, IsTheLowestOfThoseThatWereNotSetAside) {
  Population population = {individual(9, 1), individual(-3, 1), individual(5, 1)};
  population[0].set_aside = true;
  population[0].trials = {9, 9};
  assign_worst_fitness(population);
  EXPECT_EQ(population[0].fitness, -3);
  EXPECT_THAT(population[0].trials, ElementsAre(-3, -3));
  EXPECT_EQ(population[2].fitness, 5);
  EXPECT_EQ(statistics(population).worst, -3);
}

TEST(WorstFitness, IsZeroWhereAllWereSetAside) {
  Population population = {individual(9, 1)};
  population[0].set_aside = true;
  population[0].trials = {9};
  assign_worst_fitness(population);
  EXPECT_EQ(population[0].fitness, 0);
}

TEST(Statistics, InterpolatesQuartilesLinearly) {
  const Population population = {individual(4, 1), individual(1, 1), individual(3, 1),
                                 individual(2, 1)};
  const Statistics found = statistics(population);
  EXPECT_EQ(found.best, 4);
  EXPECT_EQ(found.upper_quartile, 3.25);
  EXPECT_EQ(found.median, 2.5);
  EXPECT_EQ(found.lower_quartile, 1.75);
  EXPECT_EQ(found.worst, 1);
  EXPECT_EQ(found.mean, 2.5);
}

TEST(Statistics, OfOneIndividualAreItsFitness) {
  const Statistics found = statistics(Population{individual(7, 1)});
  EXPECT_EQ(found.best, 7);
  EXPECT_EQ(found.upper_quartile, 7);
  EXPECT_EQ(found.median, 7);
  EXPECT_EQ(found.lower_quartile, 7);
  EXPECT_EQ(found.worst, 7);
  EXPECT_EQ(found.mean, 7);
}

TEST(Fitness, IsTheMeanOverTheTrials) {
  Individual one;
  assign_fitness(one, {1, 2, 6});
  EXPECT_EQ(one.fitness, 3);
  EXPECT_THAT(one.trials, ElementsAre(1, 2, 6));
}

TEST(Operator, NamesReadBack) {
  for (int i = 0; i < 7; ++i) {
    const auto op = static_cast<Operator>(i);
    EXPECT_EQ(operator_named(name_of(op)), op);
  }
  EXPECT_EQ(name_of(Operator::crossover_mutation), "crossover+mutation");
  EXPECT_EQ(operator_named("sorcery"), std::nullopt);
}

}  // namespace
}  // namespace somas::evolution
