#include "core/model/metabolism.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "core/model/lanes.hpp"
#include "core/model/ranges.hpp"

namespace somas::model {

namespace {

/// Squares behind the last one, of cells that ask for nothing: several, so that sums of what they
/// ask for need not wait for each other.
constexpr std::uint32_t squares_of_none = 8;

const State& state_of(const WorldState& world, const CellRange& range) {
  return world.organisms[range.organism].phenotype->tree->states[range.state];
}

const OutputChannels& outputs_of(const WorldState& world, const CellRange& range) {
  return world.organisms[range.organism].phenotype->ports->out();
}

/// Four sums at a time, as Sum adds.
struct FourSums {
  Four sum, error;

  void add(const Four& x) {
    const Four next = sum + x;
    const Four of_sum = sum < 0 ? -sum : sum, of_x = x < 0 ? -x : x;
    error += of_sum >= of_x ? (sum - next) + x : (x - next) + sum;
    sum = next;
  }
};

/// Sums over the contacts of cells, in their order. How many a cell has is hard to foretell, so the
/// first six are always looked up, and of those that are none 0 is added: that changes no bit.
class SumsOverContacts {
 public:
  SumsOverContacts(const Contacts& contacts, const std::vector<double>& of)
      : runs_(contacts.runs.data()),
        items_(contacts.items.data()),
        room_(contacts.items.size()),
        last_(contacts.runs.size() - 1),
        of_(of.data()) {}

  /// 0 + factor * of[first] + factor * of[second] ...
  [[nodiscard]] double operator()(std::uint32_t cell, double factor) const {
    // In large worlds the items of cells that follow each other stand far apart.
    __builtin_prefetch(items_ + runs_[std::min<std::size_t>(cell + 16, last_)].begin);
    const std::uint32_t begin = runs_[cell].begin, count = runs_[cell].end - begin;
    const std::uint32_t* items = items_ + begin;
    double sum = 0;
    std::uint32_t next = 0;
    if (begin + std::size_t{6} <= room_) {
      FourMask is_one;
      TwoMask too;
      std::memcpy(&is_one, which + 6 - std::min(count, 6u), sizeof is_one);
      std::memcpy(&too, which + 10 - std::min(count, 6u), sizeof too);
      const Four first = factor * Four{of_[items[0]], of_[items[1]], of_[items[2]], of_[items[3]]};
      const Two second = factor * Two{of_[items[4]], of_[items[5]]};
      const Four four = is_one ? first : Four{};
      const Two two = too ? second : Two{};
      sum = 0 + four[0] + four[1] + four[2] + four[3] + two[0] + two[1];
      next = 6;
    }
    for (; next < count; ++next) sum += factor * of_[items[next]];
    return sum;
  }

 private:
  static constexpr std::int64_t which[12] = {-1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0};
  const Contacts::Run* runs_;
  const std::uint32_t* items_;
  std::size_t room_, last_;
  const double* of_;
};

}  // namespace

struct MetabolismSolver::Step {
  const Ecosystem& ecosystem;
  WorldState& world;
  const FloatMatrix& outputs;

