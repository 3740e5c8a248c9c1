#include "core/evolution/population.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace somas::evolution {
namespace {

constexpr std::array<std::string_view, 7> operator_names = {
    "random", "seed", "elite", "copy", "mutation", "crossover", "crossover+mutation"};

}  // namespace

std::string_view name_of(Operator op) { return operator_names[static_cast<std::size_t>(op)]; }

std::optional<Operator> operator_named(std::string_view name) {
  for (std::size_t i = 0; i < operator_names.size(); ++i)
    if (operator_names[i] == name) return static_cast<Operator>(i);
  return std::nullopt;
}

void assign_fitness(Individual& individual, std::vector<double> trials) {
  double sum = 0;
  for (const double score : trials) sum += score;
  individual.fitness = trials.empty() ? 0 : sum / static_cast<double>(trials.size());
  individual.trials = std::move(trials);
}

void assign_worst_fitness(Population& population) {
  std::optional<double> worst;
  for (const Individual& individual : population)
    if (!individual.set_aside)
      worst = std::min(worst.value_or(individual.fitness), individual.fitness);
  for (Individual& individual : population)
    if (individual.set_aside)
      assign_fitness(individual, std::vector<double>(individual.trials.size(), worst.value_or(0)));
}

}  // namespace somas::evolution
