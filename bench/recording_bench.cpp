// What a recording costs beside the life it records, as runs do it.
#include <cstdint>
#include <string>

#include "bench/subject.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/recording/file.hpp"
#include "core/recording/recorder.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

// The argument is the number of steps between frames; 0: nothing is recorded.
void recorded_life(benchmark::State& state) {
  measure(state, [&] {
    const evaluation::Task task = run::single_task(champion().individual.genome, champion().seed);
    const auto every = static_cast<std::uint64_t>(state.range(0));
    std::size_t bytes = 0;
    for (auto _ : state) {
      if (every == 0) {
        benchmark::DoNotOptimize(run::record_life(*shipped().ecosystem, task, 0));
        continue;
      }
      recording::FileWriter writer;
      recording::Recorder recorder(*shipped().ecosystem, 0, writer, {},
                                   {.every = every, .fields_every = every});
      benchmark::DoNotOptimize(run::record_life(*shipped().ecosystem, task, 0, {}, {}, &recorder));
      bytes = writer.bytes().size();
    }
    state.counters["bytes"] = static_cast<double>(bytes);
    state.counters["steps"] = static_cast<double>(champion().life.outcome.survival);
  });
}
BENCHMARK(recorded_life)
    ->ArgName("every")
    ->Arg(0)
    ->Arg(1)
    ->Arg(10)
    ->Arg(100)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
