#include "core/evolution/ranking.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace somas::evolution {

double quantile(std::span<const double> sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(place));
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double share = place - std::floor(place);
  return sorted[below] + share * (sorted[above] - sorted[below]);
}

std::vector<std::size_t> rank(std::span<const Individual> population) {
  std::vector<std::size_t> order(population.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Individual &first = population[a], &second = population[b];
    if (first.set_aside != second.set_aside) return second.set_aside;
    if (first.fitness != second.fitness) return first.fitness > second.fitness;
    const std::size_t length = first.genome.length(), other = second.genome.length();
    return length != other ? length < other : a < b;
  });
  return order;
}

Statistics statistics(std::span<const Individual> population) {
  assert(!population.empty());
  std::vector<double> sorted;
  for (const Individual& individual : population) sorted.push_back(individual.fitness);
  // The mean is summed in ascending order: it must not depend on who stands where.
  std::sort(sorted.begin(), sorted.end());
  const double sum = std::accumulate(sorted.begin(), sorted.end(), 0.0);
  return {.best = sorted.back(),
          .upper_quartile = quantile(sorted, 0.75),
          .median = quantile(sorted, 0.5),
          .lower_quartile = quantile(sorted, 0.25),
          .worst = sorted.front(),
          .mean = sum / static_cast<double>(sorted.size())};
}

}  // namespace somas::evolution
