#include "core/model/metabolism.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace somas::model {

namespace {

const State& state_of(const WorldState& world, const CellRange& range) {
  return world.organisms[range.organism].phenotype->tree->states[range.state];
}

const OutputChannels& outputs_of(const WorldState& world, const CellRange& range) {
  return world.organisms[range.organism].phenotype->ports->out();
}

}  // namespace

void MetabolismSolver::run(const Ecosystem& ecosystem, WorldState& world,
                           const FloatMatrix& outputs) {
  take_up(ecosystem, world, outputs);
  convert(world, outputs);
  diffuse(ecosystem, world, outputs);
  pay(ecosystem, world);
}

void MetabolismSolver::take_up(const Ecosystem& ecosystem, WorldState& world,
                               const FloatMatrix& outputs) {
  const std::vector<Resource>& resources = ecosystem.schema().resources;
  CellStore& cells = world.cells;
  const std::size_t count = cells.size();

  // What every cell asks for of each resource, within its room.
  demand_.resize(resources.size() * count);
  room_.resize(count);
  for (const CellRange& range : cells.ranges) {
    const State& state = state_of(world, range);
    const OutputChannels& channels = outputs_of(world, range);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      room_[i] = std::max(0.0, state.skill(skill_capacity) - cells.ambrosia[i]);
      for (std::size_t r = 0; r < resources.size(); ++r)
        demand_[r * count + i] = std::min(
            share(outputs.row(channels.uptakes[r])[i]) * state.skill(resources[r].production_skill),
            room_[i]);
    }
  }

  // Squares that are asked for more than they hold give everything, in proportion.
  square_.resize(count);
  squares_of_resource_.clear();
  for (std::size_t r = 0; r < resources.size(); ++r) {
    std::vector<double>& content = world.grids[resources[r].grid];
    const Grid grid{content, ecosystem.schema().grids[resources[r].grid].spec};
    double* demand = demand_.data() + r * count;
    square_demand_.resize(content.size(), 0.0);
    for (std::uint32_t i = 0; i < count; ++i) {
      square_[i] = demand[i] > 0 ? grid.index_of(cells.x[i], cells.y[i]) : -1;
      if (square_[i] >= 0) square_demand_[static_cast<std::size_t>(square_[i])] = 0;
    }
    for (const std::uint32_t i : cells.order)
      if (square_[i] >= 0) square_demand_[static_cast<std::size_t>(square_[i])] += demand[i];
    for (const std::uint32_t i : cells.order) {
      if (square_[i] < 0) {
        demand[i] = 0;
        continue;
      }
      const auto square = static_cast<std::size_t>(square_[i]);
      if (!(content[square] >= 0))
        throw PluginFailure(ecosystem.schema().grids[resources[r].grid].owner,
                            "step " + std::to_string(world.step),
                            "the content of '" + resources[r].name + "' is not a number >= 0");
      const bool scarce = square_demand_[square] > content[square];
      if (scarce) demand[i] = demand[i] * (content[square] / square_demand_[square]);
    }
    squares_of_resource_.insert(squares_of_resource_.end(), square_.begin(), square_.end());
  }

  // What several resources yield together may exceed the room: then all are taken in proportion.
  for (const std::uint32_t i : cells.order) {
    double yield = 0;
    for (std::size_t r = 0; r < resources.size(); ++r) yield += demand_[r * count + i];
    const double part = yield > room_[i] ? room_[i] / yield : 1.0;
    for (std::size_t r = 0; r < resources.size(); ++r) {
      const std::int64_t square = squares_of_resource_[r * count + i];
      if (square < 0) continue;
      const double taken = demand_[r * count + i] * part;
      double& content = world.grids[resources[r].grid][static_cast<std::size_t>(square)];
      content = std::max(0.0, content - taken);
      cells.ambrosia[i] += taken;
      world.organisms[cells.organism[i]].ledger.taken += taken;
    }
  }
}

void MetabolismSolver::convert(WorldState& world, const FloatMatrix& outputs) {
  CellStore& cells = world.cells;
  for (const CellRange& range : cells.ranges) {
    const float* wish = outputs.row(outputs_of(world, range).conversion);
    Sum& burnt = world.organisms[range.organism].ledger.burnt;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const double amount = std::min(share(wish[i]) * cells.ambrosia[i], 1.0 - cells.energy[i]);
      cells.ambrosia[i] -= amount;
      cells.energy[i] += amount;
      burnt += amount;
    }
  }
}