  [[nodiscard]] const std::vector<Resource>& resources() const {
    return ecosystem.schema().resources;
  }
  [[nodiscard]] std::vector<double>& content(const Resource& resource) const {
    return world.grids[resource.grid];
  }
};

void MetabolismSolver::run(const Ecosystem& ecosystem, WorldState& world,
                           const FloatMatrix& outputs) {
  const Step step{ecosystem, world, outputs};
  const std::uint32_t count = world.cells.size();
  prepare(step);
  share_ranges(team_, world.cells, [&](const CellRange& cells) { ask(step, cells); });
  sum_demands(step);
  share_ranges(team_, world.cells, [&](const CellRange& cells) {
    take_up(step, cells);
    convert(step, cells);
    offer(step, cells);
  });
  if (bad_content_) refuse_contents(step);
  // Gains wait until every offer is settled.
  share_ranges(team_, world.cells, [&](const CellRange& cells) { accept(step, cells); });
  if (ecosystem.config().strangers.feed) book_gifts_to_strangers(world);
  if (witness_ != nullptr) tell_of_gifts(world);
  share_ranges(team_, world.cells, [&](const CellRange& cells) {
    diffuse(step, cells);
    pay(step, cells);
  });

  // Two things that each hang on the order of the cells.
  const auto in_order = [&](unsigned part) { part == 0 ? empty_squares(step) : keep_books(step); };
  if (team_ != nullptr && team_->parts(count) > 1) return team_->run(2, in_order);
  in_order(0);
  in_order(1);
}

void MetabolismSolver::prepare(const Step& step) {
  const std::size_t count = step.world.cells.size(), resources = step.resources().size();
  demand_.resize(resources * count);
  square_.resize(resources * count);
  square_demand_.resize(resources);
  for (std::size_t r = 0; r < resources; ++r)
    square_demand_[r].resize(step.content(step.resources()[r]).size() + squares_of_none, 0.0);
  for (auto* column : {&room_, &offer_, &gift_, &accepted_, &gain_, &burnt_, &spent_, &lost_})
    column->resize(count);
}

void MetabolismSolver::ask(const Step& step, const CellRange& range) {
  const CellStore& cells = step.world.cells;
  const State& state = state_of(step.world, range);
  const std::vector<Resource>& resources = step.resources();
  const double capacity = state.skill(skill_capacity);
  for (std::uint32_t i = range.begin; i < range.end; ++i)
    room_[i] = std::max(0.0, capacity - cells.ambrosia[i]);
  for (std::size_t r = 0; r < resources.size(); ++r) {
    const float* wish = step.outputs.row(outputs_of(step.world, range).uptakes[r]);
    const double production = state.skill(resources[r].production_skill);
    const Grid grid{step.content(resources[r]),
                    step.ecosystem.schema().grids[resources[r].grid].spec};
    const auto none = static_cast<std::uint32_t>(grid.values.size());
    double* demand = demand_.data() + r * cells.size();
    std::uint32_t* square = square_.data() + r * cells.size();
    // Squares in lanes, some at a time; then to where the cells stand in canonical order.
    constexpr std::uint32_t most = 128;
    std::array<double, most> wanted;
    std::array<std::int64_t, most> at;
    for (std::uint32_t begin = range.begin; begin < range.end; begin += most) {
      const std::uint32_t some = std::min(most, range.end - begin);
      const double *x = &cells.x[begin], *y = &cells.y[begin], *room = &room_[begin];
      for (std::uint32_t l = 0; l < some; ++l)
        wanted[l] = std::min(share(wish[begin + l]) * production, room[l]);
      for (std::uint32_t l = 0; production > 0 && l < some; ++l) at[l] = grid.index_of(x[l], y[l]);
      for (std::uint32_t l = 0; l < some; ++l) {
        const bool asks = wanted[l] > 0 && at[l] >= 0;
        const std::uint32_t k = cells.rank[begin + l];
        demand[k] = asks ? wanted[l] : 0.0;
        square[k] = asks ? static_cast<std::uint32_t>(at[l]) : none + k % squares_of_none;
      }
    }
  }
}

void MetabolismSolver::sum_demands(const Step& step) {
  const std::size_t count = step.world.cells.size();
  for (std::size_t r = 0; r < square_demand_.size(); ++r) {
    const double* demand = demand_.data() + r * count;
    const std::uint32_t* square = square_.data() + r * count;
    double* of_square = square_demand_[r].data();
    for (std::size_t k = 0; k < count; ++k) of_square[square[k]] += demand[k];
  }
}

void MetabolismSolver::take_up(const Step& step, const CellRange& range) {
  const std::vector<Resource>& resources = step.resources();
  CellStore& cells = step.world.cells;
  bool bad = false;
  if (resources.size() == 1) {
    // As below, but nobody has asked for more than its room.
    const std::vector<double>& content = step.content(resources[0]);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const std::size_t k = cells.rank[i];
      const std::uint32_t square = square_[k];
      if (square >= content.size()) continue;
      const double held = content[square], asked = square_demand_[0][square];
      bad |= !(held >= 0);
      if (asked > held) demand_[k] = demand_[k] * (held / asked);
      cells.ambrosia[i] += demand_[k];
    }
    if (bad) bad_content_ = true;
    return;
  }
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const std::size_t k = cells.rank[i];
    // Squares that are asked for more than they hold give everything, in proportion.
    double yield = 0;
    for (std::size_t r = 0; r < resources.size(); ++r) {
      const std::vector<double>& content = step.content(resources[r]);
      const std::uint32_t square = square_[r * cells.size() + k];
      if (square >= content.size()) continue;
      double& demand = demand_[r * cells.size() + k];
      const double asked = square_demand_[r][square];
      bad |= !(content[square] >= 0);
      if (asked > content[square]) demand = demand * (content[square] / asked);
      yield += demand;
    }
    // What several resources yield together may exceed the room: all are taken in proportion.
    const double part = yield > room_[i] ? room_[i] / yield : 1.0;
    for (std::size_t r = 0; r < resources.size(); ++r) {
      double& taken = demand_[r * cells.size() + k];
      taken = taken * part;
      cells.ambrosia[i] += taken;
    }
  }
  if (bad) bad_content_ = true;
}

