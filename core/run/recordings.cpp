#include "core/run/recordings.hpp"

#include <string_view>
#include <system_error>
#include <vector>

#include "core/recording/file.hpp"
#include "core/run/build_info.hpp"
#include "core/run/files.hpp"
#include "core/run/run_directory.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

/// "gen-0003", as champions' files are named.
std::string stem_of(std::uint64_t generation, std::uint32_t population) {
  return champion_path({}, generation, population).stem().string();
}

fs::path recordings_in(const fs::path& run) { return run / "recordings"; }

void write(const fs::path& file, const recording::FileWriter& writer) {
  std::error_code error;
  fs::create_directory(file.parent_path(), error);
  if (error) throw WriteError(file.parent_path(), error.value());
  const std::vector<std::byte> bytes = writer.bytes();
  write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

fs::path recording_path(const fs::path& run, std::uint64_t generation, std::uint32_t population) {
  return recordings_in(run) / (stem_of(generation, population) + ".h5");
}

fs::path individual_recording_path(const fs::path& run, std::uint64_t generation,
                                   std::uint32_t population, std::uint64_t id) {
  return recordings_in(run) /
         (stem_of(generation, population) + "-id-" + std::to_string(id) + ".h5");
}

recording::RecorderOptions recorder_options(const experiment::RecordSettings& settings) {
  return {.every = settings.every,
          .fields_every = settings.fields_every == 0 ? settings.every : settings.fields_every,
          .controller = settings.controller};
}

recording::Provenance provenance_of(const Champion& champion, const evolution::Heredity& heredity,
                                    const experiment::Experiment& experiment, const fs::path& run) {
  const evolution::Individual& individual = champion.individual;
  const fs::path directory = fs::absolute(run / "").lexically_normal().parent_path();
  return {
      .experiment = champion.experiment,
      .run = directory.filename().string(),
      .version = std::string(build_info().version),
      .resolved_yaml = experiment.resolved_yaml,
      .generation = champion.generation,
      .population = champion.population,
      .individual = individual.id,
      .origin = std::string(evolution::name_of(individual.origin)),
      .parents = individual.parents,
      .fitness = individual.fitness,
      .genome_json = to_text(genome_to_json(individual.genome, heredity, owners_of(experiment))),
      .controller_genes = individual.genome.controller,
      .tree_genes = individual.genome.tree};
}

std::optional<LifeRecord> Recordings::champion(const Champion& champion,
                                               evaluation::StopToken stop) {
  if (experiment_.record.what == experiment::Recorded::none)
    return record_life(*experiment_.ecosystem, task_of(champion), champion.own_seat, stop, {},
                       nullptr, &team_);
  return live(champion, recording_path(run_, champion.generation, champion.population), stop);
}

bool Recordings::individual(const Champion& individual, evaluation::StopToken stop) {
  const fs::path file = individual_recording_path(run_, individual.generation,
                                                  individual.population, individual.individual.id);
  return live(individual, file, stop).has_value();
}

std::optional<LifeRecord> Recordings::live(const Champion& who, const fs::path& file,
                                           evaluation::StopToken stop) {
  recording::FileWriter writer;
  recording::Recorder recorder(*experiment_.ecosystem, who.own_seat, writer,
                               provenance_of(who, heredity_, experiment_, run_),
                               recorder_options(experiment_.record));
  std::optional<LifeRecord> life =
      record_life(*experiment_.ecosystem, task_of(who), who.own_seat, stop, {}, &recorder, &team_);
  if (life) write(file, writer);
  return life;
}

}  // namespace somas::run
