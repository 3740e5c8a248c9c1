#include "core/evaluation/simulate.hpp"

#include <cmath>
#include <exception>
#include <string>

namespace somas::evaluation {
namespace {

// A score is the fitness plugin's word; one that cannot be ranked is its failure.
double score_of(const Fitness& fitness, const Outcome& outcome) {
  double score = 0;
  try {
    score = fitness.score(outcome);
  } catch (const std::exception& error) {
    throw model::PluginFailure("fitness", "score", error.what());
  } catch (...) {
    throw model::PluginFailure("fitness", "score", "an exception that is no std::exception");
  }
  if (!std::isfinite(score))
    throw model::PluginFailure("fitness", "score",
                               "\"" + std::string(fitness.objective()) + "\" is " +
                                   (std::isnan(score) ? "not a number" : "infinite"));
  return score;
}

// Runs to the end; false if stopped early.
bool run(model::Simulation& simulation, StopToken stop, const StepObserver& observe) {
  bool more = true;
  while (more) {
    if (stop.stop_requested()) return false;
    const std::uint64_t before = simulation.steps_done();
    more = simulation.step();
    if (observe && simulation.steps_done() != before) observe(simulation);
  }
  return true;
}

}  // namespace

std::optional<Result> simulate(const model::Ecosystem& ecosystem, const Task& task, StopToken stop,
                               const StepObserver& observe, model::Witness* witness) {
  std::vector<model::Phenotype> phenotypes;
  phenotypes.reserve(task.roster.size());
  std::vector<model::RosterEntry> roster;
  for (const Organism& organism : task.roster) {
    phenotypes.push_back(ecosystem.express(*organism.genome));
    roster.push_back({&phenotypes.back(), organism.key, organism.x, organism.y});
  }

  model::Simulation simulation(ecosystem, roster, task.seed);
  simulation.tell(witness);
  return complete(simulation, stop, observe);
}

std::optional<Result> complete(model::Simulation& simulation, StopToken stop,
                               const StepObserver& observe) {
  if (!run(simulation, stop, observe)) return std::nullopt;
  const Fitness& fitness = simulation.ecosystem().fitness();
  Result result;
  for (const Outcome& outcome : simulation.outcomes())
    result.rows.push_back({outcome, score_of(fitness, outcome)});
  return result;
}

}  // namespace somas::evaluation
