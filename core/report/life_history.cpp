#include "core/report/life_history.hpp"

#include <algorithm>
#include <utility>

#include "core/recording/header.hpp"

namespace somas::report {

const model::OrganismState& LifeHistory::own(const model::Simulation& simulation) const {
  const std::vector<model::OrganismState>& organisms = simulation.state().organisms;
  return *std::find_if(organisms.begin(), organisms.end(),
                       [&](const auto& one) { return one.roster_index == organism_; });
}

void LifeHistory::describe(const recording::Header& header) {
  for (std::size_t o = 0; o < header.organisms.size(); ++o)
    if (header.organisms[o].seat == organism_) own_ = static_cast<std::uint16_t>(o);
  const recording::Organism& organism = header.organisms[own_];
  first_slot_ = organism.first_slot;
  for (const recording::State& state : organism.states) cells_.names.push_back(state.name);
  deaths_.names = header.causes;
  for (std::size_t g = 0; g < header.grids.size(); ++g) {
    if (header.grids[g].resource.empty()) continue;
    resources_.names.push_back(header.grids[g].resource);
    grids_.push_back(g);
    in_world_.push_back(recording::squares_in_world(header.grids[g], header.radius));
  }
  for (const recording::Table& table : header.tables) tables_.names.push_back(table.name);
  for (Series* series : {&cells_, &deaths_, &resources_, &tables_})
    series->values.resize(series->names.size());
  // In mid-life there is a past already.
  deaths_before_.assign(deaths_.names.size(), 0);
  deaths_heard_.assign(deaths_.names.size(), 0);
  rows_heard_.assign(tables_.names.size(), 0);
}

double LifeHistory::content(std::size_t resource, const std::vector<double>& squares) const {
  double sum = 0;
  for (const std::uint32_t square : in_world_[resource]) sum += squares[square];
  return sum;
}

void LifeHistory::observe(const model::Simulation& simulation) {
  const model::WorldState& world = simulation.state();
  if (steps_.empty()) describe(recording::header_of(simulation.ecosystem(), world));
  const model::OrganismState& organism = own(simulation);
  steps_.push_back(static_cast<double>(world.step - 1));

  const std::vector<std::uint32_t> census = simulation.census(organism_);
  for (std::size_t s = 0; s < census.size(); ++s) cells_.values[s].push_back(census[s]);
  for (std::size_t c = 0; c < deaths_before_.size(); ++c) {
    deaths_.values[c].push_back(static_cast<double>(organism.deaths[c] - deaths_before_[c]));
    deaths_before_[c] = organism.deaths[c];
  }
  for (std::size_t r = 0; r < grids_.size(); ++r)
    resources_.values[r].push_back(content(r, world.grids[grids_[r]]));
  for (std::size_t t = 0; t < world.tables.size(); ++t)
    tables_.values[t].push_back(world.tables[t].rows());
  const Outcome& outcome = organism.outcome;
  divisions_.push_back(static_cast<double>(outcome.divisions - divisions_before_));
  specializations_.push_back(
      static_cast<double>(outcome.specializations - specializations_before_));
  divisions_before_ = outcome.divisions;
  specializations_before_ = outcome.specializations;
}

void LifeHistory::begin(const recording::Header& header) {
  organism_ = header.organisms[header.own].seat;
  describe(header);
}

void LifeHistory::event(const recording::Event& event) {
  if (event.organism != own_) return;
  if (event.kind == recording::EventKind::birth) ++births_heard_;
  if (event.kind == recording::EventKind::specialization) ++specializations_heard_;
  if (event.kind == recording::EventKind::death && event.cause != recording::none)
    ++deaths_heard_[event.cause];
}

void LifeHistory::summary(const recording::Summary& summary) {
  steps_.push_back(static_cast<double>(summary.step));
  for (std::size_t s = 0; s < cells_.values.size(); ++s)
    cells_.values[s].push_back(summary.population[first_slot_ + s]);
  for (std::size_t c = 0; c < deaths_heard_.size(); ++c)
    deaths_.values[c].push_back(std::exchange(deaths_heard_[c], 0));
  for (std::size_t r = 0; r < grids_.size(); ++r)
    resources_.values[r].push_back(summary.grid_totals[grids_[r]]);
  for (std::size_t t = 0; t < rows_heard_.size(); ++t) tables_.values[t].push_back(rows_heard_[t]);
  divisions_.push_back(std::exchange(births_heard_, 0));
  specializations_.push_back(std::exchange(specializations_heard_, 0));
}

void LifeHistory::frame(const recording::Frame& frame) {
  for (std::size_t t = 0; t < rows_heard_.size(); ++t) {
    const auto& columns = frame.tables[t].columns;
    rows_heard_[t] = columns.empty() ? 0 : static_cast<double>(columns.front().size());
    tables_.values[t].back() = rows_heard_[t];
  }
}

std::vector<double> LifeHistory::total() const {
  std::vector<double> sum(steps(), 0);
  for (const std::vector<double>& state : cells_.values)
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += state[i];
  return sum;
}

std::vector<double> LifeHistory::availability() const {
  std::vector<double> sum(steps(), 0);
  for (const std::vector<double>& resource : resources_.values)
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += resource[i];
  const double most = sum.empty() ? 0 : *std::max_element(sum.begin(), sum.end());
  for (double& content : sum) content = most > 0 ? content / most : 1;
  return sum;
}

std::vector<Phase> phases_of(const LifeHistory& history) {
  const std::vector<double> total = history.total();
  if (total.empty()) return {};
  const double peak = *std::max_element(total.begin(), total.end());
  const std::vector<double>& founders = history.cells().values.front();
  const std::size_t end = total.size();
  // The first index from which on it is always so.
  const auto for_good = [&](auto&& holds) {
    std::size_t i = end;
    while (i > 0 && holds(total[i - 1])) --i;
    return i;
  };
  std::size_t specialized = 0;
  while (specialized < end &&
         !(total[specialized] > 0 &&
           total[specialized] - founders[specialized] >= 0.05 * total[specialized]))
    ++specialized;
  const std::size_t decline = for_good([&](double cells) { return cells < 0.9 * peak; });
  const std::size_t remnant = for_good([&](double cells) { return cells <= 0.25 * peak; });

  struct Start {
    const char* name;
    std::size_t index;
  };
  std::vector<Start> starts{{"proliferation", 0}};
  if (specialized < decline) starts.push_back({"specialization", specialized});
  starts.push_back({"decline", decline});
  starts.push_back({"remnant", remnant});
  starts.push_back({"", end});
  std::vector<Phase> phases;
  for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
    const std::size_t first = starts[i].index, next = starts[i + 1].index;
    if (first == next) continue;
    const double last = history.step()[next - 1];
    if (!phases.empty() && 100 * (next - first) < end)
      phases.back().last = last;
    else
      phases.push_back({starts[i].name, history.step()[first], last});
  }
  return phases;
}

}  // namespace somas::report
