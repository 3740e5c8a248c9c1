#include "core/run/coordinator.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/evolution/reproduction.hpp"
#include "core/run/phase.hpp"

namespace somas::run {

using Clock = std::chrono::steady_clock;

Coordinator::Coordinator(const Parts& parts, std::vector<model::Genome> given)
    : experiment_(parts.experiment),
      settings_(experiment_.evolution),
      heredity_(*experiment_.ecosystem),
      evaluator_(parts.evaluator),
      workers_(parts.workers),
      directory_(parts.directory),
      watcher_(parts.watcher),
      stop_(parts.stop),
      given_(std::move(given)),
      journal_(directory_.store().database(), key_of(experiment_)),
      recordings_(experiment_, heredity_, directory_.path(), parts.world_threads) {
  // Where the run stands.
  const Store& store = directory_.store();
  report_.directory = directory_.path();
  report_.planned = settings_.generations;
  report_.generations = store.generations();
  if (report_.generations == 0) return;
  populations_ = store.populations(report_.generations - 1);
  if (settings_.mode == evolution::Mode::hall_of_fame) former_ = store.champions();
  const Store::Best best = store.best().value();
  report_.best = best.fitness;
  report_.best_generation = best.generation;
}

RunReport Coordinator::all_generations() {
  try {
    directory_.store().note_session(workers_);
    summarize("running");
    while (report_.generations < settings_.generations) {
      if (!generation(report_.generations)) {
        report_.stopped = true;
        break;
      }
      if (report_.generations < settings_.generations) summarize("running");
    }
    summarize(report_.stopped ? "stopped" : "complete");
    directory_.close();
  } catch (...) {
    // A disk that is full may have room for this; the first failure is the one to tell.
    try {
      summarize("failed");
    } catch (const WriteError&) {
    }
    throw;
  }
  return report_;
}

/// False if stopped; then of this generation there are single evaluations on the disk only.
bool Coordinator::generation(std::uint64_t number) {
  const Clock::time_point begun = Clock::now();
  if (watcher_ != nullptr) watcher_->begin_generation(number);
  enter_phase("select");
  reproduce(number);
  enter_phase("evaluate");
  const auto evaluated = evaluate(number);
  if (!evaluated) return false;

  std::vector<Generation> records(populations_.size());
  for (std::size_t p = 0; p < populations_.size(); ++p) {
    records[p].number = number;
    records[p].population = &populations_[p];
    absorb(*evaluated, p, records[p]);
    if (!record_champion(*evaluated, p, records[p]) || !record_all(number, p)) return false;
  }

  enter_phase("commit");
  const std::chrono::duration<double> seconds = Clock::now() - begun;
  directory_.commit(records, heredity_, {seconds.count(), workers_});
  note(records);
  return true;
}

void Coordinator::reproduce(std::uint64_t number) {
  try {
    populations_.resize(evolution::population_count(settings_));
    for (std::uint32_t p = 0; p < populations_.size(); ++p) {
      const std::uint64_t seed = evolution::population_seed(experiment_.seed, p);
      const auto given =
          p == 0 ? std::span<const model::Genome>(given_) : std::span<const model::Genome>();
      populations_[p] = number == 0
                            ? evolution::initial(settings_, heredity_, seed, given)
                            : evolution::next(settings_, heredity_, populations_[p], seed, number);
    }
    contest_.emplace(settings_, heredity_, experiment_.seed, number, populations_, former_);
  } catch (const model::PluginFailure& failure) {
    throw PluginError("generation " + std::to_string(number) + ": " + failure.what());
  }
}

std::optional<Journal::Evaluated> Coordinator::evaluate(std::uint64_t number) {
  const std::vector<evaluation::Task> tasks = contest_->tasks();
  auto evaluated = journal_.evaluate(tasks, number, evaluator_, stop_, [this](std::size_t done) {
    note_reference();
    if (watcher_ != nullptr) watcher_->update(done);
  });
  if (evaluated) refuse_if_all_failed(number, evaluated->results);
  return evaluated;
}

/// As soon as it is known: whoever resumes the run has to compute the same bits.
void Coordinator::note_reference() {
  if (reference_noted_) return;
  const auto reference = evaluator_.reference();
  if (!reference) return;
  directory_.store().note_reference(*reference);
  reference_noted_ = true;
}

/// Without a life that went well there is nothing to select.
void Coordinator::refuse_if_all_failed(std::uint64_t number,
                                       const std::vector<evaluation::Result>& results) {
  const auto failed = [](const evaluation::Result& result) { return result.failure.has_value(); };
  if (std::all_of(results.begin(), results.end(), failed)) fail(number, 0, *results[0].failure);
}

/// Keeps the genomes that brought a plugin down, so that its author can try again.
void Coordinator::fail(std::uint64_t number, std::size_t task, const evaluation::Failure& failure) {
  const std::string step = failure.step ? " at step " + std::to_string(*failure.step) : "";
  const std::string what =
      failure.plugin.empty() ? failure.cause : failure.plugin + step + ": " + failure.cause;
  const std::filesystem::path file = directory_.path() / "failed-genome.json";
  const evolution::Match& match = contest_->matches()[task];
  Json json;
  json["generation"] = number;
  std::string who;
  if (match.seats.size() == 1) {
    const evolution::Individual& individual = populations_[0][match.seats[0].index];
    who = "individual " + std::to_string(individual.id);
    json["id"] = individual.id;
    json["seed"] = hex64(match.seed);
    json["error"] = what;
    json["genome"] = genome_to_json(individual.genome, heredity_, owners_of(experiment_));
  } else {
    who = "simulation " + std::to_string(task);
    json["seed"] = hex64(match.seed);
    json["error"] = what;
    json["roster"] = roster_to_json(contest_->roster(task), heredity_, owners_of(experiment_));
  }
  write_file(file, to_text(json));
  throw PluginError("generation " + std::to_string(number) + ", " + who + ": " + what +
                    "; so failed all simulations of the generation (genome saved in " +
                    file.string() + ")");
}

void Coordinator::absorb(const Journal::Evaluated& evaluated, std::size_t population,
                         Generation& record) {
  evolution::Population& members = populations_[population];
  record.evaluations = evaluated.results.size();
  for (std::size_t i = 0; i < members.size(); ++i) {
    std::vector<double> trials;
    members[i].cost = 0;
    for (std::uint32_t trial = 0; trial < settings_.trials; ++trial) {
      const Contest::Part part = contest_->part(population, i, trial);
      const evaluation::Row& row = evaluated.results[part.match].rows[part.seat];
      trials.push_back(row.score);
      record.places.push_back({evaluated.keys[part.match], part.seat});
      if (evaluated.results[part.match].failure) members[i].set_aside = true;
      record.censored += row.outcome.censored ? 1 : 0;
      record.refused_divisions += row.outcome.refused_divisions;
      record.cell_steps += row.outcome.cell_steps;
      members[i].cost += row.outcome.cell_steps;
    }
    evolution::assign_fitness(members[i], std::move(trials));
    if (settings_.mode != evolution::Mode::solo)
      record.opponents.push_back(contest_->opponents(population, i));
  }
  evolution::assign_worst_fitness(members);
  record.statistics = evolution::statistics(members);
}

/// Simulates the best of a population once more, step by step. False if stopped.
bool Coordinator::record_champion(const Journal::Evaluated& evaluated, std::size_t population,
                                  Generation& record) {
  const std::size_t best = evolution::rank(populations_[population]).front();
  const Contest::Part part = contest_->part(population, best, 0);
  const evaluation::Row& expected = evaluated.results[part.match].rows[part.seat];
  Champion& champion = record.champion;
  champion = first_trial_of(record.number, population, best);
  auto life = recordings_.champion(champion, stop_);
  if (!life) return false;
  if (life->outcome.survival != expected.outcome.survival || life->score != expected.score)
    throw std::runtime_error(
        "generation " + std::to_string(record.number) + ", individual " +
        std::to_string(champion.individual.id) + ": survived " +
        std::to_string(expected.outcome.survival) + " steps when evaluated and " +
        std::to_string(life->outcome.survival) +
        " when simulated again with the same seed; does a plugin keep state of its own?");
  champion.life = std::move(*life);
  return true;
}

/// An individual in the world of its first trial, before it lives.
Champion Coordinator::first_trial_of(std::uint64_t number, std::size_t population,
                                     std::size_t index) const {
  const Contest::Part part = contest_->part(population, index, 0);
  Champion who;
  who.experiment = experiment_.name;
  who.generation = number;
  if (populations_.size() > 1) who.population = static_cast<std::uint32_t>(population) + 1;
  who.individual = populations_[population][index];
  who.seed = contest_->matches()[part.match].seed;
  who.roster = contest_->roster(part.match);
  who.own_seat = part.seat;
  return who;
}

/// Everybody's recording, if the experiment wants it. False if stopped.
bool Coordinator::record_all(std::uint64_t number, std::size_t population) {
  if (!recordings_.of_all()) return true;
  for (std::size_t i = 0; i < populations_[population].size(); ++i)
    if (!recordings_.individual(first_trial_of(number, population, i), stop_)) return false;
  return true;
}

void Coordinator::note(const std::vector<Generation>& records) {
  bool first = report_.generations == 0;
  for (const Generation& record : records) {
    if (!first && record.statistics.best <= report_.best) continue;
    report_.best = record.statistics.best;
    report_.best_generation = record.number;
    first = false;
  }
  report_.generations = records.front().number + 1;
  if (settings_.mode == evolution::Mode::hall_of_fame) {
    const evolution::Individual& champion = records.front().champion.individual;
    former_.push_back({champion.id, champion.genome});
  }
  if (watcher_ != nullptr) watcher_->end_generation(records.front().statistics);
}

void Coordinator::summarize(const char* status) {
  Json json;
  json["status"] = status;
  json["generations"] = report_.generations;
  json["planned_generations"] = settings_.generations;
  if (report_.generations > 0) {
    json["best"] = report_.best;
    json["best_generation"] = report_.best_generation;
  }
  directory_.summarize(json);
}

}  // namespace somas::run