void MetabolismSolver::refuse_contents(const Step& step) const {
  const std::size_t count = step.world.cells.size();
  for (std::size_t r = 0; r < step.resources().size(); ++r) {
    const Resource& resource = step.resources()[r];
    const std::vector<double>& content = step.content(resource);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t square = square_[r * count + k];
      if (square < content.size() && !(content[square] >= 0))
        throw PluginFailure(step.ecosystem.schema().grids[resource.grid].owner,
                            "step " + std::to_string(step.world.step),
                            "the content of '" + resource.name + "' is not a number >= 0");
    }
  }
}

void MetabolismSolver::convert(const Step& step, const CellRange& range) {
  CellStore& cells = step.world.cells;
  const float* wish = step.outputs.row(outputs_of(step.world, range).conversion);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const double amount = std::min(share(wish[i]) * cells.ambrosia[i], 1.0 - cells.energy[i]);
    cells.ambrosia[i] -= amount;
    cells.energy[i] += amount;
    burnt_[i] = amount;
  }
}

void MetabolismSolver::offer(const Step& step, const CellRange& range) {
  const CellStore& cells = step.world.cells;
  const Contacts& contacts = step.world.contacts;
  const float* wish = step.outputs.row(outputs_of(step.world, range).diffusion);
  const double efficiency = state_of(step.world, range).skill(skill_diffusion);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const std::size_t receivers = contacts.of(i).size();
    offer_[i] =
        receivers > 0 ? share(wish[i]) * cells.ambrosia[i] / static_cast<double>(receivers) : 0.0;
    gift_[i] = efficiency * offer_[i];
  }
}

void MetabolismSolver::accept(const Step& step, const CellRange& range) {
  const CellStore& cells = step.world.cells;
  const SumsOverContacts gifts(step.world.contacts, gift_);
  const double capacity = state_of(step.world, range).skill(skill_capacity);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const double incoming = gifts(i, 1);
    const double room = std::max(0.0, capacity - cells.ambrosia[i]);
    accepted_[i] = incoming > room ? room / incoming : 1.0;
    gain_[i] = incoming > room ? room : incoming;
  }
}

void MetabolismSolver::diffuse(const Step& step, const CellRange& range) {
  CellStore& cells = step.world.cells;
  const SumsOverContacts accepted(step.world.contacts, accepted_);
  const double efficiency = state_of(step.world, range).skill(skill_diffusion);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const double loss = offer_[i] > 0 ? accepted(i, offer_[i]) : 0.0;
    cells.ambrosia[i] = std::max(0.0, cells.ambrosia[i] - loss) + gain_[i];
    lost_[cells.rank[i]] = loss * (1.0 - efficiency);
  }
}

