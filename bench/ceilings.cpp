#include "bench/ceilings.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/unknown.hpp"

namespace somas::bench {
namespace {

using Doubles = double __attribute__((vector_size(32)));
using Floats = float __attribute__((vector_size(32)));

template <class Vector>
constexpr std::size_t lanes = sizeof(Vector) / sizeof(Vector{}[0]);

/// Runs of about two milliseconds, as many as there is time for; the best rate of `items` a call.
template <class Call>
double best_rate(double seconds, double items, Call&& call) {
  using Clock = std::chrono::steady_clock;
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const Clock::time_point start = Clock::now();
  call();
  const auto calls = static_cast<int>(1 + 0.002 / std::max(since(start), 1e-7));
  double best = 0;
  do {
    const Clock::time_point begin = Clock::now();
    for (int c = 0; c < calls; ++c) call();
    best = std::max(best, calls * items / since(begin));
  } while (since(start) < seconds);
  return best;
}

/// Independent chains in registers, enough to hide the latency of an operation.
template <class Vector, std::size_t Chains, class Operation>
double rate_of_chains(double seconds, double per_value, Operation&& operation) {
  constexpr std::size_t turns = 512;
  Vector chain[Chains];
  for (std::size_t c = 0; c < Chains; ++c) chain[c] = Vector{} + static_cast<float>(c + 2);
  return best_rate(seconds, per_value * turns * Chains * lanes<Vector>, [&] {
    Vector own[Chains];
    std::copy_n(chain, Chains, own);
    for (std::size_t turn = 0; turn < turns; ++turn)
#pragma GCC unroll 16
      for (std::size_t c = 0; c < Chains; ++c) operation(own[c]);
    std::copy_n(own, Chains, chain);
    benchmark::DoNotOptimize(chain);
  });
}

template <class Vector>
double flops(double seconds) {
  Vector factor = Vector{} + 0.999f, term = Vector{} + 0.001f;
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(term);
  return rate_of_chains<Vector, 12>(seconds, 2, [=](Vector& x) { x = x * factor + term; });
}

template <class Vector>
double divisions(double seconds) {
  Vector dividend = Vector{} + 1.7f;
  benchmark::DoNotOptimize(dividend);
  return rate_of_chains<Vector, 12>(seconds, 1, [=](Vector& x) { x = dividend / x; });
}

/// Of values in an array that stays in the first cache.
template <class Value>
double roots(double seconds) {
  constexpr std::size_t count = 512;
  alignas(64) std::array<Value, count> values{};
  const Value term = unknown(Value{0.7f});
  return best_rate(seconds, count, [&] {
    for (Value& value : values) value = std::sqrt(value + term);
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
  });
}

/// Bytes a second, reading two arrays and writing a third; all three together have `bytes`.
double triad(double seconds, std::size_t bytes) {
  const std::size_t count = bytes / (3 * sizeof(double));
  std::vector<double> a(count, 0.0), b(count, 1.0), c(count, 2.0);
  const double factor = unknown(3.0);
  const double rate = best_rate(seconds, 3.0 * sizeof(double) * static_cast<double>(count), [&] {
    double* __restrict to = a.data();
    const double *from = b.data(), *scaled = c.data();
    for (std::size_t i = 0; i < count; ++i) to[i] = from[i] + factor * scaled[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  });
  if (a.back() != 1 + 3.0 * 2) throw std::logic_error("the triad's sums are wrong");
  return rate;
}

}  // namespace

Ceilings measure_ceilings(double seconds) {
  constexpr std::size_t kilo = 1024, mega = 1024 * kilo;
  const double each = seconds / 10;
  return {.flops64 = flops<Doubles>(each),
          .flops32 = flops<Floats>(each),
          .divisions64 = divisions<Doubles>(each),
          .divisions32 = divisions<Floats>(each),
          .roots64 = roots<double>(each),
          .roots32 = roots<float>(each),
          .l1 = triad(each, 24 * kilo),
          .l2 = triad(each, 384 * kilo),
          .l3 = triad(each, 8 * mega),
          .dram = triad(each, 192 * mega)};
}

}  // namespace somas::bench
