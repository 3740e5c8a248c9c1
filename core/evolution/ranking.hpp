// Who is better than whom, and what a generation looks like in numbers.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/evolution/population.hpp"

namespace somas::evolution {

/// Indices of an evaluated population, best first: those that were not set aside, higher fitness,
/// shorter genome, index.
[[nodiscard]] std::vector<std::size_t> rank(std::span<const Individual> population);

/// Of ascending values, at least one; fraction in [0, 1]. Interpolates linearly between order
/// statistics (R's type 7).
[[nodiscard]] double quantile(std::span<const double> sorted, double fraction);

/// Quartiles interpolate linearly between order statistics (R's type 7).
struct Statistics {
  double best = 0, upper_quartile = 0, median = 0, lower_quartile = 0, worst = 0, mean = 0;
};

/// Precondition: the population is not empty.
[[nodiscard]] Statistics statistics(std::span<const Individual> population);

}  // namespace somas::evolution
