#include "core/run/run_directory.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include <sys/stat.h>

#include "core/run/phase.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_make(const fs::path& path, int error) {
  std::string why = std::generic_category().message(error);
  // Below a directory that exists, "no such file" would puzzle: so /proc and its like answer.
  std::error_code ignored;
  const fs::path parent = path.has_parent_path() ? path.parent_path() : ".";
  if (error == ENOENT && fs::is_directory(parent, ignored))
    why = "no directories can be made in " + parent.string();
  throw WriteError("cannot make the directory " + path.string() + ": " + why, path, error);
}

/// False if something of that name exists already.
bool make_directory(const fs::path& path) {
  if (::mkdir(path.c_str(), 0777) == 0) {
    flush_directory_of(path);
    return true;
  }
  if (errno == EEXIST) return false;
  cannot_make(path, errno);
}

void make_parents(const fs::path& path) {
  const fs::path parent = path.parent_path();
  if (parent.empty() || parent == path) return;
  std::error_code error;
  if (fs::is_directory(parent, error)) return;
  make_parents(parent);
  if (!make_directory(parent) && !fs::is_directory(parent, error))
    throw UsageError("cannot make the directory " + path.string() + ": " + parent.string() +
                     " is no directory");
}

// An experiment's name as part of a file name.
std::string file_name_of(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte > 0x1F && byte != 0x7F && c != '/' && (c != '.' || !safe.empty());
    safe += plain ? c : '_';
  }
  return safe.empty() ? "run" : safe;
}

[[noreturn]] void refuse_earlier_run(const fs::path& directory) {
  throw UsageError("directory " + directory.string() +
                   " is not empty: an earlier run is never overwritten; name another --out");
}

// What a run makes before its manifest; nothing of it is anybody's result.
bool is_of_a_beginning(const std::string& name) {
  constexpr std::string_view names[] = {RunLock::file_name, "experiment.yaml", "resolved.yaml",
                                        "champions",        "genomes",         "conditions"};
  return std::find(std::begin(names), std::end(names), name) != std::end(names) ||
         name.starts_with(store_name) || name.starts_with('.');
}

/// Empty, or left by a run that was killed before it began: its lock was the first thing there.
bool is_free(const fs::path& directory) {
  std::error_code error;
  const bool was_ours = fs::exists(directory / RunLock::file_name, error);
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error))
    if (!was_ours || !is_of_a_beginning(entry.path().filename().string())) return false;
  return !error;
}

void remove_beginning(const fs::path& directory) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory))
    if (entry.path().filename() != RunLock::file_name) paths.push_back(entry.path());
  std::error_code error;
  for (const fs::path& path : paths)
    if (fs::remove_all(path, error); error) throw WriteError(path, error.value());
}

/// A temporary file of write_file's.
bool is_temporary(const std::string& name) {
  return name.starts_with('.') && name.find(".tmp") != std::string::npos;
}

fs::path make_given_directory(const fs::path& given) {
  if (given.empty()) throw UsageError("--out: the name of the directory is empty");
  // "runs/a/" names the same directory as "runs/a".
  fs::path out = given.has_filename() ? given : given.parent_path();
  make_parents(out);
  if (make_directory(out)) return out;
  std::error_code error;
  if (!fs::is_directory(out, error)) throw UsageError(out.string() + " exists and is no directory");
  if (!is_free(out)) refuse_earlier_run(out);
  return out;
}

struct ChampionName {
  std::uint64_t generation = 0;
  std::uint32_t population = 1;
};

/// The reverse of champion_path.
std::optional<ChampionName> champion_named(const std::string& name) {
  if (!name.starts_with("gen-") || !name.ends_with(".json")) return std::nullopt;
  ChampionName result;
  const char* end = name.data() + name.size() - 5;
  auto parsed = std::from_chars(name.data() + 4, end, result.generation);
  if (parsed.ec != std::errc{}) return std::nullopt;
  if (parsed.ptr == end) return result;
  if (*parsed.ptr != '-') return std::nullopt;
  parsed = std::from_chars(parsed.ptr + 1, end, result.population);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return std::nullopt;
  return result;
}

}  // namespace

fs::path champion_path(const fs::path& run, std::uint64_t generation, std::uint32_t population) {
  std::string number = std::to_string(generation);
  if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
  if (population > 1) number += "-" + std::to_string(population);
  return run / "champions" / ("gen-" + number + ".json");
}

fs::path crash_path(const fs::path& run) { return run / "crash.txt"; }

std::uint64_t last_generation(const fs::path& run) {
  std::optional<std::uint64_t> last;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(run / "champions", error)) {
    const std::optional<ChampionName> name = champion_named(entry.path().filename().string());
    if (name && name->population == 1) last = std::max(last.value_or(0), name->generation);
  }
  if (error)
    throw UsageError(run.string() + " is no run directory: " + (run / "champions").string() + ": " +
                     error.message());
  if (!last) throw UsageError(run.string() + " has no champion: no generation was finished");
  return *last;
}

std::optional<std::uint64_t> champion_id(const fs::path& run, std::uint64_t generation,
                                         std::uint32_t population) {
  const auto fields_of = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream in(line);
    for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
    return fields;
  };
  std::ifstream in(run / "generations.csv");
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  const std::vector<std::string> names = fields_of(line);
  const auto column_of = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const std::size_t column = column_of("champion_id"), of_population = column_of("population");
  const std::string number = std::to_string(generation), whose = std::to_string(population);
  while (std::getline(in, line)) {
    const std::vector<std::string> fields = fields_of(line);
    if (column >= fields.size() || fields[0] != number) continue;
    if (of_population < fields.size() && fields[of_population] != whose) continue;
    const std::string& text = fields[column];
    std::uint64_t id = 0;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), id);
    if (parsed.ec == std::errc{} && parsed.ptr == text.data() + text.size()) return id;
  }
  return std::nullopt;
}

