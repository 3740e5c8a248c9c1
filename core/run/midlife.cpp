#include "core/run/midlife.hpp"

#include <string>
#include <utility>

#include "core/evaluation/simulate.hpp"
#include "core/model/snapshot.hpp"
#include "core/run/state_file.hpp"

namespace somas::run {
namespace {

std::vector<std::unique_ptr<const model::Phenotype>> express(const model::Ecosystem& ecosystem,
                                                             const evaluation::Task& task) {
  std::vector<std::unique_ptr<const model::Phenotype>> phenotypes;
  for (const evaluation::Organism& organism : task.roster)
    phenotypes.push_back(
        std::make_unique<const model::Phenotype>(ecosystem.express(*organism.genome)));
  return phenotypes;
}

Life live_from_birth(const model::Ecosystem& ecosystem, const Champion& champion) {
  const evaluation::Task task = task_of(champion);
  Life life{.phenotypes = express(ecosystem, task), .simulation = nullptr};
  std::vector<model::RosterEntry> roster;
  for (std::size_t s = 0; s < task.roster.size(); ++s)
    roster.push_back(
        {life.phenotypes[s].get(), task.roster[s].key, task.roster[s].x, task.roster[s].y});
  life.simulation = std::make_unique<model::Simulation>(ecosystem, roster, task.seed);
  return life;
}

Life live_from_file(const std::filesystem::path& file, const Champion& champion,
                    const model::Ecosystem& ecosystem) {
  const SavedState state = read_state(file);
  check_owner(state, champion, file.string());
  try {
    Life life = live_from(ecosystem, champion, state.world);
    if (life.simulation->steps_done() != state.step || life.simulation->hash() != state.world_hash)
      throw UsageError(file.string() + ": its first line tells of another world than it holds");
    return life;
  } catch (const model::SnapshotError& error) {
    throw UsageError(file.string() + ": " + error.what());
  }
}

}  // namespace

Life live_from(const model::Ecosystem& ecosystem, const Champion& champion,
               std::span<const std::byte> world) {
  Life life{.phenotypes = express(ecosystem, task_of(champion)), .simulation = nullptr};
  std::vector<const model::Phenotype*> roster;
  for (const auto& phenotype : life.phenotypes) roster.push_back(phenotype.get());
  life.simulation = std::make_unique<model::Simulation>(ecosystem, roster, world);
  return life;
}

std::optional<Moment> moment_before(std::uint64_t step, const std::filesystem::path& run,
                                    const Champion& champion, const model::Ecosystem& ecosystem,
                                    model::Team* team) {
  const std::vector<std::uint64_t>& hashes = champion.life.hashes;
  if (step >= hashes.size())
    throw UsageError("step " + std::to_string(step) +
                     " is beyond the recorded life, of steps 0 to " +
                     std::to_string(hashes.empty() ? 0 : hashes.size() - 1));
  Moment moment{.step = step,
                .file = latest_state(run, champion.generation, champion.population, step),
                .world = {}};
  const Life life = moment.file ? live_from_file(*moment.file, champion, ecosystem)
                                : live_from_birth(ecosystem, champion);
  model::Simulation& world = *life.simulation;
  world.use(team);
  while (world.steps_done() < step && !world.finished()) world.step();
  if (world.finished() || (step > 0 && world.hash() != hashes[step - 1])) return std::nullopt;
  moment.world = model::save(world);
  return moment;
}

Moment moment_in(const std::filesystem::path& file, const Champion& champion,
                 const model::Ecosystem& ecosystem) {
  const Life life = live_from_file(file, champion, ecosystem);
  return {
      .step = life.simulation->steps_done(), .file = file, .world = model::save(*life.simulation)};
}

LifeRecord record_rest(Life& life, std::size_t own, const Observer& observer,
                       recording::LifeWitness* witness) {
  LifeRecord record = begin_life_record(*life.phenotypes[own]->tree);
  record.first_step = life.simulation->steps_done();
  const auto result =
      evaluation::complete(*life.simulation, {}, [&](const model::Simulation& simulation) {
        observe_step(simulation, own, record);
        if (observer) observer(simulation);
        if (witness != nullptr) witness->observe(simulation);
      });
  if (witness != nullptr) witness->finish(*result);
  record.outcome = result->rows[own].outcome;
  record.score = result->rows[own].score;
  return record;
}

LifeRecord rest_of(const LifeRecord& record, std::uint64_t step) {
  LifeRecord rest = record;
  const auto cut = [&](auto& values) {
    values.erase(values.begin(),
                 values.begin() + static_cast<std::ptrdiff_t>(step - record.first_step));
  };
  rest.first_step = step;
  cut(rest.hashes);
  for (auto& counts : rest.census) cut(counts);
  return rest;
}

}  // namespace somas::run
