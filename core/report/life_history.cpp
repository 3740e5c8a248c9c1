#include "core/report/life_history.hpp"

#include <algorithm>
#include <numeric>

namespace somas::report {

const model::OrganismState& LifeHistory::own(const model::Simulation& simulation) const {
  const std::vector<model::OrganismState>& organisms = simulation.state().organisms;
  return *std::find_if(organisms.begin(), organisms.end(),
                       [&](const auto& one) { return one.roster_index == organism_; });
}

void LifeHistory::describe(const model::Simulation& simulation) {
  const model::Schema& schema = simulation.ecosystem().schema();
  for (const model::State& state : own(simulation).phenotype->tree->states)
    cells_.names.push_back(state.name);
  deaths_.names = schema.causes;
  for (const model::Resource& resource : schema.resources)
    resources_.names.push_back(resource.name);
  for (const model::TableDeclaration& table : schema.tables)
    tables_.names.push_back(table.owner + "." + table.name);
  for (Series* series : {&cells_, &deaths_, &resources_, &tables_})
    series->values.resize(series->names.size());
  // In mid-life there is a past already.
  deaths_before_.assign(deaths_.names.size(), 0);
}

void LifeHistory::observe(const model::Simulation& simulation) {
  if (steps_.empty()) describe(simulation);
  const model::WorldState& world = simulation.state();
  const model::OrganismState& organism = own(simulation);
  steps_.push_back(static_cast<double>(world.step - 1));

  const std::vector<std::uint32_t> census = simulation.census(organism_);
  for (std::size_t s = 0; s < census.size(); ++s) cells_.values[s].push_back(census[s]);
  for (std::size_t c = 0; c < deaths_before_.size(); ++c) {
    deaths_.values[c].push_back(static_cast<double>(organism.deaths[c] - deaths_before_[c]));
    deaths_before_[c] = organism.deaths[c];
  }
  const model::Schema& schema = simulation.ecosystem().schema();
  for (std::size_t r = 0; r < schema.resources.size(); ++r) {
    const std::vector<double>& content = world.grids[schema.resources[r].grid];
    resources_.values[r].push_back(std::accumulate(content.begin(), content.end(), 0.0));
  }
  for (std::size_t t = 0; t < world.tables.size(); ++t)
    tables_.values[t].push_back(world.tables[t].rows());
  const Outcome& outcome = organism.outcome;
  divisions_.push_back(static_cast<double>(outcome.divisions - divisions_before_));
  specializations_.push_back(
      static_cast<double>(outcome.specializations - specializations_before_));
  divisions_before_ = outcome.divisions;
  specializations_before_ = outcome.specializations;
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
