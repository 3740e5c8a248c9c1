// What a run does between simulations, with everything stored.
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

#include "bench/peak_memory.hpp"
#include "bench/subject.hpp"
#include "core/run/coordinator.hpp"
#include "core/run/manifest.hpp"
#include "core/run/run_directory.hpp"

namespace somas::bench {
namespace {

/// All live for a step, at no cost.
class Trivial final : public evaluation::Evaluator {
 public:
  std::optional<std::vector<evaluation::Result>> evaluate(
      std::span<const evaluation::Task> tasks, evaluation::StopToken,
      const evaluation::ResultCallback& finished) override {
    evaluation::Row row;
    row.outcome.survival = 1;
    row.outcome.censored = true;
    row.score = 1;
    const evaluation::Result result{{row}};
    for (std::size_t t = 0; t < tasks.size(); ++t) finished(t, result);
    return std::vector<evaluation::Result>(tasks.size(), result);
  }
  std::optional<evaluation::Reference> reference() override { return std::nullopt; }
  void expect(const evaluation::Reference&) override {}
};

/// A file system in memory, where there is one: what a disk takes to flush is not what is measured.
std::filesystem::path scratch_directory() {
  std::error_code error;
  const bool memory = std::filesystem::is_directory("/dev/shm", error);
  std::string name =
      ((memory ? "/dev/shm" : std::filesystem::temp_directory_path()) / "somas-bench.XXXXXX")
          .string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch directory");
  return name;
}

// Selection, variation, journal, store, CSV files and the champion's file: generations of a run
// whose simulations cost nothing.
void stored_generation(benchmark::State& state) {
  measure(state, [&] {
    const int generations = state.range(0) > 10'000 ? 3 : 20;
    forget_peak_memory();
    const experiment::Experiment experiment =
        experiment_1({"world.max_steps=1", "evolution.generations=" + std::to_string(generations),
                      "evolution.population=" + std::to_string(state.range(0))});
    Trivial evaluator;
    const std::filesystem::path scratch = scratch_directory();
    for (auto _ : state) {
      state.PauseTiming();
      std::filesystem::remove_all(scratch / "run");
      std::filesystem::create_directory(scratch / "run");
      run::RunDirectory directory(scratch / "run", experiment, run::manifest_of(experiment, {}),
                                  {});
      run::Coordinator coordinator({experiment, evaluator, 1, directory}, {});
      state.ResumeTiming();
      coordinator.all_generations();
    }
    std::filesystem::remove_all(scratch);
    state.counters["peak_bytes"] = peak_memory();
    state.counters["time/generation"] = time_per(state, generations);
  });
}
BENCHMARK(stored_generation)
    ->ArgName("population")
    ->Arg(400)
    ->Arg(100'000)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