void MetabolismSolver::pay(const Step& step, const CellRange& range) {
  CellStore& cells = step.world.cells;
  const Metabolism& costs = step.ecosystem.config().metabolism;
  const State& state = state_of(step.world, range);
  const double crawling = costs.motility_cost * std::abs(state.motility);
  std::array<double, 5> by_action{0.0, costs.quiescence_cost, costs.division_cost,
                                  costs.specialization_cost, costs.apoptosis_cost};
  for (double& cost : by_action) cost = (cost + crawling) / state.skill(skill_energy_efficiency);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const double cost = by_action[static_cast<std::size_t>(cells.action[i])];
    spent_[i] = std::min(cost, cells.energy[i]);
    cells.energy[i] -= spent_[i];
    if (cells.energy[i] <= starving) cells.kill(i, cause_starvation);
  }
}

void MetabolismSolver::book_gifts_to_strangers(WorldState& world) const {
  const CellStore& cells = world.cells;
  for (const std::uint32_t i : cells.order) {
    if (!(offer_[i] > 0)) continue;
    for (const std::uint32_t j : world.contacts.of(i)) {
      if (cells.organism[j] == cells.organism[i]) continue;
      const double arrived = gift_[i] * accepted_[j];
      world.organisms[cells.organism[i]].ledger.given += arrived;
      world.organisms[cells.organism[j]].ledger.received += arrived;
    }
  }
}

void MetabolismSolver::tell_of_gifts(const WorldState& world) const {
  for (const std::uint32_t i : world.cells.order) {
    if (!(offer_[i] > 0)) continue;
    for (const std::uint32_t j : world.contacts.of(i)) {
      const double arrived = gift_[i] * accepted_[j];
      if (arrived > 0) witness_->ambrosia_passed(world, i, j, arrived);
    }
  }
}

void MetabolismSolver::empty_squares(const Step& step) {
  const std::vector<Resource>& resources = step.resources();
  const std::size_t count = step.world.cells.size();
  const auto empty = [](std::vector<double>& content, std::vector<double>& asked,
                        std::uint32_t square, double taken) {
    if (square >= content.size()) return;
    content[square] = std::max(0.0, content[square] - taken);
    asked[square] = 0;
  };
  if (resources.size() == 1) {
    std::vector<double>& content = step.content(resources[0]);
    for (std::size_t k = 0; k < count; ++k)
      empty(content, square_demand_[0], square_[k], demand_[k]);
    return;
  }
  // Several may take from the same squares: cell by cell.
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t r = 0; r < resources.size(); ++r)
      empty(step.content(resources[r]), square_demand_[r], square_[r * count + k],
            demand_[r * count + k]);
}

void MetabolismSolver::keep_books(const Step& step) const {
  // Those of an organism stand together, in storage and in canonical order.
  const std::vector<CellRange>& ranges = step.world.cells.ranges;
  const std::size_t resources = step.resources().size(), count = step.world.cells.size();
  for (std::size_t first = 0, next = 0; first < ranges.size(); first = next) {
    while (next < ranges.size() && ranges[next].organism == ranges[first].organism) ++next;
    Ledger& ledger = step.world.organisms[ranges[first].organism].ledger;
    Sum* const sums[4] = {&ledger.taken, &ledger.lost_efficiency, &ledger.burnt, &ledger.spent};
    FourSums books{
        .sum = {sums[0]->sum(), sums[1]->sum(), sums[2]->sum(), sums[3]->sum()},
        .error = {sums[0]->error(), sums[1]->error(), sums[2]->error(), sums[3]->error()}};
    // Nothing is added for what there is none of: that changes no bit.
    for (std::size_t k = ranges[first].begin; k < ranges[next - 1].end; ++k) {
      books.add(Four{resources > 0 ? demand_[k] : 0.0, lost_[k], burnt_[k], spent_[k]});
      for (std::size_t r = 1; r < resources; ++r) books.add(Four{demand_[r * count + k], 0, 0, 0});
    }
    for (int s = 0; s < 4; ++s) *sums[s] = Sum(books.sum[s], books.error[s]);
  }
}

}  // namespace somas::model
