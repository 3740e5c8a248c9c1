#include "core/evolution/reproduction.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/evolution/ranking.hpp"

namespace somas::evolution {
namespace {

Rng child_stream(std::uint64_t seed, std::uint64_t generation, std::uint64_t index) {
  return {seed, 0, generation, stable_key("child"), index};
}

Operator origin_of(bool crossed, bool mutated) {
  if (crossed) return mutated ? Operator::crossover_mutation : Operator::crossover;
  return mutated ? Operator::mutation : Operator::copy;
}

Individual elite_of(const Individual& parent) {
  Individual child;
  child.origin = Operator::elite;
  child.parents = {parent.id};
  child.genome = parent.genome;
  child.cost = parent.cost;
  return child;
}

Individual child_of(const Settings& settings, const Heredity& heredity,
                    std::span<const Individual> parents, std::span<const std::size_t> ranking,
                    Rng& rng) {
  const std::size_t first = ranking[tournament(parents.size(), settings.tournament, rng)];
  std::size_t second = first;
  if (rng.chance(settings.crossover))
    second = ranking[tournament(parents.size(), settings.tournament, rng)];
  const bool mutated = rng.chance(settings.mutation);

  Individual child;
  child.origin = origin_of(second != first, mutated);
  child.parents = {parents[first].id};
  if (second != first) child.parents.push_back(parents[second].id);
  child.cost = (parents[first].cost + parents[second].cost) / 2;

  child.genome = second == first
                     ? parents[first].genome
                     : heredity.cross(parents[first].genome, parents[second].genome, rng);
  if (mutated) heredity.mutate(child.genome, rng);
  return child;
}

}  // namespace

std::uint32_t elite_count(const Settings& settings) {
  // The little extra keeps 0.29 * 100, which is 28.999999999999996, from losing an elite.
  const double share = std::floor(settings.elite_fraction * settings.population + 1e-9);
  const auto count = static_cast<std::uint32_t>(std::max(1.0, share));
  return std::min(count, settings.population);
}

std::uint64_t trial_seed(std::uint64_t seed, std::uint64_t generation, std::uint32_t trial) {
  return Rng(seed, 0, generation, stable_key("trial"), trial).bits();
}

std::uint64_t population_seed(std::uint64_t seed, std::uint32_t population) {
  return population == 0 ? seed : Rng(seed, 0, 0, stable_key("population"), population).bits();
}

std::size_t tournament(std::size_t population, std::uint32_t size, Rng& rng) {
  assert(population > 0 && size > 0);
  std::uint64_t best = rng.below(population);
  for (std::uint32_t i = 1; i < size; ++i) best = std::min(best, rng.below(population));
  return best;
}

Population initial(const Settings& settings, const Heredity& heredity, std::uint64_t seed,
                   std::span<const model::Genome> given) {
  Population population(settings.population);
  for (std::size_t i = 0; i < population.size(); ++i) {
    Individual& individual = population[i];
    Rng rng = child_stream(seed, 0, i);
    individual.id = i;
    if (i < given.size()) {
      individual.origin = Operator::seed;
      individual.genome = given[i];
      heredity.conform(individual.genome, rng);
    } else {
      individual.origin = Operator::random;
      individual.genome = heredity.random(rng);
    }
  }
  return population;
}

Population next(const Settings& settings, const Heredity& heredity,
                std::span<const Individual> parents, std::uint64_t seed, std::uint64_t generation) {
  assert(!parents.empty() && generation > 0);
  const std::vector<std::size_t> ranking = rank(parents);
  const std::size_t elites = std::min<std::size_t>(elite_count(settings), parents.size());

  Population population;
  population.reserve(settings.population);
  for (std::size_t i = 0; i < settings.population; ++i) {
    Rng rng = child_stream(seed, generation, i);
    population.push_back(i < elites ? elite_of(parents[ranking[i]])
                                    : child_of(settings, heredity, parents, ranking, rng));
    population.back().id = generation * settings.population + i;
  }
  return population;
}

}  // namespace somas::evolution
