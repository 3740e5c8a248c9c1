// From one generation to the next (docs/model.md, section 7). Everything here is a pure function of
// its arguments: each child draws from a random stream of its own, named by seed, generation and
// index, so that neither order nor threads can matter.
#pragma once

#include <cstdint>
#include <span>

#include "core/evolution/heredity.hpp"
#include "core/evolution/population.hpp"
#include "core/evolution/settings.hpp"

namespace somas::evolution {

/// max(1, floor(elite_fraction * population)), at most the population.
[[nodiscard]] std::uint32_t elite_count(const Settings& settings);

/// The simulation seed that all individuals of a generation face in a trial.
[[nodiscard]] std::uint64_t trial_seed(std::uint64_t seed, std::uint64_t generation,
                                       std::uint32_t trial);

/// The seed of the variation within a population (counted from 0); the run's own for the first.
[[nodiscard]] std::uint64_t population_seed(std::uint64_t seed, std::uint32_t population);

/// The best of `size` draws with replacement, as a place in the ranking (0: the best).
/// Preconditions: population > 0, size > 0.
[[nodiscard]] std::size_t tournament(std::size_t population, std::uint32_t size, Rng& rng);

/// Generation 0: the given genomes first, made to fit and in their order, the rest random. Genomes
/// beyond the size of the population are left out.
[[nodiscard]] Population initial(const Settings& settings, const Heredity& heredity,
                                 std::uint64_t seed, std::span<const model::Genome> given = {});

/// Generation `generation` >= 1 from the evaluated one before it: the elites, best first, then
/// children of tournament winners. A second parent that turns out to be the first one again leaves
/// the child with one parent (crossing with oneself gives oneself).
[[nodiscard]] Population next(const Settings& settings, const Heredity& heredity,
                              std::span<const Individual> parents, std::uint64_t seed,
                              std::uint64_t generation);

}  // namespace somas::evolution
