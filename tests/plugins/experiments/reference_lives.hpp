// Lives for comparisons of the engine with the reference: who lives, and where.
#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "tests/core/model/reference/compare.hpp"

namespace somas::test {

inline experiment::Experiment load_with_plugins(const std::filesystem::path& file) {
  return experiment::load(file,
                          {.overrides = {}, .plugin_directories = {SOMAS_BINARY_DIR "/plugins"}});
}

inline experiment::Experiment shipped(const std::string& name) {
  return load_with_plugins(std::string(SOMAS_SOURCE_DIR "/experiments/") + name);
}

/// The recorded champion of experiment 1.
inline run::Champion champion_of_experiment1() {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const evolution::Heredity heredity(*exp1.ecosystem);
  return run::parse_champion(run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"),
                             "champion", heredity);
}

/// Organisms that stand on a ring round the origin, in the order of their places in the roster.
class Cast {
 public:
  explicit Cast(const model::Ecosystem& ecosystem) : ecosystem_(ecosystem) {}

  void add(const model::Genome& genome) {
    phenotypes_.push_back(ecosystem_.express(genome));
    // Alone its key is 1, as in a run; later keys descend, unlike the places in the roster.
    const std::uint64_t key = roster_.empty() ? 1 : 1000 - 7 * roster_.size();
    roster_.push_back({&phenotypes_.back(), key, 0, 0});
  }
  [[nodiscard]] const std::vector<model::RosterEntry>& on_a_ring(double radius) {
    for (std::size_t r = 0; r < roster_.size(); ++r) {
      const double angle =
          2 * std::numbers::pi * static_cast<double>(r) / static_cast<double>(roster_.size());
      roster_[r].x = radius * std::cos(angle);
      roster_[r].y = radius * std::sin(angle);
    }
    return roster_;
  }

 private:
  const model::Ecosystem& ecosystem_;
  std::deque<model::Phenotype> phenotypes_;  // where they are: the roster points to them
  std::vector<model::RosterEntry> roster_;
};

/// How much a genome does in its first steps, alone: divides, specializes, lives.
inline double liveliness(const model::Ecosystem& ecosystem, const model::Genome& genome,
                         std::uint64_t seed, std::uint64_t steps) {
  const model::Phenotype phenotype = ecosystem.express(genome);
  const model::RosterEntry founder{&phenotype, 1, 0, 0};
  model::Simulation life(ecosystem, {&founder, 1}, seed);
  while (life.steps_done() < steps && life.step()) continue;
  const Outcome outcome = life.outcomes()[0];
  const auto divisions = static_cast<double>(outcome.divisions);
  const auto specializations = static_cast<double>(outcome.specializations);
  const double both = divisions > 0 && specializations > 0 ? 20 : 0;
  return both + std::min(divisions, 20.0) + std::min(specializations, 10.0) +
         0.02 * static_cast<double>(life.steps_done());
}

/// Of some random genomes, mutated up to eight times, the liveliest.
inline model::Genome liveliest(const model::Ecosystem& ecosystem, std::uint64_t seed,
                               std::uint64_t tries, std::uint64_t steps) {
  const evolution::Heredity heredity(ecosystem);
  model::Genome best;
  double most = -1;
  for (std::uint64_t number = 0; number < tries; ++number) {
    Rng rng(seed, 0, 0, stable_key("test"), number);
    model::Genome genome = heredity.random(rng);
    for (std::uint64_t m = number % 9; m > 0; --m) heredity.mutate(genome, rng);
    const double life = liveliness(ecosystem, genome, seed, steps);
    if (life <= most) continue;
    most = life;
    best = genome;
  }
  return best;
}

/// Replaces all cells by a heap of new ones, of all organisms and states, in the midst of actions;
/// some at the very same place, on edges or at centres of squares, far outside the world.
class Heap {
 public:
  Heap(model::Simulation& simulation, std::uint64_t seed)
      : world_(simulation.mutable_state()),
        config_(simulation.ecosystem().config()),
        rng_(seed, 0, world_.step, stable_key("heap"), 0) {
    model::CellStore& cells = world_.cells;
    const std::uint32_t rows = cells.memory.channels();
    cells.each_column([](auto& column) { column.clear(); });
    cells.ranges.clear();
    spread_ = rng_.uniform(0.5, 6);
    for (std::uint64_t count = 2 + rng_.below(70); count > 0; --count) fill(cells.append(rows));
    simulation.restructured();
  }

