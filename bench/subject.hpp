// What is measured: experiment 1 as shipped, a recorded champion of it, and bodies of cells placed
// by rule.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/experiment/experiment.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/simulation.hpp"
#include "core/run/champion.hpp"

namespace somas::bench {

/// experiments/exp1.yaml with these overrides. Throws what experiment::load throws.
[[nodiscard]] experiment::Experiment experiment_1(const std::vector<std::string>& overrides = {});

/// experiment_1() without overrides, loaded at the first call.
[[nodiscard]] const experiment::Experiment& shipped();

/// bench/data/champion_exp1.json, read at the first call.
[[nodiscard]] const run::Champion& champion();

/// A simulation of the champion whose founder has become a round body of `cells` cells: a jittered
/// hexagonal lattice near rest distance, numbered from the middle outwards, nutritive inside,
/// defensive outside, all of them quiescent, with the contacts of one step of mechanics. Up to 250
/// cells in the world as shipped, above in one whose grids grow with them (scaled_world).
class Body {
 public:
  explicit Body(std::uint32_t cells);

  [[nodiscard]] const model::Ecosystem& ecosystem() const { return *experiment_.ecosystem; }
  [[nodiscard]] model::WorldState& state() { return simulation_->mutable_state(); }
  [[nodiscard]] const model::Phenotype& phenotype() const { return phenotype_; }

 private:
  experiment::Experiment experiment_;
  model::Phenotype phenotype_;
  std::unique_ptr<model::Simulation> simulation_;
};

/// What mechanics has of cells, in canonical order; of unit mass and one kind.
[[nodiscard]] std::vector<model::Body> bodies_of(const model::CellStore& cells);

/// Random values in [0, 1), the same at every call.
[[nodiscard]] model::FloatMatrix noise(std::uint32_t channels, std::uint32_t lanes);

/// Runs the body of a benchmark; what it throws becomes the benchmark's error.
template <class Measure>
void measure(benchmark::State& state, Measure&& body) {
  try {
    body();
  } catch (const std::exception& error) {
    state.SkipWithError(error.what());
  }
}

/// CPU time for each of `items` things done in every iteration; in seconds, shown as ns or us.
[[nodiscard]] inline benchmark::Counter time_per(const benchmark::State& state, double items) {
  return {items * static_cast<double>(state.iterations()),
          benchmark::Counter::Flags(benchmark::Counter::kIsRate | benchmark::Counter::kInvert)};
}

/// `items` of every iteration per second of CPU time.
[[nodiscard]] inline benchmark::Counter per_second(const benchmark::State& state, double items) {
  return {items * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate};
}

}  // namespace somas::bench
