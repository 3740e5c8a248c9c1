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

#include "core/run/csv.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view generations_header =
    "generation,best,q3,median,q1,worst,mean,champion_id,champion_genome_length,"
    "champion_survival,champion_censored,champion_divisions,champion_specializations,"
    "champion_peak_cells,evaluations,censored,refused_divisions,cell_steps\n";
constexpr std::string_view individuals_header =
    "id,generation,parent1,parent2,operator,fitness,genome_length\n";
constexpr std::string_view timing_header =
    "generation,seconds,evaluations_per_second,cell_steps_per_second,threads,finished\n";

// Columns that only some modes have come last.
std::string header_of(std::string_view columns, std::string_view company, evolution::Mode mode) {
  std::string header(columns.substr(0, columns.size() - 1));
  if (mode != evolution::Mode::solo) header += "," + std::string(company);
  if (mode == evolution::Mode::coevolution) header += ",population";
  return header + "\n";
}

std::string generation_line(const Generation& generation) {
  const evolution::Statistics& statistics = generation.statistics;
  const evolution::Individual& champion = generation.champion.individual;
  const Outcome& outcome = generation.champion.life.outcome;
  CsvLine line;
  line.add(generation.number)
      .add(statistics.best)
      .add(statistics.upper_quartile)
      .add(statistics.median)
      .add(statistics.lower_quartile)
      .add(statistics.worst)
      .add(statistics.mean);
  line.add(champion.id)
      .add(champion.genome.length())
      .add(outcome.survival)
      .add(outcome.censored ? 1 : 0)
      .add(outcome.divisions)
      .add(outcome.specializations)
      .add(outcome.peak_cells);
  line.add(generation.evaluations)
      .add(generation.censored)
      .add(generation.refused_divisions)
      .add(generation.cell_steps);
  if (!generation.opponents.empty()) line.add(outcome.biomass_share);
  if (generation.champion.population != 0) line.add(generation.champion.population);
  return line.take();
}

std::string individual_lines(const Generation& generation) {
  std::string text;
  CsvLine line;
  for (std::size_t k = 0; k < generation.population->size(); ++k) {
    const evolution::Individual& individual = (*generation.population)[k];
    line.add(individual.id).add(generation.number);
    for (std::size_t i = 0; i < 2; ++i) {
      if (i < individual.parents.size())
        line.add(individual.parents[i]);
      else
        line.add("");
    }
    line.add(evolution::name_of(individual.origin))
        .add(individual.fitness)
        .add(individual.genome.length());
    if (!generation.opponents.empty()) line.add(generation.opponents[k]);
    if (generation.champion.population != 0) line.add(generation.champion.population);
    text += line.take();
  }
  return text;
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string timing_line(std::span<const Generation> populations, const Timing& timing) {
  const Generation& generation = populations.front();
  const double seconds = std::max(timing.seconds, 1e-9);
  double cell_steps = 0;
  for (const Generation& one : populations) cell_steps += one.cell_steps;
  char rates[96];
  std::snprintf(rates, sizeof rates, "%.3f,%.1f,%.0f", timing.seconds,
                static_cast<double>(generation.evaluations) / seconds, cell_steps / seconds);
  return std::to_string(generation.number) + "," + rates + "," + std::to_string(timing.threads) +
         "," + now_utc() + "\n";
}

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
  if (::mkdir(path.c_str(), 0777) == 0) return true;
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

fs::path make_given_directory(const fs::path& given) {
  if (given.empty()) throw UsageError("--out: the name of the directory is empty");
  // "runs/a/" names the same directory as "runs/a".
  fs::path out = given.has_filename() ? given : given.parent_path();
  make_parents(out);
  if (make_directory(out)) return out;
  std::error_code error;
  if (!fs::is_directory(out, error)) throw UsageError(out.string() + " exists and is no directory");
  if (!fs::is_empty(out, error) || error) refuse_earlier_run(out);
  return out;
}

}  // namespace

fs::path champion_path(const fs::path& run, std::uint64_t generation, std::uint32_t population) {
  std::string number = std::to_string(generation);
  if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
  if (population > 1) number += "-" + std::to_string(population);
  return run / "champions" / ("gen-" + number + ".json");
}

std::uint64_t last_generation(const fs::path& run) {
  std::optional<std::uint64_t> last;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(run / "champions", error)) {
    const std::string name = entry.path().filename().string();
    std::uint64_t number = 0;
    if (!name.starts_with("gen-") || !name.ends_with(".json")) continue;
    const char* end = name.data() + name.size() - 5;
    const auto parsed = std::from_chars(name.data() + 4, end, number);
    if (parsed.ec == std::errc{} && parsed.ptr == end) last = std::max(last.value_or(0), number);
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

fs::path make_run_directory(const std::optional<fs::path>& out, const std::string& name,
                            std::uint64_t seed) {
  if (out) return make_given_directory(*out);
  const std::string base = file_name_of(name) + "-seed" + std::to_string(seed);
  fs::path path = fs::path("runs") / base;
  make_parents(path);
  // mkdir decides between two runs that start at once.
  for (unsigned suffix = 2; !make_directory(path); ++suffix)
    path.replace_filename(base + "-" + std::to_string(suffix));
  return path;
}

RunDirectory::RunDirectory(fs::path path, const experiment::Experiment& experiment,
                           const Json& manifest, std::span<const GivenGenome> genomes)
    : path_(std::move(path)), owners_(owners_of(experiment)), mode_(experiment.evolution.mode) {
  try {
    create_file(path_ / "experiment.yaml", experiment.original_yaml);
  } catch (const WriteError& error) {
    // Another run that started at the same moment was faster.
    if (error.error() == EEXIST) refuse_earlier_run(path_);
    throw;
  }
  create_file(path_ / "resolved.yaml", experiment.resolved_yaml);
  create_file(path_ / "manifest.json", to_text(manifest));
  make_directory(path_ / "champions");
  if (!genomes.empty()) make_directory(path_ / "genomes");
  for (std::size_t i = 0; i < genomes.size(); ++i)
    create_file(path_ / "genomes" / ("given-" + std::to_string(i) + ".json"), genomes[i].text);
  individuals_.emplace(path_ / "individuals.csv",
                       header_of(individuals_header, "opponents", mode_));
  timing_.emplace(path_ / "timing.csv", timing_header);
  generations_.emplace(path_ / "generations.csv",
                       header_of(generations_header, "champion_biomass_share", mode_));
}

void RunDirectory::commit(std::span<const Generation> populations,
                          const evolution::Heredity& heredity, const Timing& timing) {
  std::vector<fs::path> champions;
  std::string individuals, generations;
  int appended = 0;
  try {
    for (const Generation& generation : populations) {
      const fs::path champion =
          champion_path(path_, generation.number, generation.champion.population);
      create_file(champion, to_text(generation.champion, heredity, owners_));
      champions.push_back(champion);
      individuals += individual_lines(generation);
      generations += generation_line(generation);
    }
    individuals_->append(individuals);
    ++appended;
    timing_->append(timing_line(populations, timing));
    ++appended;
    generations_->append(generations);
  } catch (...) {
    if (appended > 1) timing_->undo();
    if (appended > 0) individuals_->undo();
    std::error_code ignored;
    for (const fs::path& champion : champions) fs::remove(champion, ignored);
    throw;
  }
}

void RunDirectory::summarize(const Json& summary) {
  write_file(path_ / "summary.json", to_text(summary));
}

}  // namespace somas::run