 private:
  void fill(std::uint32_t i) {
    model::CellStore& cells = world_.cells;
    const auto k = static_cast<std::uint16_t>(rng_.below(world_.organisms.size()));
    model::OrganismState& organism = world_.organisms[k];
    const std::vector<model::State>& states = organism.phenotype->tree->states;
    cells.organism[i] = k;
    cells.id[i] = organism.next_id++;
    cells.state[i] = static_cast<std::uint16_t>(rng_.below(states.size()));
    const model::State& state = states[cells.state[i]];
    place(i);
    const double speed = rng_.chance(0.1) ? 60 : 2;
    cells.vx[i] = rng_.uniform(-speed, speed), cells.vy[i] = rng_.uniform(-speed, speed);
    cells.radius[i] = state.radius * (rng_.chance(0.3) ? rng_.uniform(1, 1.4) : 1.0);
    cells.energy[i] = rng_.uniform(0, 1);
    cells.ambrosia[i] = rng_.uniform(0, state.skill(model::skill_capacity));
    cells.pressure[i] = rng_.uniform(0, 0.9);
    cells.stress_xx[i] = rng_.uniform(0, 3), cells.stress_yy[i] = rng_.uniform(0, 3);
    cells.stress_xy[i] = rng_.uniform(-1, 1);
    for (auto& column : cells.damage) column[i] = rng_.uniform(0, 0.5);
    for (auto& column : cells.values) column[i] = rng_.uniform(0, 1);
    for (std::uint32_t row = 0; row < cells.memory.channels(); ++row)
      cells.memory.row(row)[i] = static_cast<float>(rng_.uniform());
    act(i, state);
  }

  void act(std::uint32_t i, const model::State& state) {
    model::CellStore& cells = world_.cells;
    cells.action[i] = static_cast<model::Action>(rng_.below(5));
    if (cells.action[i] == model::Action::specialization) {
      if (state.children.empty())
        cells.action[i] = model::Action::quiescence;
      else
        cells.target[i] = state.children[rng_.below(state.children.size())];
    }
    if (cells.action[i] != model::Action::none)
      cells.remaining[i] = static_cast<std::uint32_t>(1 + rng_.below(4));
    if (cells.action[i] == model::Action::division)
      cells.remaining[i] = std::min(cells.remaining[i], config_.cycle.division_steps);
  }

  void place(std::uint32_t i) {
    model::CellStore& cells = world_.cells;
    cells.x[i] = spread_ * rng_.normal();
    cells.y[i] = spread_ * rng_.normal();
    const double side = config_.morphogens.side;
    const double low = -0.5 * side * config_.morphogens.size;
    const auto square = [&] {
      return static_cast<double>(rng_.below(config_.morphogens.size + 1));
    };
    switch (rng_.below(12)) {
      case 0:  // at another's place, or beside it
      case 1:
        if (i > 0) cells.x[i] = cells.x[i - 1] + (rng_.chance(0.3) ? 1e-11 : 0.0);
        if (i > 0 && rng_.chance(0.7)) cells.y[i] = cells.y[i - 1];
        return;
      case 2:  // a corner of a square
        cells.x[i] = low + square() * side, cells.y[i] = low + square() * side;
        return;
      case 3:  // a centre, perhaps just off the grid
        cells.x[i] = low + (square() + 0.5) * side, cells.y[i] = low + (square() - 0.5) * side;
        return;
      case 4:  // on the edge of the world
        cells.x[i] = config_.radius, cells.y[i] = 0;
        return;
      case 5:
        if (rng_.chance(0.3)) cells.x[i] = rng_.uniform(1, 1e6) * config_.radius;
        return;
      default:
        return;
    }
  }

  model::WorldState& world_;
  const model::Config& config_;
  Rng rng_;
  double spread_ = 1;
};

}  // namespace somas::test
