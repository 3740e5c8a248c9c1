// Individuals and where they come from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/model/ecosystem.hpp"

namespace somas::evolution {

/// How an individual came to be.
enum class Operator : std::uint8_t {
  random,              ///< fresh random genes
  seed,                ///< a saved genome that was given to the first generation
  elite,               ///< one of the best, unchanged, to be evaluated again
  copy,                ///< unchanged, chosen by tournament
  mutation,            ///< one parent, mutated
  crossover,           ///< two parents
  crossover_mutation,  ///< two parents, then mutated
};

/// "random", "seed", "elite", "copy", "mutation", "crossover", "crossover+mutation".
[[nodiscard]] std::string_view name_of(Operator op);
[[nodiscard]] std::optional<Operator> operator_named(std::string_view name);

struct Individual {
  std::uint64_t id = 0;  ///< unique in its population: generation * size + index
  Operator origin = Operator::random;
  std::vector<std::uint64_t> parents;  ///< 0 to 2 ids
  model::Genome genome;
  std::vector<double> trials;  ///< fitness of each trial, empty before the evaluation
  double fitness = 0;          ///< mean over the trials
  double cost = 0;             ///< cell steps of its trials; before the evaluation, of its parents'
  bool set_aside = false;      ///< plugins failed in a trial: ranks below all others
};

/// In the order of birth; the index decides the last ties.
using Population = std::vector<Individual>;

/// Sets trials and their mean (summed in the order of the trials).
void assign_fitness(Individual& individual, std::vector<double> trials);

/// Gives those that were set aside the worst fitness, in all trials: the lowest of those that were
/// not, or 0 if there are none. So it is finite, and no better for a failure than for an honest
/// life.
void assign_worst_fitness(Population& population);

}  // namespace somas::evolution
