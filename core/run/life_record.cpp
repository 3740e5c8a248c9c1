#include "core/run/life_record.hpp"

#include <algorithm>

#include "core/evaluation/simulate.hpp"
#include "core/run/csv.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

bool same_step(const LifeRecord& a, const LifeRecord& b, std::size_t step) {
  if (a.hashes[step] != b.hashes[step] || a.census.size() != b.census.size()) return false;
  for (std::size_t state = 0; state < a.census.size(); ++state)
    if (a.census[state][step] != b.census[state][step]) return false;
  return true;
}

}  // namespace

LifeRecord begin_life_record(const model::Tree& tree) {
  LifeRecord life;
  for (const model::State& state : tree.states) life.states.push_back(state.name);
  life.census.resize(life.states.size());
  return life;
}

void observe_step(const model::Simulation& simulation, std::size_t own, LifeRecord& life) {
  life.hashes.push_back(simulation.hash());
  const std::vector<std::uint32_t> cells = simulation.census(own);
  for (std::size_t state = 0; state < life.census.size(); ++state)
    life.census[state].push_back(cells[state]);
}

evaluation::Task single_task(const model::Genome& genome, std::uint64_t seed) {
  return {.roster = {{.genome = &genome, .key = 1, .x = 0, .y = 0}}, .seed = seed};
}

std::optional<LifeRecord> record_life(const model::Ecosystem& ecosystem,
                                      const model::Genome& genome, std::uint64_t seed,
                                      evaluation::StopToken stop, const Observer& observer) {
  return record_life(ecosystem, single_task(genome, seed), 0, stop, observer);
}

std::optional<LifeRecord> record_life(const model::Ecosystem& ecosystem,
                                      const evaluation::Task& task, std::size_t own,
                                      evaluation::StopToken stop, const Observer& observer,
                                      recording::LifeWitness* witness, model::Team* team) {
  LifeRecord life = begin_life_record(*ecosystem.grow(task.roster[own].genome->tree));
  const auto watch = [&](const model::Simulation& simulation) {
    observe_step(simulation, own, life);
    if (observer) observer(simulation);
    if (witness != nullptr) witness->observe(simulation);
  };
  const auto result = evaluation::simulate(ecosystem, task, stop, watch, witness, nullptr, team);
  if (!result) return std::nullopt;
  if (witness != nullptr) witness->finish(*result);
  life.outcome = result->rows[own].outcome;
  life.score = result->rows[own].score;
  return life;
}

std::optional<std::uint64_t> first_difference(const LifeRecord& a, const LifeRecord& b) {
  const std::size_t common = std::min(a.hashes.size(), b.hashes.size());
  for (std::size_t step = 0; step < common; ++step)
    if (!same_step(a, b, step)) return a.first_step + step;
  if (a.hashes.size() != b.hashes.size()) return a.first_step + common;
  return std::nullopt;
}

std::string to_csv(const LifeRecord& life) {
  CsvLine header;
  header.add("step");
  for (const std::string& state : life.states) header.add(state);
  header.add("cells").add("hash");
  std::string text = header.take();

  for (std::size_t step = 0; step < life.hashes.size(); ++step) {
    CsvLine line;
    line.add(life.first_step + step);
    std::uint64_t cells = 0;
    for (const std::vector<std::uint32_t>& counts : life.census) {
      line.add(counts[step]);
      cells += counts[step];
    }
    text += line.add(cells).add(hex64(life.hashes[step])).take();
  }
  return text;
}

}  // namespace somas::run
