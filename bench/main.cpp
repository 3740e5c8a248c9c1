// The benchmarks' program: Google Benchmark's own, less what does not work with it, and the
// roofline.
#include <cstdio>
#include <exception>
#include <span>
#include <string_view>

#include <benchmark/benchmark.h>

#include "bench/roofline.hpp"

namespace {

/// CSV rows must all have the same counters; the benchmarks' differ, which Google Benchmark answers
/// with an abort in mid-run.
bool asks_for_csv(std::span<char* const> arguments) {
  for (const std::string_view argument : arguments)
    if (argument == "--benchmark_format=csv" || argument == "--benchmark_out_format=csv")
      return true;
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  const std::span<char* const> arguments{argv + 1, argv + argc};
  if (!arguments.empty() && std::string_view(arguments.front()) == "--roofline") {
    try {
      return somas::bench::roofline(arguments.subspan(1));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "roofline: %s\n", error.what());
      return 1;
    }
  }
  if (asks_for_csv(arguments)) {
    std::fputs(
        "bench: there is no CSV, since benchmarks have different counters; use JSON "
        "(--benchmark_out=FILE)\n",
        stderr);
    return 2;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
