// Phase 5 (docs/model.md, section 2).
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/core/model/reference/phases.hpp"

namespace somas::reference {

namespace {

constexpr double no_energy = 1e-9;

double room_of(const World& world, const Cell& cell) {
  return std::max(0.0, world.state_of(cell).skill(model::skill_capacity) - cell.ambrosia);
}

/// What one cell may take of one resource.
struct Portion {
  double amount = 0;
  std::int64_t square = -1;  ///< -1: nothing
};

/// Of one resource, by cell: what every cell may take, so that no square gives more than it holds.
std::vector<Portion> portions_of(World& world, std::size_t r) {
  const model::Resource& resource = world.schema().resources[r];
  const Grid grid{world.grids[resource.grid], world.schema().grids[resource.grid].spec};
  std::vector<Portion> portions;
  std::map<std::int64_t, double> demanded;  // by square
  std::map<std::int64_t, int> askers;
  for (const Cell& cell : world.cells) {
    const double wish = share(cell.outputs[world.outputs_of(cell).uptakes[r]]) *
                        world.state_of(cell).skill(resource.production_skill);
    Portion& portion = portions.emplace_back();
    portion.amount = std::min(wish, room_of(world, cell));
    if (portion.amount > 0) portion.square = grid.index_of(cell.x, cell.y);
    if (portion.square < 0) portion.amount = 0;
    if (portion.square >= 0) ++askers[portion.square];
  }
  for (std::size_t k = 0; k < portions.size(); ++k) {
    const bool descending = world.mistake == Mistake::demands_descending;
    const Portion& portion = portions[descending ? portions.size() - 1 - k : k];
    if (portion.square >= 0) demanded[portion.square] += portion.amount;
  }
  for (Portion& portion : portions) {
    if (portion.square < 0) continue;
    const double content = grid.values[static_cast<std::size_t>(portion.square)];
    const double demand = demanded[portion.square];
    if (!(demand > content)) continue;
    portion.amount = world.mistake == Mistake::share_of_all
                         ? std::min(portion.amount, content / askers[portion.square])
                         : portion.amount * (content / demand);
    ++world.events.scarce_demands;
  }
  return portions;
}

}  // namespace

void take_up(World& world) {
  const std::vector<model::Resource>& resources = world.schema().resources;
  std::vector<std::vector<Portion>> portions;
  for (std::size_t r = 0; r < resources.size(); ++r) portions.push_back(portions_of(world, r));

  for (std::size_t i = 0; i < world.cells.size(); ++i) {
    Cell& cell = world.cells[i];
    const double room = room_of(world, cell);
    double all = 0;
    for (std::size_t r = 0; r < resources.size(); ++r) all += portions[r][i].amount;
    const double part = all > room ? room / all : 1.0;
    if (all > room) ++world.events.crowded_rooms;
    for (std::size_t r = 0; r < resources.size(); ++r) {
      if (portions[r][i].square < 0) continue;
      const double taken = portions[r][i].amount * part;
      double& content =
          world.grids[resources[r].grid][static_cast<std::size_t>(portions[r][i].square)];
      content = std::max(0.0, content - taken);
      cell.ambrosia += taken;
      world.organism_of(cell).ledger.taken.add(taken);
    }
  }
}

void convert(World& world) {
  for (const std::size_t i : world.booking_order()) {
    Cell& cell = world.cells[i];
    const double burnt = std::min(
        share(cell.outputs[world.outputs_of(cell).conversion]) * cell.ambrosia, 1.0 - cell.energy);
    cell.ambrosia -= burnt;
    cell.energy += burnt;
    world.organism_of(cell).ledger.burnt.add(burnt);
  }
}

void diffuse(World& world) {
  struct Trade {
    double efficiency, room, offer = 0;  ///< the offer to each contact
    double accepted = 1, gain = 0;       ///< share taken of what comes in, and how much that is
  };
  std::map<Name, Trade> trades;
  for (const Cell& cell : world.cells) {
    const model::State& state = world.state_of(cell);
    Trade trade{state.skill(model::skill_diffusion), room_of(world, cell)};
    const double wish = share(cell.outputs[world.outputs_of(cell).diffusion]);
    if (!cell.contacts.empty())
      trade.offer = wish * cell.ambrosia / static_cast<double>(cell.contacts.size());
    if (world.mistake == Mistake::own_gift_first)
      trade.room += trade.offer * static_cast<double>(cell.contacts.size());
    trades[cell.name] = trade;
  }
  for (const Cell& cell : world.cells) {
    Trade& trade = trades[cell.name];
    std::vector<Name> givers = cell.contacts;
    if (world.mistake == Mistake::gifts_descending) std::reverse(givers.begin(), givers.end());
    double incoming = 0;
    for (const Name& giver : givers) incoming += trades[giver].efficiency * trades[giver].offer;
    const bool too_much = incoming > trade.room;
    trade.accepted = too_much ? trade.room / incoming : 1.0;
    trade.gain = too_much ? trade.room : incoming;
    if (too_much) ++world.events.shrunk_gifts;
  }
  for (Cell& cell : world.cells) {
    const Trade& trade = trades[cell.name];
    Ledger& ledger = world.organism_of(cell).ledger;
    double given = 0;
    for (const Name& receiver : cell.contacts) {
      if (!(trade.offer > 0)) break;
      given += trade.offer * trades[receiver].accepted;
      const double arrived = trade.efficiency * trade.offer * trades[receiver].accepted;
      if (arrived > 0) ++world.events.gifts;
      if (receiver.organism == cell.name.organism) continue;
      ledger.given.add(arrived);
      world.organisms[receiver.organism].ledger.received.add(arrived);
      if (arrived > 0) ++world.events.gifts_to_strangers;
    }
    cell.ambrosia = std::max(0.0, cell.ambrosia - given) + trade.gain;
    ledger.lost_efficiency.add(given * (1.0 - trade.efficiency));
  }
}

void pay(World& world) {
  const model::Metabolism& costs = world.config().metabolism;
  const std::map<Action, double> cost_of{{Action::none, 0.0},
                                         {Action::quiescence, costs.quiescence_cost},
                                         {Action::division, costs.division_cost},
                                         {Action::specialization, costs.specialization_cost},
                                         {Action::apoptosis, costs.apoptosis_cost}};
  for (const std::size_t i : world.booking_order()) {
    Cell& cell = world.cells[i];
    const model::State& state = world.state_of(cell);
    const double crawling = costs.motility_cost * std::abs(state.motility);
    const double cost =
        (cost_of.at(cell.action) + crawling) / state.skill(model::skill_energy_efficiency);
    const double paid = std::min(cost, cell.energy);
    cell.energy -= paid;
    world.organism_of(cell).ledger.spent.add(paid);
    if (cell.energy <= no_energy) cell.kill(model::cause_starvation);
  }
}

}  // namespace somas::reference
