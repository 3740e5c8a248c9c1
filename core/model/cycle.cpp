#include "core/model/cycle.hpp"

#include <algorithm>
#include <cmath>

#include "somas/sdk/rng.hpp"

#include "core/model/mechanics.hpp"
#include "core/model/metabolism.hpp"

namespace somas::model {

namespace {

constexpr double equal_eigenvalues = 1e-9;

std::uint32_t duration(const Cycle& cycle, Action action) {
  switch (action) {
    case Action::division:
      return cycle.division_steps;
    case Action::specialization:
      return cycle.specialization_steps;
    case Action::apoptosis:
      return cycle.apoptosis_steps;
    default:
      return cycle.quiescence_steps;
  }
}

/// What an output below its threshold or without a number has: it wins against nothing.
constexpr float no_score = -std::numeric_limits<float>::infinity();

float score(float output, float threshold) {
  const float clamped = output > 0 ? (output < 1 ? output : 1.0f) : 0.0f;
  return output == output && clamped >= threshold ? output : no_score;
}

}  // namespace

Choice strongest(const State& state, const OutputChannels& channels, const FloatMatrix& outputs,
                 std::uint32_t cell) {
  const Thresholds& least = state.thresholds;
  const auto value = [&](std::uint32_t channel, float threshold) {
    return score(outputs.row(channel)[cell], threshold);
  };
  Choice best{Action::quiescence, no_state};
  float best_value = value(channels.quiescence, least.quiescence);
  // Later candidates must be strictly stronger: their order is the order of ties.
  const auto offer = [&](Choice candidate, float strength) {
    if (!(strength > best_value)) return;
    best = candidate;
    best_value = strength;
  };
  offer({Action::division, no_state}, value(channels.division, least.division));
  for (const std::uint16_t child : state.children)
    offer({Action::specialization, child}, value(channels.specialize[child], least.specialization));
  offer({Action::apoptosis, no_state}, value(channels.apoptosis, least.apoptosis));
  return best;
}

bool division_axis(double xx, double xy, double yy, double& ax, double& ay) {
  // Eigenvalues are mean +- root; the eigenvector of the greater one is (half + root, xy) or
  // (xy, root - half), whichever is longer.
  const double half = 0.5 * (xx - yy);
  const double root = std::sqrt(half * half + xy * xy);
  if (2.0 * root <= equal_eigenvalues) return false;
  const double px = half >= 0 ? half + root : xy;
  const double py = half >= 0 ? xy : root - half;
  const double length = std::sqrt(px * px + py * py);
  ax = -py / length;
  ay = px / length;
  return true;
}

void CycleSolver::decide(const Ecosystem& ecosystem, WorldState& world,
                         const FloatMatrix& outputs) {
  CellStore& cells = world.cells;
  const Config& config = ecosystem.config();
  std::vector<std::uint32_t>& dividing = dividing_count_;
  dividing.assign(world.organisms.size(), 0);
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    if (cells.action[i] == Action::division) ++dividing[cells.organism[i]];

  for (const std::uint32_t i : cells.order) {
    if (cells.action[i] != Action::none) continue;
    OrganismState& organism = world.organisms[cells.organism[i]];
    Choice choice = strongest(world.state_of(i), organism.phenotype->ports->out(), outputs, i);
    if (choice.action == Action::division) {
      const bool able = cells.energy[i] >= config.cycle.division_energy &&
                        cells.pressure[i] <= config.cycle.division_pressure;
      const bool full = organism.live + dividing[cells.organism[i]] >= config.max_cells;
      if (able && full) ++organism.outcome.refused_divisions;
      if (able && full && witness_ != nullptr) witness_->division_refused(world, i);
      if (able && !full) ++dividing[cells.organism[i]];
      if (!able || full) choice = {};
    }
    cells.action[i] = choice.action;
    cells.target[i] = choice.target;
    cells.remaining[i] = duration(config.cycle, choice.action);
  }
}

bool CycleSolver::advance(const Ecosystem& ecosystem, WorldState& world) {
  CellStore& cells = world.cells;
  const Cycle& cycle = ecosystem.config().cycle;
  dying_.clear();
  specializing_.clear();
  dividing_.clear();
  for (const std::uint32_t i : cells.order) {
    if (cells.dead[i] != 0) continue;
    --cells.remaining[i];
    // A dividing cell doubles its area: r0 sqrt(1 + k / n) after k of n steps.
    if (cells.action[i] == Action::division) {
      const double done = cycle.division_steps - cells.remaining[i];
      cells.radius[i] =
          world.state_of(i).radius * std::sqrt(1.0 + done / double(cycle.division_steps));
    }
    if (cells.remaining[i] > 0) continue;
    if (cells.action[i] == Action::apoptosis) dying_.push_back(i);
    if (cells.action[i] == Action::specialization) specializing_.push_back(i);
    if (cells.action[i] == Action::division) dividing_.push_back(i);
    cells.action[i] = Action::none;
  }
  release(world);
  specialize(ecosystem, world);
  divide(ecosystem, world);
  return !specializing_.empty() || !dividing_.empty();
}

void CycleSolver::release(WorldState& world) {
  if (dying_.empty()) return;
  CellStore& cells = world.cells;
  for (const std::uint32_t i : dying_) cells.kill(i, cause_apoptosis);

  // Equal parts for the contacts; the dying receive nothing that counts (it is lost with them).
  received_.assign(cells.size(), 0.0);
  for (const std::uint32_t i : dying_) {
    const auto contacts = world.contacts.of(i);
    if (contacts.empty()) continue;  // then it is lost with the cell
    const double efficiency = world.state_of(i).skill(skill_diffusion);
    const double part = cells.ambrosia[i] / static_cast<double>(contacts.size());
    world.organisms[cells.organism[i]].ledger.lost_efficiency +=
        cells.ambrosia[i] * (1.0 - efficiency);
    for (const std::uint32_t j : contacts) {
      received_[j] += efficiency * part;
      if (witness_ != nullptr && efficiency * part > 0)
        witness_->ambrosia_passed(world, i, j, efficiency * part);
      if (cells.organism[j] == cells.organism[i]) continue;
      world.organisms[cells.organism[i]].ledger.given += efficiency * part;
      world.organisms[cells.organism[j]].ledger.received += efficiency * part;
    }
  }
  for (const std::uint32_t i : dying_)
    if (!world.contacts.of(i).empty()) cells.ambrosia[i] = 0;
  for (const std::uint32_t j : cells.order) {
    if (received_[j] == 0) continue;
    const double capacity = world.state_of(j).skill(skill_capacity);
    const double total = cells.ambrosia[j] + received_[j];
    const double excess = std::max(0.0, total - capacity);
    cells.ambrosia[j] = total - excess;
    world.organisms[cells.organism[j]].ledger.lost_overflow += excess;
  }
}

void CycleSolver::specialize(const Ecosystem& ecosystem, WorldState& world) {
  CellStore& cells = world.cells;
  for (const std::uint32_t i : specializing_) {
    OrganismState& organism = world.organisms[cells.organism[i]];
    const std::uint16_t from = cells.state[i];
    cells.state[i] = cells.target[i];
    const State& state = world.state_of(i);
    cells.radius[i] = state.radius;
    const double excess = std::max(0.0, cells.ambrosia[i] - state.skill(skill_capacity));
    cells.ambrosia[i] -= excess;
    organism.ledger.lost_overflow += excess;
    ++organism.outcome.specializations;
    if (witness_ != nullptr) witness_->specialized(world, i, from);
    // Damage stays: what the old state withstood may be too much for the new one.
    const std::vector<Hazard>& hazards = ecosystem.schema().hazards;
    for (std::size_t h = 0; h < hazards.size(); ++h)
      if (cells.damage[h][i] > state.skill(hazards[h].resistance_skill))
        cells.kill(i, hazards[h].cause);
  }
}

void CycleSolver::divide(const Ecosystem& ecosystem, WorldState& world) {
  CellStore& cells = world.cells;
  const std::vector<CellValue>& values = ecosystem.schema().cell_values;
  for (const std::uint32_t mother : dividing_) {  // ascending (organism, id)
    OrganismState& organism = world.organisms[cells.organism[mother]];
    const State& state = world.state_of(mother);
    double ax = 0, ay = 0;
    if (!division_axis(cells.stress_xx[mother], cells.stress_xy[mother], cells.stress_yy[mother],
                       ax, ay)) {
      Rng rng(world.seed, organism.key, world.step, stable_key("core.division_axis"),
              cells.id[mother]);
      const math::SinCos angle = math::sincos(math::two_pi * rng.uniform());
      ax = angle.cos, ay = angle.sin;
    }

    cells.radius[mother] = state.radius;
    cells.energy[mother] *= 0.5;
    cells.ambrosia[mother] *= 0.5;
    for (std::size_t v = 0; v < values.size(); ++v)
      if (values[v].rule == OnDivision::halve) cells.values[v][mother] *= 0.5;
    const std::uint32_t daughter = cells.append(cells.memory.channels());
    cells.copy_cell(mother, daughter);
    for (std::size_t v = 0; v < values.size(); ++v)
      if (values[v].rule == OnDivision::zero) cells.values[v][daughter] = 0;

    const double half = 0.5 * rest_distance(state);
    cells.x[mother] += half * ax;
    cells.y[mother] += half * ay;
    cells.x[daughter] -= half * ax;
    cells.y[daughter] -= half * ay;
    cells.id[daughter] = organism.next_id++;
    cells.parent[daughter] = cells.id[mother];
    cells.born[daughter] = world.step;
    ++organism.outcome.divisions;
    ++organism.live;
    if (witness_ != nullptr) witness_->born(world, daughter);
  }
}

}  // namespace somas::model