void MetabolismSolver::diffuse(const Ecosystem& ecosystem, WorldState& world,
                               const FloatMatrix& outputs) {
  CellStore& cells = world.cells;
  const Contacts& contacts = world.contacts;
  const std::size_t count = cells.size();

  // Offers to each contact, and what states say of giving and taking.
  offer_.assign(count, 0.0);
  gift_.resize(count);
  efficiency_.resize(count);
  room_.resize(count);
  for (const CellRange& range : cells.ranges) {
    const float* wish = outputs.row(outputs_of(world, range).diffusion);
    const State& state = state_of(world, range);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      efficiency_[i] = state.skill(skill_diffusion);
      room_[i] = std::max(0.0, state.skill(skill_capacity) - cells.ambrosia[i]);
      const std::size_t receivers = contacts.of(i).size();
      if (receivers > 0)
        offer_[i] = share(wish[i]) * cells.ambrosia[i] / static_cast<double>(receivers);
      gift_[i] = efficiency_[i] * offer_[i];
    }
  }

  // What comes in, and the part of it that finds room; gains wait until every offer is settled.
  accepted_.resize(count);
  gain_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    double incoming = 0;
    for (const std::uint32_t j : contacts.of(i)) incoming += gift_[j];
    accepted_[i] = incoming > room_[i] ? room_[i] / incoming : 1.0;
    gain_[i] = incoming > room_[i] ? room_[i] : incoming;
  }
  if (ecosystem.config().strangers.feed) book_gifts_to_strangers(world);
  if (witness_ != nullptr) tell_of_gifts(world);
  for (const std::uint32_t i : cells.order) {
    double loss = 0;
    if (offer_[i] > 0)
      for (const std::uint32_t j : contacts.of(i)) loss += offer_[i] * accepted_[j];
    cells.ambrosia[i] = std::max(0.0, cells.ambrosia[i] - loss) + gain_[i];
    world.organisms[cells.organism[i]].ledger.lost_efficiency += loss * (1.0 - efficiency_[i]);
  }
}

void MetabolismSolver::book_gifts_to_strangers(WorldState& world) const {
  const CellStore& cells = world.cells;
  for (const std::uint32_t i : cells.order) {
    if (!(offer_[i] > 0)) continue;
    for (const std::uint32_t j : world.contacts.of(i)) {
      if (cells.organism[j] == cells.organism[i]) continue;
      const double arrived = efficiency_[i] * offer_[i] * accepted_[j];
      world.organisms[cells.organism[i]].ledger.given += arrived;
      world.organisms[cells.organism[j]].ledger.received += arrived;
    }
  }
}

void MetabolismSolver::tell_of_gifts(const WorldState& world) const {
  for (const std::uint32_t i : world.cells.order) {
    if (!(offer_[i] > 0)) continue;
    for (const std::uint32_t j : world.contacts.of(i)) {
      const double arrived = efficiency_[i] * offer_[i] * accepted_[j];
      if (arrived > 0) witness_->ambrosia_passed(world, i, j, arrived);
    }
  }
}

void MetabolismSolver::pay(const Ecosystem& ecosystem, WorldState& world) {
  CellStore& cells = world.cells;
  const Metabolism& costs = ecosystem.config().metabolism;
  const std::array<double, 5> by_action{0.0, costs.quiescence_cost, costs.division_cost,
                                        costs.specialization_cost, costs.apoptosis_cost};
  for (const CellRange& range : cells.ranges) {
    const State& state = state_of(world, range);
    const double efficiency = state.skill(skill_energy_efficiency);
    const double crawling = costs.motility_cost * std::abs(state.motility);
    Sum& spent = world.organisms[range.organism].ledger.spent;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const double action = by_action[static_cast<std::size_t>(cells.action[i])];
      const double cost = (action + crawling) / efficiency;
      const double paid = std::min(cost, cells.energy[i]);
      cells.energy[i] -= paid;
      spent += paid;
      if (cells.energy[i] <= starving) cells.kill(i, cause_starvation);
    }
  }
}

}  // namespace somas::model
