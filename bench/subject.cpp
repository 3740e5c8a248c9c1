#include "bench/subject.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <utility>

#include "somas/sdk/rng.hpp"

#include "bench/colonies.hpp"
#include "core/evolution/heredity.hpp"
#include "core/model/mechanics.hpp"
#include "core/run/files.hpp"

namespace somas::bench {
namespace {

const std::filesystem::path source_dir = SOMAS_SOURCE_DIR;

struct Point {
  double x = 0, y = 0;
};

// The `count` points nearest to the origin of a hexagonal lattice, each moved a little.
std::vector<Point> jittered_disc(std::uint32_t count, double spacing) {
  const int reach = 2 + static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<Point> points;
  for (int row = -reach; row <= reach; ++row)
    for (int column = -reach; column <= reach; ++column)
      points.push_back(
          {spacing * (column + (row % 2 != 0 ? 0.5 : 0.0)), spacing * row * std::sqrt(0.75)});
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y;
  });
  points.resize(count);

  Rng rng(1, 0, 0, stable_key("bench.jitter"), 0);
  for (Point& point : points) {
    point.x += rng.uniform(-0.1, 0.1);
    point.y += rng.uniform(-0.1, 0.1);
  }
  return points;
}

}  // namespace

experiment::Experiment experiment_1(const std::vector<std::string>& overrides) {
  return experiment::load(source_dir / "experiments/exp1.yaml",
                          {.overrides = overrides, .plugin_directories = {}});
}

const experiment::Experiment& shipped() {
  static const experiment::Experiment experiment = experiment_1();
  return experiment;
}

const run::Champion& champion() {
  static const run::Champion champion = [] {
    const std::filesystem::path file = source_dir / "bench/data/champion_exp1.json";
    const evolution::Heredity heredity(*shipped().ecosystem);
    return run::parse_champion(run::read_file(file), file.filename().string(), heredity);
  }();
  return champion;
}

Body::Body(std::uint32_t cells)
    : experiment_(cells <= 250 ? experiment_1() : experiment_1(scaled_world(cells))),
      phenotype_(ecosystem().express(champion().individual.genome)) {
  const model::RosterEntry founder{.phenotype = &phenotype_, .key = 1};
  simulation_ = std::make_unique<model::Simulation>(ecosystem(), std::span(&founder, 1), 1);

  model::CellStore& store = state().cells;
  model::OrganismState& organism = state().organisms.front();
  const std::vector<model::State>& states = phenotype_.tree->states;
  const std::vector<Point> points = jittered_disc(cells, model::rest_distance(states.front()));
  for (std::uint32_t i = 0; i < cells; ++i) {
    if (i > 0) {
      store.append(phenotype_.program->memory_per_cell());
      store.copy_cell(0, i);
      store.id[i] = organism.next_id++;
    }
    store.x[i] = points[i].x;
    store.y[i] = points[i].y;
    store.action[i] = model::Action::quiescence;
    store.remaining[i] = 5;
  }
  // The founder is the model of all, so that its state changes last.
  for (std::uint32_t i = cells / 2; i < cells; ++i) {
    store.state[i] = static_cast<std::uint16_t>(states.size() - 1);
    store.radius[i] = states.back().radius;
    store.ambrosia[i] = std::min(store.ambrosia[i], states.back().skill(model::skill_capacity));
  }
  simulation_->restructured();
  model::MechanicsSolver mechanics;
  mechanics.run(ecosystem().config().mechanics, state(), {});
  mechanics.list_contacts(state().contacts);
}

std::vector<model::Body> bodies_of(const model::CellStore& cells) {
  std::vector<model::Body> bodies;
  for (const std::uint32_t i : cells.order)
    bodies.push_back({cells.x[i], cells.y[i], cells.vx[i], cells.vy[i], cells.radius[i], 1, 0});
  return bodies;
}

model::FloatMatrix noise(std::uint32_t channels, std::uint32_t lanes) {
  model::FloatMatrix values;
  values.reshape(channels, lanes);
  Rng rng(1, 0, 0, stable_key("bench.noise"), 0);
  for (std::uint32_t c = 0; c < channels; ++c)
    for (std::uint32_t l = 0; l < lanes; ++l) values.row(c)[l] = static_cast<float>(rng.uniform());
  return values;
}

}  // namespace somas::bench
