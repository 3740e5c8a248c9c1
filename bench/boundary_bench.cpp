// What the binary boundary costs: lives of experiment 1 with plugins that were loaded from files,
// against the same sources compiled into this program, in turn.
#include <algorithm>
#include <ctime>
#include <stdexcept>
#include <vector>

#include "bench/compiled_in.hpp"
#include "bench/subject.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

double cpu_seconds() {
  timespec time{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A life of the champion, by whichever plugins.
class Lives {
 public:
  explicit Lives(const experiment::Experiment& experiment)
      : ecosystem_(*experiment.ecosystem),
        task_(run::single_task(champion().individual.genome, champion().seed)) {}

  /// CPU time of one.
  double live() {
    const double before = cpu_seconds();
    outcome_ = evaluation::simulate(ecosystem_, task_).value().rows.at(0).outcome;
    return cpu_seconds() - before;
  }
  [[nodiscard]] const Outcome& outcome() const { return outcome_; }

 private:
  const model::Ecosystem& ecosystem_;
  evaluation::Task task_;
  Outcome outcome_;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void boundary(benchmark::State& state) {
  measure(state, [&] {
    const std::filesystem::path file = SOMAS_SOURCE_DIR "/experiments/exp1.yaml";
    const experiment::Experiment within = experiment::load(
        file, {.overrides = {}, .plugin_directories = {}, .linked_in = compiled_in()});
    Lives loaded(shipped()), linked(within);
    static_cast<void>(loaded.live() + linked.live());  // warm
    if (loaded.outcome().cell_steps != linked.outcome().cell_steps)
      throw std::runtime_error("the plugins compiled in lead another life");

    // Who is first in a pair changes from pair to pair.
    std::vector<double> by_files, by_links, ratios;
    bool turn = false;
    for (auto _ : state) {
      const double first = turn ? linked.live() : loaded.live();
      const double second = turn ? loaded.live() : linked.live();
      by_files.push_back(turn ? second : first);
      by_links.push_back(turn ? first : second);
      ratios.push_back(by_files.back() / by_links.back());
      turn = !turn;
    }
    const auto percent = [](double ratio) { return 100 * (ratio - 1); };
    state.counters["loaded_ms"] = 1000 * median(by_files);
    state.counters["linked_ms"] = 1000 * median(by_links);
    state.counters["cost_%"] = percent(median(ratios));
    state.counters["cost_of_least_%"] =
        percent(*std::min_element(by_files.begin(), by_files.end()) /
                *std::min_element(by_links.begin(), by_links.end()));
  });
}
BENCHMARK(boundary)->Iterations(40)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
