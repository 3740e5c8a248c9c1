#include "core/evolution/population.hpp"

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

}  // namespace somas::evolution
