// What this core gives this process just now, to tell a slow machine from slow code.
#include <array>
#include <cstddef>

#include "bench/subject.hpp"
#include "bench/unknown.hpp"

namespace somas::bench {
namespace {

// Each value goes through a chain of four multiplications and additions; the chains of different
// values are independent. 8 KB, far inside any first-level cache.
void calibration(benchmark::State& state) {
  constexpr std::size_t count = 1024;
  constexpr double flops_per_value = 8;
  std::array<double, count> values{};
  const double factor = unknown(0.999), term = unknown(0.001);  // to the limit 1
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
  if (!(values.front() > 0 && values.front() <= 1))
    state.SkipWithError("the values are not on their way to 1");
  state.counters["flops"] = per_second(state, flops_per_value * count);
}
BENCHMARK(calibration)->MeasureProcessCPUTime();

}  // namespace
}  // namespace somas::bench
