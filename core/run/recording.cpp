#include "core/run/recording.hpp"

#include <algorithm>

#include "core/evaluation/simulate.hpp"
#include "core/run/csv.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

bool same_step(const Recording& a, const Recording& b, std::size_t step) {
  if (a.hashes[step] != b.hashes[step] || a.census.size() != b.census.size()) return false;
  for (std::size_t state = 0; state < a.census.size(); ++state)
    if (a.census[state][step] != b.census[state][step]) return false;
  return true;
}

}  // namespace

Recording begin_recording(const model::Tree& tree) {
  Recording recording;
  for (const model::State& state : tree.states) recording.states.push_back(state.name);
  recording.census.resize(recording.states.size());
  return recording;
}

void observe_step(const model::Simulation& simulation, std::size_t own, Recording& recording) {
  recording.hashes.push_back(simulation.hash());
  const std::vector<std::uint32_t> cells = simulation.census(own);
  for (std::size_t state = 0; state < recording.census.size(); ++state)
    recording.census[state].push_back(cells[state]);
}

evaluation::Task single_task(const model::Genome& genome, std::uint64_t seed) {
  return {.roster = {{.genome = &genome, .key = 1, .x = 0, .y = 0}}, .seed = seed};
}

std::optional<Recording> record(const model::Ecosystem& ecosystem, const model::Genome& genome,
                                std::uint64_t seed, evaluation::StopToken stop,
                                const Observer& observer) {
  return record(ecosystem, single_task(genome, seed), 0, stop, observer);
}

std::optional<Recording> record(const model::Ecosystem& ecosystem, const evaluation::Task& task,
                                std::size_t own, evaluation::StopToken stop,
                                const Observer& observer) {
  Recording recording = begin_recording(*ecosystem.grow(task.roster[own].genome->tree));
  const auto watch = [&](const model::Simulation& simulation) {
    observe_step(simulation, own, recording);
    if (observer) observer(simulation);
  };
  const auto result = evaluation::simulate(ecosystem, task, stop, watch);
  if (!result) return std::nullopt;
  recording.outcome = result->rows[own].outcome;
  recording.score = result->rows[own].score;
  return recording;
}

std::optional<std::uint64_t> first_difference(const Recording& a, const Recording& b) {
  const std::size_t common = std::min(a.hashes.size(), b.hashes.size());
  for (std::size_t step = 0; step < common; ++step)
    if (!same_step(a, b, step)) return a.first_step + step;
  if (a.hashes.size() != b.hashes.size()) return a.first_step + common;
  return std::nullopt;
}

std::string to_csv(const Recording& recording) {
  CsvLine header;
  header.add("step");
  for (const std::string& state : recording.states) header.add(state);
  header.add("cells").add("hash");
  std::string text = header.take();

  for (std::size_t step = 0; step < recording.hashes.size(); ++step) {
    CsvLine line;
    line.add(recording.first_step + step);
    std::uint64_t cells = 0;
    for (const std::vector<std::uint32_t>& counts : recording.census) {
      line.add(counts[step]);
      cells += counts[step];
    }
    text += line.add(cells).add(hex64(recording.hashes[step])).take();
  }
  return text;
}

}  // namespace somas::run
