// A busy life, with and without a recorder, for the tests of recordings.
#pragma once

#include <cstdint>
#include <vector>

#include "core/recording/recorder.hpp"
#include "tests/core/model/support.hpp"

namespace somas::recording::test {

/// The world in which everything happens, with two organisms that feed each other.
inline void set_up(model::test::Bench& bench, std::uint64_t steps = 120) {
  model::test::Busy().set_up(bench);
  bench.config.max_steps = steps;
  bench.config.max_cells = 24;
  bench.config.strangers = {.adhere = true, .feed = true};
  bench.founders = {{.key = 9, .x = -1}, {.key = 4, .x = 1}};
  bench.seed = 3;
}

/// Runs to the end; the hash of the world after every step.
inline std::vector<std::uint64_t> live(model::Simulation& simulation, Recorder* recorder) {
  std::vector<std::uint64_t> hashes;
  simulation.tell(recorder);
  for (bool more = true; more;) {
    more = simulation.step();
    if (recorder != nullptr) recorder->observe(simulation);
    hashes.push_back(simulation.hash());
  }
  evaluation::Result result;
  for (const Outcome& outcome : simulation.outcomes())
    result.rows.push_back({outcome, static_cast<double>(outcome.survival)});
  if (recorder != nullptr) recorder->finish(result);
  return hashes;
}

/// The whole life, of the first organism of the roster.
inline Recording record(model::test::Bench& bench, RecorderOptions options = {}) {
  model::Simulation& simulation = bench.start();
  Collector collector;
  Recorder recorder(bench.ecosystem(), 0, collector, {.experiment = "busy"}, options);
  live(simulation, &recorder);
  return collector.take();
}

}  // namespace somas::recording::test
