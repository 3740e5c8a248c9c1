// What this core gives this process just now, to tell a slow machine from slow code.
#include <array>
#include <cstddef>

#include "bench/subject.hpp"

namespace somas::bench {
namespace {

// Each value goes through a chain of four multiplications and additions; the chains of different
// values are independent. 8 KB, far inside any first-level cache.
void calibration(benchmark::State& state) {
  constexpr std::size_t count = 1024;
  constexpr double flops_per_value = 8;
  std::array<double, count> values{};
  double factor = 0.999, term = 0.001;  // to the limit 1
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(term);
  for (auto _ : state) {
    for (double& value : values) {
      double x = value;
      x = x * factor + term;
      x = x * factor + term;
      x = x * factor + term;
      x = x * factor + term;
      value = x;
    }
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
  }
  state.counters["flops"] = per_second(state, flops_per_value * count);
}
BENCHMARK(calibration)->MeasureProcessCPUTime();

}  // namespace
}  // namespace somas::bench
