// The whole step at sizes from a small body to a million cells: what a cell-step costs, and that
// the cost does not grow with the world.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "bench/colonies.hpp"
#include "bench/subject.hpp"
#include "core/model/profile.hpp"
#include "core/model/team.hpp"

namespace somas::bench {
namespace {

/// So many steps from the start the world is still what it was copied from: particles that were in
/// flight still arrive.
constexpr int steps_of_a_stretch = 32;

/// What happened in the steps that were measured.
struct Tally {
  double cell_steps = 0, born = 0, died = 0, specialized = 0, particles = 0, contacts = 0;
  std::uint32_t cells = 0;

  /// A stretch is over.
  void add(const model::WorldState& start, const model::WorldState& end) {
    const model::OrganismState &was = start.organisms.front(), &is = end.organisms.front();
    cell_steps += is.outcome.cell_steps - was.outcome.cell_steps;
    born += static_cast<double>(is.outcome.divisions - was.outcome.divisions);
    specialized += static_cast<double>(is.outcome.specializations - was.outcome.specializations);
    for (std::size_t cause = 0; cause < is.deaths.size(); ++cause)
      died += static_cast<double>(is.deaths[cause] - was.deaths[cause]);
    cells = end.cells.size();
    particles = end.tables.front().rows();
    contacts = static_cast<double>(end.contacts.items.size());
  }
};

void whole_step(benchmark::State& state) {
  measure(state, [&] {
    Colonies& world = colonies_of(static_cast<std::uint32_t>(state.range(0)));
    model::Simulation& simulation = world.simulation();
    Tally tally;
    int steps = 0;
    for (auto _ : state) {
      if (steps == steps_of_a_stretch) {
        state.PauseTiming();
        tally.add(world.start(), simulation.state());
        world.rewind();
        steps = 0;
        state.ResumeTiming();
      }
      simulation.step();
      ++steps;
    }
    const auto bytes = static_cast<double>(state_bytes(simulation.state()));
    tally.add(world.start(), simulation.state());
    const benchmark::Counter::Flags invert{benchmark::Counter::kIsRate |
                                           benchmark::Counter::kInvert};
    state.counters["time/cell_step"] = {tally.cell_steps, invert};
    state.counters["cells"] = tally.cells;
    state.counters["births/step/cell"] = tally.born / tally.cell_steps;
    state.counters["deaths/step/cell"] = tally.died / tally.cell_steps;
    state.counters["specialized/step/cell"] = tally.specialized / tally.cell_steps;
    state.counters["particles/cell"] = tally.particles / tally.cells;
    state.counters["contacts/cell"] = tally.contacts / tally.cells;
    state.counters["bytes/cell"] = bytes / tally.cells;
    state.counters["heap/cell"] = static_cast<double>(world.heap_bytes()) / tally.cells;
  });
}
BENCHMARK(whole_step)
    ->ArgName("cells")
    ->Arg(100)
    ->Arg(300)
    ->Arg(1'000)
    ->Arg(10'000)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(whole_step)
    ->ArgName("cells")
    ->Arg(100'000)
    ->Iterations(steps_of_a_stretch)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(whole_step)
    ->ArgName("cells")
    ->Arg(1'000'000)
    ->Iterations(steps_of_a_stretch / 4)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

/// The least time that each phase of each step of a stretch took, by the clock, of several times
/// that the stretch was done: what others do to the machine meanwhile counts little.
class LeastTimes {
 public:
  LeastTimes() : least_(steps * model::step_phases, model::Profile::Duration::max()) {}

  /// Does the stretch once more.
  void measure(Colonies& world, model::Team* team) {
    model::Simulation& simulation = world.simulation();
    simulation.use(team);
    cell_steps_ = 0;
    for (std::size_t step = 0; step < steps; ++step) {
      model::Profile profile;
      simulation.measure(&profile);
      simulation.step();
      cell_steps_ += simulation.state().cells.size();
      for (std::size_t p = 0; p < model::step_phases; ++p) {
        model::Profile::Duration& least = least_[step * model::step_phases + p];
        least = std::min(least, profile.phase(static_cast<model::StepPhase>(p)));
      }
    }
    simulation.measure(nullptr);
    simulation.use(nullptr);
  }
  /// Of a phase, for each cell-step, in ns.
  [[nodiscard]] double of(std::size_t phase) const {
    double sum = 0;
    for (std::size_t step = 0; step < steps; ++step)
      sum += static_cast<double>(least_[step * model::step_phases + phase].count());
    return sum / cell_steps_;
  }
  [[nodiscard]] double of_all() const {
    double sum = 0;
    for (std::size_t p = 0; p < model::step_phases; ++p) sum += of(p);
    return sum;
  }

 private:
  static constexpr std::size_t steps = 8;

  std::vector<model::Profile::Duration> least_;
  double cell_steps_ = 0;
};

/// How long, in ns, two threads take to hand a line of the cache over and back: much longer where
/// their processors have no cache in common than where they have one. 0 where there is but one.
double round_trip() {
  if (std::thread::hardware_concurrency() < 2) return 0;
  constexpr int trips = 5'000;
  alignas(64) std::atomic<int> line = 0;
  const auto pass_on = [&](int first) {
    for (int trip = first; trip < 2 * trips; trip += 2) {
      while (line.load(std::memory_order_acquire) != trip) continue;
      line.store(trip + 1, std::memory_order_release);
    }
  };
  std::thread other(pass_on, 1);
  const auto start = std::chrono::steady_clock::now();
  pass_on(0);
  other.join();
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
  return time.count() / trips;
}

// A few steps by one thread, then by several that share the world, and so on in turn.
void whole_step_shared(benchmark::State& state) {
  measure(state, [&] {
    Colonies& world = colonies_of(static_cast<std::uint32_t>(state.range(0)));
    model::Team team(static_cast<unsigned>(state.range(1)));
    LeastTimes alone, shared;
    std::vector<double> trips;
    for (auto _ : state) {
      alone.measure(world, nullptr);
      world.rewind();
      shared.measure(world, &team);
      world.rewind();
      trips.push_back(round_trip());
    }
    std::ranges::nth_element(trips, trips.begin() + trips.size() / 2);
    state.counters["ns:round_trip"] = trips[trips.size() / 2];
    state.counters["ns:one_thread"] = alone.of_all();
    state.counters["ns:shared"] = shared.of_all();
    state.counters["speedup"] = alone.of_all() / shared.of_all();
    for (std::size_t p = 0; p < model::step_phases; ++p) {
      const std::string name(model::name_of(static_cast<model::StepPhase>(p)));
      state.counters["one:" + name] = alone.of(p);
      state.counters["ns:" + name] = shared.of(p);
    }
  });
}
BENCHMARK(whole_step_shared)
    ->ArgNames({"cells", "threads"})
    ->ArgsProduct({{1'000, 5'000, 20'000, 50'000, 100'000}, {2}})
    ->Iterations(10)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace somas::bench
