// The work that evolution consists of: one life of a champion, from the founder to the last death.
#include <cstdint>
#include <stdexcept>
#include <string>

#include "bench/subject.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

bool as_recorded(const Outcome& outcome) {
  const Outcome& recorded = champion().life.outcome;
  return outcome.survival == recorded.survival && outcome.cell_steps == recorded.cell_steps &&
         outcome.divisions == recorded.divisions;
}

// The argument is world.max_cells.
void whole_simulation(benchmark::State& state) {
  measure(state, [&] {
    const auto experiment = experiment_1({"world.max_cells=" + std::to_string(state.range(0))});
    const evaluation::Task task = run::single_task(champion().individual.genome, champion().seed);
    Outcome outcome;
    for (auto _ : state)
      outcome = evaluation::simulate(*experiment.ecosystem, task).value().rows.at(0).outcome;

    const auto steps = static_cast<double>(outcome.survival);
    state.counters["time/cell_step"] = time_per(state, outcome.cell_steps);
    state.counters["cell_steps"] = per_second(state, outcome.cell_steps);
    state.counters["cells_mean"] = outcome.cell_steps / steps;
    state.counters["cells_peak"] = outcome.peak_cells;
    state.counters["steps"] = steps;
    if (experiment.ecosystem->config().max_cells == shipped().ecosystem->config().max_cells)
      state.SetLabel(as_recorded(outcome) ? "the recorded life" : "not the recorded life");
  });
}
BENCHMARK(whole_simulation)
    ->ArgName("max_cells")
    ->Arg(250)
    ->Arg(1000)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
