// Parameters of the genetic algorithm (docs/model.md, section 7).
#pragma once

#include <cstdint>

namespace somas::evolution {

struct Settings {
  std::uint32_t population = 400;
  std::uint32_t generations = 120;
  std::uint32_t tournament = 4;  ///< drawn with replacement
  double elite_fraction = 0.02;  ///< elites = max(1, floor(fraction * population))
  double crossover = 0.5;        ///< probability that a child has two parents
  double mutation = 0.8;         ///< probability that a child is mutated
  std::uint32_t trials = 1;      ///< simulations averaged per evaluation
};

}  // namespace somas::evolution
