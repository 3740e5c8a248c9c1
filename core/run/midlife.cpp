#include "core/run/midlife.hpp"

#include <array>
#include <string>
#include <utility>

#include "core/evaluation/simulate.hpp"
#include "core/model/snapshot.hpp"
#include "core/run/state_file.hpp"

namespace somas::run {
namespace {

Life live_from_birth(const model::Ecosystem& ecosystem, const Champion& champion) {
  const evaluation::Task task = single_task(champion.individual.genome, champion.seed);
  Life life;
  life.phenotype =
      std::make_unique<const model::Phenotype>(ecosystem.express(champion.individual.genome));
  const evaluation::Organism& founder = task.roster.front();
  const model::RosterEntry entry{life.phenotype.get(), founder.key, founder.x, founder.y};
  life.simulation = std::make_unique<model::Simulation>(ecosystem, std::span(&entry, 1), task.seed);
  return life;
}

Life live_from_file(const std::filesystem::path& file, const Champion& champion,
                    const model::Ecosystem& ecosystem) {
  const SavedState state = read_state(file);
  check_owner(state, champion, file.string());
  try {
    Life life = live_from(ecosystem, champion.individual.genome, state.world);
    if (life.simulation->steps_done() != state.step || life.simulation->hash() != state.world_hash)
      throw UsageError(file.string() + ": its first line tells of another world than it holds");
    return life;
  } catch (const model::SnapshotError& error) {
    throw UsageError(file.string() + ": " + error.what());
  }
}

}  // namespace

Life live_from(const model::Ecosystem& ecosystem, const model::Genome& genome,
               std::span<const std::byte> world) {
  Life life;
  life.phenotype = std::make_unique<const model::Phenotype>(ecosystem.express(genome));
  const std::array<const model::Phenotype*, 1> roster{life.phenotype.get()};
  life.simulation = std::make_unique<model::Simulation>(ecosystem, roster, world);
  return life;
}

std::optional<Moment> moment_before(std::uint64_t step, const std::filesystem::path& run,
                                    const Champion& champion, const model::Ecosystem& ecosystem) {
  const std::vector<std::uint64_t>& hashes = champion.recording.hashes;
  if (step >= hashes.size())
    throw UsageError("step " + std::to_string(step) +
                     " is beyond the recorded life, of steps 0 to " +
                     std::to_string(hashes.empty() ? 0 : hashes.size() - 1));
  Moment moment{.step = step, .file = latest_state(run, champion.generation, step), .world = {}};
  const Life life = moment.file ? live_from_file(*moment.file, champion, ecosystem)
                                : live_from_birth(ecosystem, champion);
  model::Simulation& world = *life.simulation;
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

Recording record_rest(model::Simulation& life, const Observer& observer) {
  Recording recording = begin_recording(*life.state().organisms.front().phenotype->tree);
  recording.first_step = life.steps_done();
  const auto result = evaluation::complete(life, {}, [&](const model::Simulation& simulation) {
    observe_step(simulation, recording);
    if (observer) observer(simulation);
  });
  recording.outcome = result->rows.front().outcome;
  recording.score = result->rows.front().score;
  return recording;
}

Recording rest_of(const Recording& recording, std::uint64_t step) {
  Recording rest = recording;
  const auto cut = [&](auto& values) {
    values.erase(values.begin(),
                 values.begin() + static_cast<std::ptrdiff_t>(step - recording.first_step));
  };
  rest.first_step = step;
  cut(rest.hashes);
  for (auto& counts : rest.census) cut(counts);
  return rest;
}

}  // namespace somas::run