namespace {

// runs/BASE, with -2, -3, ... as often as it takes.
fs::path make_new_directory(const std::string& base) {
  fs::path path = fs::path("runs") / base;
  make_parents(path);
  // mkdir decides between two runs that start at once.
  for (unsigned suffix = 2; !make_directory(path); ++suffix)
    path.replace_filename(base + "-" + std::to_string(suffix));
  return path;
}

}  // namespace

fs::path make_run_directory(const std::optional<fs::path>& out, const std::string& name,
                            std::uint64_t seed) {
  if (out) return make_given_directory(*out);
  return make_new_directory(file_name_of(name) + "-seed" + std::to_string(seed));
}

fs::path make_campaign_directory(const std::optional<fs::path>& out, const std::string& name) {
  if (out) return make_given_directory(*out);
  return make_new_directory(file_name_of(name) + "-campaign");
}

void clear_beginning(const fs::path& directory) {
  if (!is_free(directory)) refuse_earlier_run(directory);
  remove_beginning(directory);
}

void remove_temporary_files(const fs::path& directory) {
  std::vector<fs::path> leftovers;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error))
    if (is_temporary(entry.path().filename().string())) leftovers.push_back(entry.path());
  for (const fs::path& path : leftovers)
    if (fs::remove(path, error); error) throw WriteError(path, error.value());
}

void make_directory_in(const fs::path& path) { make_directory(path); }

bool holds_run(const fs::path& directory) {
  std::error_code error;
  return fs::exists(directory / "manifest.json", error);
}

RunDirectory::RunDirectory(fs::path path, const experiment::Experiment& experiment,
                           const Json& manifest, std::span<const GivenGenome> genomes)
    : path_(std::move(path)), lock_(path_) {
  // Another run that started at the same moment may have been faster.
  clear_beginning(path_);
  create_file(path_ / "experiment.yaml", experiment.original_yaml);
  create_file(path_ / "resolved.yaml", experiment.resolved_yaml);
  make_directory(path_ / "champions");
  if (!genomes.empty()) make_directory(path_ / "genomes");
  for (std::size_t i = 0; i < genomes.size(); ++i)
    create_file(path_ / "genomes" / ("given-" + std::to_string(i) + ".json"), genomes[i].text);
  Store::create(path_ / store_name, {experiment.original_yaml, experiment.resolved_yaml});
  create_file(path_ / "manifest.json", to_text(manifest));
  store_.emplace(path_ / store_name, Database::Access::write);
  open_files(experiment);
}

RunDirectory::RunDirectory(fs::path path) : path_(std::move(path)), lock_(path_) {
  store_.emplace(path_ / store_name, Database::Access::write);
}

void RunDirectory::open_files(const experiment::Experiment& experiment) {
  owners_ = owners_of(experiment);
  exported_ = exported_files(experiment.evolution.mode);
  remove_leftovers();
  const std::uint64_t finished = store_->generations();
  for (const ExportedFile& file : exported_) {
    std::string text = file.header;
    for (std::uint64_t number = 0; number < finished; ++number)
      text += file.lines(store_->database(), number);
    files_.push_back(std::make_unique<AppendFile>(path_ / file.name, text));
  }
}

void RunDirectory::replace_experiment(const StoreMeta& meta) {
  store_->set_meta(meta);
  write_file(path_ / "experiment.yaml", meta.original_yaml);
  write_file(path_ / "resolved.yaml", meta.resolved_yaml);
}

// Champions are written before their generation is committed, and files under temporary names.
void RunDirectory::remove_leftovers() const {
  const std::uint64_t finished = store_->generations();
  std::vector<fs::path> leftovers;
  for (const fs::path& directory : {path_, path_ / "champions"}) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
      const std::string name = entry.path().filename().string();
      const std::optional<ChampionName> champion = champion_named(name);
      if (is_temporary(name) || (champion && champion->generation >= finished))
        leftovers.push_back(entry.path());
    }
  }
  std::error_code error;
  for (const fs::path& leftover : leftovers)
    if (fs::remove(leftover, error); error) throw WriteError(leftover, error.value());
}

void RunDirectory::commit(std::span<Generation> populations, const evolution::Heredity& heredity,
                          const Timing& timing) {
  const std::uint64_t number = populations.front().number;
  std::vector<fs::path> champions;
  std::size_t appended = 0;
  try {
    for (Generation& generation : populations) {
      const std::string text = to_text(generation.champion, heredity, owners_);
      const fs::path champion = champion_path(path_, number, generation.champion.population);
      create_file(champion, text);
      champions.push_back(champion);
      generation.champion_hash = hash_of_text(text);
    }
    store_->add(populations, timing);

    enter_phase("export");
    for (; appended < files_.size(); ++appended)
      files_[appended]->append(exported_[appended].lines(store_->database(), number));

    enter_phase("commit");
    store_->commit();
  } catch (...) {
    store_->rollback();
    while (appended-- > 0) files_[appended]->undo();
    std::error_code ignored;
    for (const fs::path& champion : champions) fs::remove(champion, ignored);
    throw;
  }
}

void RunDirectory::summarize(const Json& summary) {
  write_file(path_ / "summary.json", to_text(summary));
}

void RunDirectory::close() {
  for (const std::unique_ptr<AppendFile>& file : files_) file->flush();
  store_->settle();
}

}  // namespace somas::run
