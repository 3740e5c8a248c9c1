// Phases 4 and 6 (docs/model.md, section 4).
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "somas/sdk/rng.hpp"

#include "tests/core/model/reference/phases.hpp"

namespace somas::reference {

namespace {

/// Something that a cell may do, and how strongly its controller wants it.
struct Candidate {
  Action action;
  std::uint16_t target;
  float output, threshold;
};

std::vector<Candidate> candidates_of(const World& world, const Cell& cell) {
  const model::State& state = world.state_of(cell);
  const model::Thresholds& least = state.thresholds;
  const model::OutputChannels& out = world.outputs_of(cell);
  std::vector<Candidate> candidates{
      {Action::quiescence, no_state, cell.outputs[out.quiescence], least.quiescence},
      {Action::division, no_state, cell.outputs[out.division], least.division}};
  for (const std::uint16_t child : state.children)
    candidates.push_back(
        {Action::specialization, child, cell.outputs[out.specialize[child]], least.specialization});
  candidates.push_back({Action::apoptosis, no_state, cell.outputs[out.apoptosis], least.apoptosis});
  return candidates;
}

/// The strongest that reaches its threshold; of equals the first; quiescence if there is none.
Candidate choice_of(const World& world, const Cell& cell) {
  Candidate best{Action::quiescence, no_state, -std::numeric_limits<float>::infinity(), 0};
  for (const Candidate& candidate : candidates_of(world, cell)) {
    if (std::isnan(candidate.output)) continue;
    if (std::clamp(candidate.output, 0.0f, 1.0f) < candidate.threshold) continue;
    if (candidate.output > best.output) best = candidate;
  }
  return best;
}

std::uint32_t duration_of(const model::Cycle& cycle, Action action) {
  if (action == Action::division) return cycle.division_steps;
  if (action == Action::specialization) return cycle.specialization_steps;
  if (action == Action::apoptosis) return cycle.apoptosis_steps;
  return cycle.quiescence_steps;
}

/// All that the dying hold goes to their contacts.
void release(World& world, const std::vector<Name>& dying) {
  std::map<Name, double> received;
  for (const Name& name : dying) world.find(name).kill(model::cause_apoptosis);
  for (const Name& name : dying) {
    const Cell& cell = world.find(name);
    if (cell.contacts.empty()) continue;
    Ledger& ledger = world.organism_of(cell).ledger;
    const double efficiency = world.state_of(cell).skill(model::skill_diffusion);
    const double part = cell.ambrosia / static_cast<double>(cell.contacts.size());
    const double arrives = efficiency * part;
    ledger.lost_efficiency.add(cell.ambrosia * (1.0 - efficiency));
    for (const Name& receiver : cell.contacts) {
      received[receiver] += arrives;
      if (arrives > 0) ++world.events.legacies;
      if (receiver.organism == name.organism) continue;
      ledger.given.add(arrives);
      world.organisms[receiver.organism].ledger.received.add(arrives);
    }
  }
  for (const Name& name : dying) {
    Cell& cell = world.find(name);
    if (!cell.contacts.empty()) cell.ambrosia = 0;
  }
  for (const auto& [name, amount] : received) {
    Cell& cell = world.find(name);
    const double total = cell.ambrosia + amount;
    const double excess = std::max(0.0, total - world.state_of(cell).skill(model::skill_capacity));
    cell.ambrosia = total - excess;
    world.organism_of(cell).ledger.lost_overflow.add(excess);
  }
}

void specialize(World& world, Cell& cell) {
  Organism& organism = world.organism_of(cell);
  cell.state = cell.target;
  const model::State& state = world.state_of(cell);
  cell.radius = state.radius;
  const double excess = std::max(0.0, cell.ambrosia - state.skill(model::skill_capacity));
  cell.ambrosia -= excess;
  organism.ledger.lost_overflow.add(excess);
  ++organism.outcome.specializations;
  ++world.events.specializations;
  for (std::size_t h = 0; h < world.schema().hazards.size(); ++h) {
    const model::Hazard& hazard = world.schema().hazards[h];
    if (cell.damage[h] > state.skill(hazard.resistance_skill)) cell.kill(hazard.cause);
  }
}

struct Direction {
  double x, y;
};

/// At right angles to the axis on which the cell is squeezed most; any, if there is none.
Direction division_axis(World& world, const Cell& mother) {
  // The stress tensor's eigenvalues are mean +- root.
  const double half = 0.5 * (mother.stress_xx - mother.stress_yy);
  const double root = std::sqrt(half * half + mother.stress_xy * mother.stress_xy);
  if (2.0 * root <= 1e-9) {
    Rng rng(world.seed, world.organism_of(mother).key, world.step, stable_key("core.division_axis"),
            mother.name.id);
    const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
    ++world.events.random_axes;
    return {angle.cos, angle.sin};
  }
  // Eigenvector of the greater one, in the form that does not cancel.
  const Direction squeezed = half >= 0 ? Direction{half + root, mother.stress_xy}
                                       : Direction{mother.stress_xy, root - half};
  const double length = std::sqrt(squeezed.x * squeezed.x + squeezed.y * squeezed.y);
  return {-squeezed.y / length, squeezed.x / length};
}

/// How far apart two resting cells of a state lie.
double rest_distance(const model::State& state) {
  const double springs = state.stiffness + state.adhesion;
  if (springs == 0) return 2.0 * state.radius;
  return (state.stiffness * 2.0 * state.radius + state.adhesion * state.radius) / springs;
}

/// Returns the daughter.
Cell divide(World& world, Cell& mother) {
  Organism& organism = world.organism_of(mother);
  const model::State& state = world.state_of(mother);
  const std::vector<model::CellValue>& values = world.schema().cell_values;
  const Direction axis = division_axis(world, mother);

  mother.radius = state.radius;
  mother.energy *= 0.5;
  mother.ambrosia *= 0.5;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (values[v].rule == OnDivision::halve) mother.values[v] *= 0.5;
  Cell daughter = mother;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (values[v].rule == OnDivision::zero) daughter.values[v] = 0;

  const double half = 0.5 * rest_distance(state);
  mother.x += half * axis.x;
  mother.y += half * axis.y;
  daughter.x -= half * axis.x;
  daughter.y -= half * axis.y;
  daughter.name.id = organism.next_id++;
  daughter.parent = mother.name.id;
  daughter.born = world.step;
  daughter.contacts.clear();
  ++organism.outcome.divisions;
  ++organism.live;
  ++world.events.births;
  return daughter;
}

}  // namespace

void decide(World& world) {
  const model::Cycle& cycle = world.config().cycle;
  std::vector<std::uint32_t> dividing(world.organisms.size(), 0);
  for (const Cell& cell : world.cells)
    if (cell.action == Action::division) ++dividing[cell.name.organism];

  for (Cell& cell : world.cells) {
    if (cell.action != Action::none) continue;
    Organism& organism = world.organism_of(cell);
    Candidate choice = choice_of(world, cell);
    if (choice.action == Action::division) {
      const bool able =
          cell.energy >= cycle.division_energy && cell.pressure <= cycle.division_pressure;
      const bool room = organism.live + dividing[cell.name.organism] < world.config().max_cells;
      if (able && !room) {
        ++organism.outcome.refused_divisions;
        ++world.events.refused_divisions;
      }
      if (able && room)
        ++dividing[cell.name.organism];
      else
        choice = {Action::quiescence, no_state, 0, 0};
    }
    cell.action = choice.action;
    cell.target = choice.target;
    cell.remaining = duration_of(cycle, choice.action);
  }
}

std::vector<Cell> advance(World& world) {
  const double division_steps = world.config().cycle.division_steps;
  std::map<Action, std::vector<Name>> ended;
  for (Cell& cell : world.cells) {
    if (cell.dead) continue;
    --cell.remaining;
    if (cell.action == Action::division)
      cell.radius = world.state_of(cell).radius *
                    std::sqrt(1.0 + (division_steps - cell.remaining) / division_steps);
    if (cell.remaining > 0) continue;
    ended[cell.action].push_back(cell.name);
    cell.action = Action::none;
  }

  std::vector<Cell> newborn;
  const auto divide_all = [&] {
    for (const Name& name : ended[Action::division])
      newborn.push_back(divide(world, world.find(name)));
  };
  if (world.mistake == Mistake::divisions_first) divide_all();
  release(world, ended[Action::apoptosis]);
  for (const Name& name : ended[Action::specialization]) specialize(world, world.find(name));
  if (world.mistake != Mistake::divisions_first) divide_all();
  return newborn;
}

}  // namespace somas::reference
