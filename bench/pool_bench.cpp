// What evaluator processes cost against threads of this process: the same tasks by both in turn,
// one worker each, in every iteration.
#include "core/evaluation/pool.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <vector>

#include "bench/subject.hpp"
#include "core/evaluation/thread_evaluator.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

struct Cost {
  double cpu = 0, wall = 0;  // s
};

double seconds_of(clockid_t clock) {
  timespec time{};
  if (::clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Of this process and its children; those must live on.
double cpu_seconds() {
  double sum = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream in(thread.path() / "children");
    clockid_t clock{};
    for (pid_t child = 0; in >> child;)
      if (::clock_getcpuclockid(child, &clock) == 0) sum += seconds_of(clock);
  }
  return sum;
}

Cost cost_of(evaluation::Evaluator& evaluator, const std::vector<evaluation::Task>& tasks) {
  const double cpu = cpu_seconds(), wall = seconds_of(CLOCK_MONOTONIC);
  static_cast<void>(evaluator.evaluate(tasks, {}, {}));
  return {cpu_seconds() - cpu, seconds_of(CLOCK_MONOTONIC) - wall};
}

/// Lives of the champion cut off where they have taken about so many milliseconds.
experiment::Experiment lives_of(double milliseconds) {
  for (std::uint64_t steps = 8;; steps += std::max<std::uint64_t>(1, steps / 8)) {
    auto experiment =
        experiment_1({"world.max_cells=1000", "world.max_steps=" + std::to_string(steps)});
    const std::vector<evaluation::Task> tasks = {
        run::single_task(champion().individual.genome, champion().seed)};
    evaluation::ThreadEvaluator evaluator(*experiment.ecosystem, 1);
    const double seconds = std::min({cost_of(evaluator, tasks).cpu, cost_of(evaluator, tasks).cpu,
                                     cost_of(evaluator, tasks).cpu});
    if (seconds * 1000 > 0.95 * milliseconds || steps > 3000) return experiment;
  }
}

// The argument is what a task takes, in milliseconds.
void pool_overhead(benchmark::State& state) {
  measure(state, [&] {
    const experiment::Experiment experiment = lives_of(static_cast<double>(state.range(0)));
    const auto count = static_cast<std::size_t>(400 / state.range(0));
    const std::vector<evaluation::Task> tasks(
        count, run::single_task(champion().individual.genome, champion().seed));
    evaluation::PoolOptions options;
    options.workers = 1;
    options.program = SOMAS_BINARY_DIR "/bin/somas-host";
    evaluation::Pool pool(options);
    const auto processes = pool.evaluator(experiment);
    evaluation::ThreadEvaluator threads(*experiment.ecosystem, 1);
    cost_of(*processes, tasks);  // started and warm

    // The least of each: what else the machine did is nobody's overhead.
    Cost by_threads{1e9, 1e9}, by_processes{1e9, 1e9};
    const auto keep_least = [](Cost& least, const Cost& cost) {
      least = {std::min(least.cpu, cost.cpu), std::min(least.wall, cost.wall)};
    };
    for (auto _ : state) {
      keep_least(by_threads, cost_of(threads, tasks));
      keep_least(by_processes, cost_of(*processes, tasks));
    }
    const auto percent = [](double more, double less) { return 100 * (more / less - 1); };
    state.counters["task_ms"] = 1000 * by_threads.cpu / static_cast<double>(count);
    state.counters["cpu_overhead_%"] = percent(by_processes.cpu, by_threads.cpu);
    state.counters["wall_overhead_%"] = percent(by_processes.wall, by_threads.wall);
  });
}
BENCHMARK(pool_overhead)
    ->ArgName("task_ms")
    ->Arg(1)
    ->Arg(10)
    ->Arg(100)
    ->Iterations(12)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
