// The phases of a step, each by itself: most on a body of cells placed by rule, what depends on
// particles on colonies that live.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/rng.hpp"

#include "bench/colonies.hpp"
#include "bench/subject.hpp"
#include "core/model/hits.hpp"
#include "core/model/mechanics.hpp"
#include "core/model/metabolism.hpp"
#include "core/model/morphogens.hpp"
#include "core/model/neighbours.hpp"
#include "core/model/team.hpp"
#include "core/model/world_view.hpp"

namespace somas::bench {
namespace {

std::uint32_t cells_of(const benchmark::State& state) {
  return static_cast<std::uint32_t>(state.range(0));
}

/// From a small body to a million cells.
void of_a_body(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("cells")->MeasureProcessCPUTime();
  for (const std::int64_t cells : {100, 250, 1'000, 10'000, 100'000, 1'000'000})
    benchmark->Arg(cells);
}

// ---- morphogens --------------------------------------------------------------------------------

// One step of all grids of a world for so many cells, every square of them in use.
void morphogen_sweep(benchmark::State& state) {
  measure(state, [&] {
    const Body body(cells_of(state));
    const model::MorphogenGrid& grid = body.ecosystem().config().morphogens;
    model::MorphogenFields fields(grid);
    const std::uint32_t last = grid.size - 1;
    for (std::size_t kind = 0; kind < fields.kinds(); ++kind) {
      fields.set(kind, 0, 0, 1);
      fields.set(kind, last, last, 1);
    }
    for (auto _ : state) {
      for (std::size_t kind = 0; kind < fields.kinds(); ++kind)
        fields.set(kind, last / 2, last / 2, 1);
      fields.evaporate_and_spread(grid);
      benchmark::ClobberMemory();
    }
    const double squares = static_cast<double>(fields.kinds()) * grid.size * grid.size;
    state.counters["time/square"] = time_per(state, squares);
    state.counters["time/cell"] = time_per(state, cells_of(state));
  });
}
BENCHMARK(morphogen_sweep)->Apply(of_a_body);

// Sensing and depositing of every cell, all kinds.
void morphogen_cells(benchmark::State& state) {
  measure(state, [&] {
    Body body(cells_of(state));
    const model::CellStore& cells = body.state().cells;
    model::MorphogenFields& fields = body.state().organisms.front().fields;
    model::FloatMatrix sensed;
    sensed.reshape(static_cast<std::uint32_t>(fields.kinds()), cells.size());
    std::vector<model::Footprint> prints(cells.size());
    const std::vector<float> amounts(cells.size(), 0.5f);
    for (auto _ : state) {
      fields.survey(cells.x, cells.y, prints, sensed.lanes(0, cells.size(), sensed.channels()));
      for (std::size_t kind = 0; kind < fields.kinds(); ++kind)
        fields.deposit(kind, prints, amounts, model::Deposit::peak);
      benchmark::ClobberMemory();
    }
    state.counters["time/cell"] = time_per(state, cells.size());
  });
}
BENCHMARK(morphogen_cells)->Apply(of_a_body);

// ---- mechanics ---------------------------------------------------------------------------------

void neighbour_build(benchmark::State& state) {
  measure(state, [&] {
    Body body(cells_of(state));
    const model::CellStore& cells = body.state().cells;
    const std::vector<model::Body> bodies = bodies_of(cells);
    model::NeighbourPairs pairs;
    for (auto _ : state) {
      pairs.build(bodies, 1.2, 0.25);
      benchmark::ClobberMemory();
    }
    state.counters["time/cell"] = time_per(state, cells.size());
  });
}
BENCHMARK(neighbour_build)->Apply(of_a_body);

// One step: all substeps, then contacts, pressure and stress. The body starts from the same places
// every time, so that the neighbour lists of the first iteration serve all others.
void mechanics(benchmark::State& state) {
  measure(state, [&] {
    Body body(cells_of(state));
    model::CellStore& cells = body.state().cells;
    const model::CellStore start = cells;
    const model::Mechanics& constants = body.ecosystem().config().mechanics;
    model::MechanicsSolver solver;
    solver.run(constants, body.state(), {});
    for (auto _ : state) {
      cells.x = start.x;
      cells.y = start.y;
      cells.vx = start.vx;
      cells.vy = start.vy;
      solver.run(constants, body.state(), {});
      solver.list_contacts(body.state().contacts);
      benchmark::ClobberMemory();
    }
    state.counters["time/cell"] = time_per(state, cells.size());
    state.counters["contacts/cell"] =
        static_cast<double>(body.state().contacts.items.size()) / cells.size();
  });
}
BENCHMARK(mechanics)->Apply(of_a_body);

// ---- metabolism --------------------------------------------------------------------------------

// Uptake, conversion, diffusion and cost with random shares; the same reserves and full nutrients
// at every start, whose renewal is timed too (the patches below cells and two columns).
void metabolism(benchmark::State& state) {
  measure(state, [&] {
    Body body(cells_of(state));
    model::WorldState& world = body.state();
    const model::WorldState start = world;
    const model::FloatMatrix shares =
        noise(static_cast<std::uint32_t>(body.phenotype().ports->layout().outputs.size()),
              world.cells.size());
    model::MetabolismSolver solver;
    std::vector<double>& content = world.grids.front();
    const Grid grid{content, body.ecosystem().schema().grids.front().spec};
    std::vector<std::size_t> patches;
    for (std::uint32_t i = 0; i < world.cells.size(); ++i)
      patches.push_back(
          static_cast<std::size_t>(grid.index_of(world.cells.x[i], world.cells.y[i])));
    std::sort(patches.begin(), patches.end());
    patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
    for (auto _ : state) {
      for (const std::size_t patch : patches) content[patch] = start.grids.front()[patch];
      world.cells.energy = start.cells.energy;
      world.cells.ambrosia = start.cells.ambrosia;
      solver.run(body.ecosystem(), world, shares);
      benchmark::ClobberMemory();
    }
    state.counters["time/cell"] = time_per(state, world.cells.size());
  });
}
BENCHMARK(metabolism)->Apply(of_a_body);

// ---- control -----------------------------------------------------------------------------------

// One step of the champion's network in one batch, through the plugin. The rate counts a
// multiplication and an addition for each regulator of each target.
void controller_step(benchmark::State& state) {
  measure(state, [&] {
    const model::Phenotype phenotype = shipped().ecosystem->express(champion().individual.genome);
    const Layout& layout = phenotype.ports->layout();
    const auto outputs = static_cast<std::uint32_t>(layout.outputs.size());
    const std::uint32_t targets = phenotype.program->memory_per_cell();
    const std::uint32_t cells = cells_of(state);

    const model::FloatMatrix in = noise(layout.input_channels, cells);
    model::FloatMatrix memory = noise(targets, cells);
    model::FloatMatrix out = noise(outputs, cells);
    const Batch batch{.count = cells,
                      .in = in.lanes(0, cells, layout.input_channels),
                      .memory = memory.lanes(0, cells, targets),
                      .out = out.lanes(0, cells, outputs)};
    for (auto _ : state) {
      phenotype.program->step(batch);
      benchmark::ClobberMemory();
    }
    const double regulators = targets - outputs;
    state.counters["time/cell"] = time_per(state, cells);
    state.counters["regulators"] = regulators;
    state.counters["flops"] =
        per_second(state, 2.0 * cells * targets * (layout.input_channels + regulators));
  });
}
BENCHMARK(controller_step)->Apply(of_a_body);

// A network of 52 proteins, 20 of them regulators, with all 21 inputs active: the size at which
// grgen is measured. One step of it in one batch, through the plugin.
void controller_step_52_proteins(benchmark::State& state) {
  measure(state, [&] {
    constexpr std::uint32_t inputs = 21, outputs = 11, regulators = 20;
    const experiment::Experiment experiment =
        experiment_1({"controller.initial_regulators=" + std::to_string(regulators)});
    const std::vector<StateInfo> states{{"all", 1, no_state}};
    std::vector<Port> in, out;
    for (std::uint32_t c = 0; c < inputs; ++c) in.push_back({"in", 100 + c, c, 0});
    for (std::uint32_t c = 0; c < outputs; ++c) out.push_back({"out", 200 + c, c, no_state});
    const Layout layout{states, in, out, inputs};
    Genes genes;
    Rng rng(1, 0, 0, stable_key("bench.network"), 0);
    const Controller& controller = experiment.ecosystem->controller();
    controller.heritable().random(layout, rng, genes);
    const std::unique_ptr<Program> program = controller.express(genes, layout);

    const std::uint32_t targets = program->memory_per_cell(), cells = cells_of(state);
    const model::FloatMatrix given = noise(inputs, cells);
    model::FloatMatrix memory = noise(targets, cells), results = noise(outputs, cells);
    const Batch batch{.count = cells,
                      .in = given.lanes(0, cells, inputs),
                      .memory = memory.lanes(0, cells, targets),
                      .out = results.lanes(0, cells, outputs)};
    for (auto _ : state) {
      program->step(batch);
      benchmark::ClobberMemory();
    }
    state.counters["time/step"] = time_per(state, cells);
    state.counters["steps"] = per_second(state, cells);
    state.counters["flops"] =
        per_second(state, 2.0 * cells * targets * (inputs + targets - outputs));
  });
}
BENCHMARK(controller_step_52_proteins)
    ->ArgName("cells")
    ->Arg(64)
    ->Arg(1000)
    ->MeasureProcessCPUTime();

// ---- aggression --------------------------------------------------------------------------------

model::DiscBins bins_of(const model::CellStore& cells) {
  std::vector<model::Disc> discs;
  for (const std::uint32_t i : cells.order)
    discs.push_back({cells.x[i], cells.y[i], cells.radius[i], 0.1});
  model::DiscBins bins;
  bins.sort(discs, 1.2);
  return bins;
}

// The first cell met by each of many short paths across the body and round it, ten for each cell.
// The bins stand already: mechanics has made them.
void first_hits(benchmark::State& state) {
  measure(state, [&] {
    Body body(cells_of(state));
    const model::CellStore& cells = body.state().cells;
    Rng rng(1, 0, 0, stable_key("bench.paths"), 0);
    std::vector<Segment> paths(10 * std::size_t{cells.size()});
    const double reach = 30 * std::sqrt(cells.size() / 250.0);  // twice the body's radius
    for (Segment& path : paths) {
      const double x = rng.uniform(-reach, reach), y = rng.uniform(-reach, reach);
      path = {x, y, x + rng.uniform(-0.5, 0.5), y + rng.uniform(-0.5, 0.5)};
    }
    std::vector<std::int32_t> hits(paths.size());
    const model::DiscBins bins = bins_of(cells);
    const std::vector<model::Body> bodies = bodies_of(cells);
    model::HitFinder finder;
    for (auto _ : state) {
      finder.prepare(bodies, bins, cells.order, cells.rank);
      finder.expect(paths.size());
      finder.first(paths, hits);
      benchmark::DoNotOptimize(hits.data());
      benchmark::ClobberMemory();
    }
    state.counters["time/path"] = time_per(state, static_cast<double>(paths.size()));
    state.counters["time/cell"] = time_per(state, cells.size());
  });
}
BENCHMARK(first_hits)->Apply(of_a_body);

/// The whole phase of a step, through the plugin, round colonies that live: particles are launched,
/// fly, meet cells. Steps are shared with `team`, unless it is null.
void fly(benchmark::State& state, model::Team* team) {
  constexpr int steps_of_a_stretch = 32;
  Colonies& world = colonies_of(cells_of(state));
  model::WorldState& here = world.simulation().mutable_state();
  model::FloatMatrix no_inputs;
  // Where they stand, without a step of time.
  model::MechanicsSolver mechanics;
  mechanics.run({.substeps = 1, .time_step = 0}, here, {});
  model::WorldView view(*world.experiment().ecosystem, here, no_inputs, mechanics);
  view.use(team);
  int steps = 0;
  double rows = 0;
  for (auto _ : state) {
    if (steps++ == steps_of_a_stretch) {
      state.PauseTiming();
      world.rewind();
      steps = 1;
      state.ResumeTiming();
    }
    view.act(Phase::stress);
    rows += here.tables.front().rows();
    ++here.step;
  }
  const double per_step = rows / static_cast<double>(state.iterations());
  state.counters["time/particle"] = time_per(state, per_step);
  state.counters["time/cell"] = time_per(state, here.cells.size());
  state.counters["particles/cell"] = per_step / here.cells.size();
}

void particles(benchmark::State& state) {
  measure(state, [&] { fly(state, nullptr); });
}
BENCHMARK(particles)->Apply(of_a_body);

// The same with threads that share the world; by the clock.
void particles_shared(benchmark::State& state) {
  measure(state, [&] {
    model::Team team(static_cast<unsigned>(state.range(1)));
    fly(state, &team);
  });
}
BENCHMARK(particles_shared)
    ->ArgNames({"cells", "threads"})
    ->ArgsProduct({{1'000, 5'000, 50'000}, {1, 2}})
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace somas::bench
