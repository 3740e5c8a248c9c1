#include "core/run/resume.hpp"

#include <utility>

#include "core/plugins/suggest.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

void check_begun(const fs::path& run) {
  std::error_code error;
  if (!fs::is_directory(run, error)) throw UsageError(run.string() + ": no such run directory");
  if (!holds_run(run))
    throw UsageError(run.string() +
                     " holds no run (it has no manifest.json); if one was killed before it began, "
                     "start it again");
}

/// The text without the line of evolution.generations, which a resume may change.
std::string without_generations(const std::string& resolved) {
  const std::string key = "\n  generations: ";
  const std::size_t begin = resolved.find(key);
  if (begin == std::string::npos) return resolved;
  const std::size_t end = resolved.find('\n', begin + 1);
  return resolved.substr(0, begin) + (end == std::string::npos ? "" : resolved.substr(end));
}

/// What is not as it was when the run began, a sentence each.
std::vector<std::string> changes(const Json& manifest, const std::string& origin,
                                 const StoreMeta& meta, const experiment::Experiment& now) {
  std::vector<std::string> found = changed_plugins(manifest, origin, now);
  if (without_generations(meta.resolved_yaml) != without_generations(now.resolved_yaml))
    found.push_back("the experiment (resolved.yaml) is not that of the run");
  const std::string host = hash_of_file("/proc/self/exe");
  const std::string then(JsonView(manifest, origin).member("host_xxh3_128").text());
  if (host != then)
    found.push_back("the host is not the one of the run: now hash " + host + "; then version " +
                    std::string(JsonView(manifest, origin).member("somas").text()) + ", hash " +
                    then);
  return found;
}

[[noreturn]] void refuse(const fs::path& run, const std::vector<std::string>& changes) {
  std::string text = run.string() + " cannot go on as it began:";
  for (const std::string& change : changes) text += "\n  " + change;
  throw UsageError(text +
                   "\nThe rest would not be what it would have been; --accept-changes goes on all "
                   "the same, and records it");
}

/// The manifest as it is from now on: what it says is what is in use, and the changes are on
/// record.
Json accepted(const Json& manifest, const std::vector<std::string>& changes,
              std::uint64_t generation, const experiment::Experiment& now) {
  const Json fresh = manifest_of(now, {});
  Json json = manifest;
  for (const char* key : {"somas", "host_xxh3_128", "build", "plugins"}) json[key] = fresh[key];
  Json entry;
  entry["from_generation"] = generation;
  entry["changes"] = changes;
  json["accepted_changes"].push_back(std::move(entry));
  return json;
}

void check_generations(const ResumeOptions& options, std::uint64_t finished) {
  if (!options.generations || *options.generations >= finished) return;
  throw UsageError("--generations " + std::to_string(*options.generations) + ": " +
                   options.run.string() + " has finished " +
                   plugins::plural(finished, "generation") + " already");
}

/// The files of champions must be those that were written.
std::vector<std::string> changed_champions(const fs::path& run, const Store& store,
                                           std::uint32_t populations) {
  std::vector<std::string> found;
  for (std::uint64_t generation = 0; generation < store.generations(); ++generation)
    for (std::uint32_t population = 1; population <= populations; ++population) {
      const fs::path file = champion_path(run, generation, population);
      std::error_code error;
      if (!fs::exists(file, error))
        found.push_back(file.string() + " is missing");
      else if (hash_of_file(file) != store.champion_hash(generation, population))
        found.push_back(file.string() + " is not as it was written");
    }
  return found;
}

experiment::Experiment load(const ResumeOptions& options, const Json& manifest,
                            const std::string& origin) {
  experiment::LoadOptions load;
  load.plugin_directories = options.plugin_path;
  if (load.plugin_directories.empty()) load.plugin_directories = plugin_path_of(manifest, origin);
  if (options.generations)
    load.overrides.push_back("evolution.generations=" + std::to_string(*options.generations));
  return experiment::load(options.run / "resolved.yaml", load);
}

}  // namespace

Resumption reopen(const ResumeOptions& options, Terminal& terminal) {
  const fs::path& run = options.run;
  check_begun(run);
  auto directory = std::make_unique<RunDirectory>(run);
  const std::string origin = (run / "manifest.json").string();
  const Json manifest = parse_json(read_file(origin), origin);
  experiment::Experiment experiment = load(options, manifest, origin);
  const Store& store = directory->store();
  const StoreMeta meta = store.meta();
  check_generations(options, store.generations());

  std::vector<std::string> found = changes(manifest, origin, meta, experiment);
  for (std::string& change :
       changed_champions(run, store, evolution::population_count(experiment.evolution)))
    found.push_back(std::move(change));
  if (!found.empty() && !options.accept_changes) refuse(run, found);
  if (!found.empty()) {
    for (const std::string& change : found) terminal.line("warning: accepted: " + change);
    write_file(origin, to_text(accepted(manifest, found, store.generations(), experiment)));
  }

  // An experiment that was changed, or is to last longer.
  experiment.original_yaml = meta.original_yaml;
  if (experiment.resolved_yaml != meta.resolved_yaml)
    directory->replace_experiment({meta.original_yaml, experiment.resolved_yaml});
  directory->open_files(experiment);
  return {std::move(experiment), std::move(directory)};
}

}  // namespace somas::run
