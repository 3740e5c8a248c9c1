#include "core/model/cycle.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "somas/sdk/rng.hpp"

#include "core/model/mechanics.hpp"
#include "core/model/metabolism.hpp"
#include "core/model/ranges.hpp"

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
  dividing_count_.assign(world.organisms.size(), 0);
  marks_.resize(cells.size());
  share_ranges(team_, cells,
               [&](const CellRange& range) { decide(ecosystem, world, outputs, range); });

  // The cap on cells: first come, first served.
  each_marked(marks_, 1, [&](std::uint32_t place) {
    const std::uint32_t i = cells.order[place];
    OrganismState& organism = world.organisms[cells.organism[i]];
    std::uint32_t& dividing = dividing_count_[cells.organism[i]];
    const bool full = organism.live + dividing >= config.max_cells;
    if (full) ++organism.outcome.refused_divisions;
    if (full && witness_ != nullptr) witness_->division_refused(world, i);
    if (!full) ++dividing;
    cells.action[i] = full ? Action::quiescence : Action::division;
    cells.target[i] = no_state;
    cells.remaining[i] = duration(config.cycle, cells.action[i]);
  });
}

void CycleSolver::decide(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs,
                         const CellRange& range) {
  CellStore& cells = world.cells;
  const Cycle& cycle = ecosystem.config().cycle;
  const State& state = world.state_of(range.begin);
  const OutputChannels& channels = world.organisms[range.organism].phenotype->ports->out();
  std::uint32_t dividing = 0;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    marks_[cells.rank[i]] = 0;
    dividing += cells.action[i] == Action::division ? 1 : 0;
    if (cells.action[i] != Action::none) continue;
    Choice choice = strongest(state, channels, outputs, i);
    if (choice.action == Action::division) {
      const bool able =
          cells.energy[i] >= cycle.division_energy && cells.pressure[i] <= cycle.division_pressure;
      marks_[cells.rank[i]] = able ? 1 : 0;
      if (able) continue;  // if there is room
      choice = {};
    }
    cells.action[i] = choice.action;
    cells.target[i] = choice.target;
    cells.remaining[i] = duration(cycle, choice.action);
  }
  const std::atomic_ref count(dividing_count_[range.organism]);
  count.fetch_add(dividing, std::memory_order_relaxed);
}

bool CycleSolver::advance(const Ecosystem& ecosystem, WorldState& world) {
  const CellStore& cells = world.cells;
  share_ranges(team_, cells,
               [&](const CellRange& range) { advance(ecosystem.config().cycle, world, range); });
  const auto list = [&](Action ended, std::vector<std::uint32_t>& those) {
    those.clear();
    each_marked(marks_, static_cast<std::uint8_t>(ended),
                [&](std::uint32_t place) { those.push_back(cells.order[place]); });
  };
  list(Action::apoptosis, dying_);
  list(Action::specialization, specializing_);
  list(Action::division, dividing_);
  release(world);
  specialize(ecosystem, world);
  divide(ecosystem, world);
  return !specializing_.empty() || !dividing_.empty();
}

void CycleSolver::advance(const Cycle& cycle, WorldState& world, const CellRange& range) {
  CellStore& cells = world.cells;
  const double resting = world.state_of(range.begin).radius;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    std::uint8_t& ended = marks_[cells.rank[i]];
    ended = static_cast<std::uint8_t>(Action::none);
    if (cells.dead[i] != 0) continue;
    --cells.remaining[i];
    // A dividing cell doubles its area: r0 sqrt(1 + k / n) after k of n steps.
    if (cells.action[i] == Action::division) {
      const double done = cycle.division_steps - cells.remaining[i];
      cells.radius[i] = resting * std::sqrt(1.0 + done / double(cycle.division_steps));
    }
    if (cells.remaining[i] > 0) continue;
    ended = static_cast<std::uint8_t>(cells.action[i]);
    cells.action[i] = Action::none;
  }
}

void CycleSolver::release(WorldState& world) {
  if (dying_.empty()) return;
  CellStore& cells = world.cells;
  for (const std::uint32_t i : dying_) cells.kill(i, cause_apoptosis);

  // Equal parts for the contacts; the dying receive nothing that counts (it is lost with them).
  received_.resize(std::max<std::size_t>(received_.size(), cells.size()), 0.0);
  receivers_.clear();
  for (const std::uint32_t i : dying_) {
    const auto contacts = world.contacts.of(i);
    if (contacts.empty()) continue;  // then it is lost with the cell
    const double efficiency = world.state_of(i).skill(skill_diffusion);
    const double part = cells.ambrosia[i] / static_cast<double>(contacts.size());
    world.organisms[cells.organism[i]].ledger.lost_efficiency +=
        cells.ambrosia[i] * (1.0 - efficiency);
    for (const std::uint32_t j : contacts) {
      if (received_[j] == 0 && efficiency * part > 0) receivers_.push_back(j);
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
  std::sort(receivers_.begin(), receivers_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return cells.rank[a] < cells.rank[b]; });
  for (const std::uint32_t j : receivers_) {
    const double capacity = world.state_of(j).skill(skill_capacity);
    const double total = cells.ambrosia[j] + std::exchange(received_[j], 0.0);
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
