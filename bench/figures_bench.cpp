// What looking costs: a life of the champion, the same life with a timelapse drawn of it, and with
// about 200 frames of a movie (drawn, not encoded).
#include <cstdint>
#include <string>

#include "bench/subject.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/report/movie.hpp"
#include "core/report/timelapse.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

constexpr std::uint64_t frames = 200;

std::uint64_t live(const evaluation::StepObserver& observe) {
  const evaluation::Task task = run::single_task(champion().individual.genome, champion().seed);
  return evaluation::simulate(*shipped().ecosystem, task, {}, observe)
      .value()
      .rows.at(0)
      .outcome.survival;
}

void life_unseen(benchmark::State& state) {
  measure(state, [&] {
    for (auto _ : state) benchmark::DoNotOptimize(live({}));
  });
}
BENCHMARK(life_unseen)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

// The argument is a PictureFormat.
void life_timelapse(benchmark::State& state) {
  measure(state, [&] {
    const auto format = static_cast<report::PictureFormat>(state.range(0));
    std::size_t bytes = 0;
    for (auto _ : state) {
      report::Timelapse timelapse({}, {.format = format});
      timelapse.expect(champion().life.outcome.survival);
      (void)live([&](const model::Simulation& world) { timelapse.observe(world); });
      bytes = timelapse.render({}).size();
    }
    state.counters["bytes"] = static_cast<double>(bytes);
  });
}
BENCHMARK(life_timelapse)
    ->ArgName("format")
    ->Arg(static_cast<int>(report::PictureFormat::svg))
    ->Arg(static_cast<int>(report::PictureFormat::png))
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

// Both lives that a movie takes.
void life_movie(benchmark::State& state) {
  measure(state, [&] {
    const report::MovieOptions options{
        .run = {}, .every = (champion().life.outcome.survival + frames) / frames};
    std::uint64_t drawn = 0;
    for (auto _ : state) {
      report::Screenplay play;
      (void)live([&](const model::Simulation& world) { play.observe(world, options); });
      play.settle(options);
      report::FramePainter painter(options, play);
      drawn = 0;
      (void)live([&](const model::Simulation& world) {
        if (play.shows(world.state().step - 1))
          benchmark::DoNotOptimize(painter.paint(world).data());
        drawn += play.shows(world.state().step - 1) ? 1 : 0;
      });
    }
    state.counters["frames"] = static_cast<double>(drawn);
    state.counters["time/frame"] = time_per(state, static_cast<double>(drawn));
  });
}
BENCHMARK(life_movie)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
