// Golden hashes: what short runs of the shipped experiments come to, to the last bit. They stand in
// goldens.txt, which only `./dev goldens --why TEXT` changes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "core/run/life_record.hpp"
#include "core/run/replay.hpp"
#include "core/run/runner.hpp"
#include "core/run/store.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas::test {

inline const std::filesystem::path experiments_dir = SOMAS_SOURCE_DIR "/experiments";
inline const std::filesystem::path goldens_file =
    SOMAS_SOURCE_DIR "/tests/plugins/experiments/goldens.txt";

/// The recorded champion of experiment 1: its whole life, and that in a world for a thousand cells.
inline const std::string champion_life = "champion_exp1.json";
inline const std::string champion_life_1000 = "champion_exp1.json,max_cells=1000";

/// What goldens.txt has a line for: every shipped experiment, and the lives of the champion.
inline std::vector<std::string> golden_names() {
  std::vector<std::string> names{champion_life, champion_life_1000};
  for (const auto& entry : std::filesystem::directory_iterator(experiments_dir))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

inline experiment::Experiment shipped_experiment(const std::string& file,
                                                 std::vector<std::string> overrides) {
  return experiment::load(experiments_dir / file,
                          {std::move(overrides), {SOMAS_BINARY_DIR "/plugins"}});
}

/// Of the world after every step.
inline std::string hash_of_life(const run::LifeRecord& life) {
  std::ostringstream text;
  for (const std::uint64_t hash : life.hashes) text << hash << ' ';
  return run::hash_of_text(text.str());
}

/// Every cell is worth a thread, so that worlds of any size are shared.
inline model::WorldThreads shared_by(unsigned threads) { return {threads, 1}; }

inline std::string golden_of_champion(const std::string& max_cells, unsigned world_threads) {
  const experiment::Experiment exp1 =
      shipped_experiment("exp1.yaml", {"world.max_cells=" + max_cells});
  const evolution::Heredity heredity(*exp1.ecosystem);
  const run::Champion champion = run::parse_champion(
      run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"), "champion", heredity);
  model::Team team(shared_by(world_threads));
  const evaluation::Task task = run::single_task(champion.individual.genome, champion.seed);
  const auto life = run::record_life(*exp1.ecosystem, task, 0, {}, {}, nullptr, &team).value();
  return "life=" + hash_of_life(life);
}

/// All individuals with their fitness, the genomes of the last generation, and every step of its
/// champion's life.
inline std::string golden_of_run(const std::string& file, unsigned threads,
                                 unsigned world_threads) {
  const experiment::Experiment experiment = shipped_experiment(
      file, {"evolution.population=24", "evolution.generations=3", "world.max_steps=500"});
  const Scratch scratch;
  const std::filesystem::path directory = scratch.path() / "run";
  run::Terminal terminal(stderr);
  run::RunOptions options;
  options.out = directory;
  const auto backend = evaluation::thread_backend(threads, nullptr, shared_by(world_threads));
  options.backend = backend.get();
  options.quiet = true;
  if (run::run(experiment, options, terminal, {}).generations != 3)
    throw std::runtime_error(file + ": the run did not end");

  std::string results = run::read_file(directory / "individuals.csv");
  const run::Store store(directory / run::store_name, run::Database::Access::read);
  for (const evolution::Population& population : store.populations(2))
    for (const evolution::Individual& individual : population)
      for (const auto* genes : {&individual.genome.controller, &individual.genome.tree})
        results.append(reinterpret_cast<const char*>(genes->data()), genes->size());

  run::ReplayOptions replay;
  replay.run = directory;
  replay.plugin_directories = {SOMAS_BINARY_DIR "/plugins"};
  const run::ReplayReport champion = run::replay(replay);
  if (!champion.matches()) throw std::runtime_error(file + ": the replay differs from the record");
  model::Team team(shared_by(world_threads));
  const auto life = run::record_life(*experiment.ecosystem, run::task_of(champion.recorded),
                                     champion.recorded.own_seat, {}, {}, nullptr, &team);
  return "results=" + run::hash_of_text(results) + " life=" + hash_of_life(life.value());
}

/// `threads` simulate, and so many share each world.
inline std::string golden_of(const std::string& name, unsigned threads,
                             unsigned world_threads = 1) {
  if (name == champion_life) return golden_of_champion("250", world_threads);
  if (name == champion_life_1000) return golden_of_champion("1000", world_threads);
  return golden_of_run(name, threads, world_threads);
}

/// Lines "NAME HASHES"; "#" begins a comment.
inline std::map<std::string, std::string> read_goldens(const std::string& text) {
  std::map<std::string, std::string> goldens;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t space = line.find(' ');
    if (line.starts_with('#') || space == std::string::npos) continue;
    goldens[line.substr(0, space)] = line.substr(space + 1);
  }
  return goldens;
}

}  // namespace somas::test
