#include "core/evaluation/simulate.hpp"

#include <charconv>
#include <cmath>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "core/model/call_site.hpp"

namespace somas::evaluation {
namespace {

// A score is the fitness plugin's word; one that cannot be ranked is its failure.
double score_of(const Fitness& fitness, const Outcome& outcome) {
  double score = 0;
  try {
    const model::PluginCall here("fitness", "score");
    score = fitness.score(outcome);
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
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
    model::note_progress();
    const std::uint64_t before = simulation.steps_done();
    more = simulation.step();
    if (observe && simulation.steps_done() != before) observe(simulation);
  }
  return true;
}

double cell_steps_of(const model::Simulation& simulation) {
  double sum = 0;
  for (const Outcome& outcome : simulation.outcomes()) sum += outcome.cell_steps;
  return sum;
}

Result failed(const Task& task, Failure failure) {
  Result result;
  result.rows.resize(task.roster.size());
  failure.attempts = 1;
  result.failure = std::move(failure);
  return result;
}

// The call of a failure ends in " at step N" within a simulation.
Failure failure_of(const model::PluginFailure& error) {
  constexpr std::string_view before_step = " at step ";
  std::string_view what = error.what();
  const std::string prefix = error.instance() + ": " + error.call() + ": ";
  if (what.starts_with(prefix)) what.remove_prefix(prefix.size());

  Failure failure{.cause = std::string(what), .plugin = error.instance(), .step = {}};
  std::string_view call = error.call();
  const std::size_t place = call.rfind(before_step);
  std::uint64_t step = 0;
  if (place != std::string_view::npos) {
    const std::string_view digits = call.substr(place + before_step.size());
    if (std::from_chars(digits.data(), digits.data() + digits.size(), step).ec == std::errc{})
      failure.step = step;
    call = call.substr(0, place);
  }
  failure.plugin += ": " + std::string(call);
  return failure;
}

}  // namespace

std::optional<Result> attempt(const model::Ecosystem& ecosystem, const Task& task, StopToken stop,
                              model::Profile* profile, model::Team* team) {
  try {
    return simulate(ecosystem, task, stop, {}, nullptr, profile, team);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const model::PluginFailure& error) {
    return failed(task, failure_of(error));
  } catch (const std::exception& error) {
    // A tree that evolved into one that cannot be, for example.
    return failed(task, {.cause = error.what(), .plugin = {}, .step = {}});
  }
}

std::optional<Result> simulate(const model::Ecosystem& ecosystem, const Task& task, StopToken stop,
                               const StepObserver& observe, model::Witness* witness,
                               model::Profile* profile, model::Team* team) {
  std::vector<model::Phenotype> phenotypes;
  phenotypes.reserve(task.roster.size());
  std::vector<model::RosterEntry> roster;
  for (const Organism& organism : task.roster) {
    phenotypes.push_back(ecosystem.express(*organism.genome));
    roster.push_back({&phenotypes.back(), organism.key, organism.x, organism.y});
  }

  model::Simulation simulation(ecosystem, roster, task.seed);
  simulation.tell(witness);
  simulation.measure(profile);
  simulation.use(team);
  const model::Stopwatch watch(profile, [&](model::Profile& of, model::Profile::Duration time) {
    of.add_life(time, simulation.steps_done(), cell_steps_of(simulation));
  });
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
