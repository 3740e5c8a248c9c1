// What evolution does between simulations.
#include <cstddef>
#include <cstdint>

#include "somas/sdk/rng.hpp"

#include "bench/peak_memory.hpp"
#include "bench/subject.hpp"
#include "core/evolution/ranking.hpp"
#include "core/evolution/reproduction.hpp"

namespace somas::bench {
namespace {

// The champion's genome made ready to live.
void expression(benchmark::State& state) {
  measure(state, [&] {
    const model::Ecosystem& ecosystem = *shipped().ecosystem;
    for (auto _ : state) {
      const model::Phenotype phenotype = ecosystem.express(champion().individual.genome);
      benchmark::DoNotOptimize(phenotype.program.get());
    }
  });
}
BENCHMARK(expression)->MeasureProcessCPUTime();

void assign_random_fitness(evolution::Population& population, std::uint64_t generation) {
  Rng rng(1, 0, generation, stable_key("bench.fitness"), 0);
  for (evolution::Individual& individual : population)
    evolution::assign_fitness(individual, {rng.uniform()});
}

// The next generation of a population that has drifted from random genomes for a while.
void reproduction(benchmark::State& state) {
  measure(state, [&] {
    constexpr std::uint64_t drift = 20;
    forget_peak_memory();
    const evolution::Heredity heredity(*shipped().ecosystem);
    evolution::Settings settings = shipped().evolution;
    settings.population = static_cast<std::uint32_t>(state.range(0));
    evolution::Population population = evolution::initial(settings, heredity, 1);
    assign_random_fitness(population, 0);
    for (std::uint64_t generation = 1; generation <= drift; ++generation) {
      population = evolution::next(settings, heredity, population, 1, generation);
      assign_random_fitness(population, generation);
    }

    // With an evaluation that costs nothing: all that evolution adds to a generation in memory.
    for (auto _ : state) {
      auto children = evolution::next(settings, heredity, population, 1, drift + 1);
      assign_random_fitness(children, drift + 1);
      benchmark::DoNotOptimize(evolution::statistics(children).best);
    }
    double bytes = 0;
    for (const evolution::Individual& i : population)
      bytes += static_cast<double>(
          sizeof i + i.genome.controller.capacity() + i.genome.tree.capacity() +
          i.parents.capacity() * sizeof(std::uint64_t) + i.trials.capacity() * sizeof(double));
    state.counters["bytes/individual"] = bytes / static_cast<double>(population.size());
    state.counters["peak_bytes"] = peak_memory();
    state.counters["time/child"] = time_per(state, static_cast<double>(settings.population));
  });
}
BENCHMARK(reproduction)
    ->ArgName("population")
    ->Arg(400)
    ->Arg(100'000)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace somas::bench
