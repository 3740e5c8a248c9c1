#include "core/report/run_tables.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/json.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;

/// One record; `at` moves behind it. Quoted fields may hold anything.
std::vector<std::string> next_record(const std::string& text, std::size_t& at) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted && c == '"' && at + 1 < text.size() && text[at + 1] == '"')
      fields.back() += text[++at];
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && c == ',')
      fields.emplace_back();
    else if (!quoted && c == '\n')
      break;
    else if (quoted || c != '\r')
      fields.back() += c;
  }
  ++at;
  return fields;
}

template <class Number>
std::optional<Number> parsed(const std::string& text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return value;
}

bool of_population(const Table& table, std::size_t row, std::uint32_t population) {
  if (!table.has("population")) return population == 1;
  return table.natural(row, "population") == population;
}

std::optional<std::uint64_t> parent(const Table& table, std::size_t row, const char* column) {
  if (table.text(row, column).empty()) return std::nullopt;
  return table.natural(row, column);
}

using Key = std::pair<std::uint64_t, std::uint64_t>;  // generation, id

std::map<Key, Ancestor> read_individuals(const fs::path& run, std::uint64_t last,
                                         std::uint32_t population) {
  const Table table(run / "individuals.csv");
  std::map<Key, Ancestor> individuals;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!of_population(table, row, population)) continue;
    Ancestor one{.id = table.natural(row, "id"),
                 .generation = table.natural(row, "generation"),
                 .first_parent = parent(table, row, "parent1"),
                 .second_parent = parent(table, row, "parent2"),
                 .origin = table.text(row, "operator"),
                 .fitness = table.number(row, "fitness")};
    if (one.generation > last) continue;
    individuals.emplace(Key{one.generation, one.id}, std::move(one));
  }
  return individuals;
}

std::vector<double> count_ancestors(const std::map<Key, Ancestor>& individuals,
                                    std::uint64_t generation, std::uint64_t champion) {
  std::vector<double> counts(generation + 1, 0);
  std::set<std::uint64_t> here{champion};
  for (std::uint64_t g = generation;; --g) {
    counts[g] = static_cast<double>(here.size());
    if (g == 0) return counts;
    std::set<std::uint64_t> before;
    for (const std::uint64_t id : here) {
      const auto found = individuals.find({g, id});
      if (found == individuals.end()) continue;
      for (const auto& one : {found->second.first_parent, found->second.second_parent})
        if (one) before.insert(*one);
    }
    here = std::move(before);
  }
}

}  // namespace

Table::Table(const fs::path& file) : file_(file) {
  const std::string text = run::read_file(file);
  std::size_t at = 0, line = 1;
  if (text.empty()) throw run::UsageError(file.string() + ": the file is empty");
  header_ = next_record(text, at);
  while (at < text.size()) {
    ++line;
    std::vector<std::string> fields = next_record(text, at);
    if (fields.size() != header_.size())
      throw run::UsageError(file.string() + ":" + std::to_string(line) + ": " +
                            plugins::plural(fields.size(), "field") + ", but the header has " +
                            std::to_string(header_.size()));
    cells_.push_back(std::move(fields));
  }
}

bool Table::has(const std::string& column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

std::size_t Table::index_of(const std::string& column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  if (found == header_.end())
    throw run::UsageError(file_.string() + ": there is no column '" + column +
                          "'; columns: " + plugins::join(header_));
  return static_cast<std::size_t>(found - header_.begin());
}

std::string Table::place(std::size_t row, const std::string& column) const {
  return file_.string() + ":" + std::to_string(row + 2) + ": " + column + ": '" +
         text(row, column) + "'";
}

const std::string& Table::text(std::size_t row, const std::string& column) const {
  return cells_[row][index_of(column)];
}

double Table::number(std::size_t row, const std::string& column) const {
  const auto value = parsed<double>(text(row, column));
  if (!value) throw run::UsageError(place(row, column) + " is no number");
  return *value;
}

std::uint64_t Table::natural(std::size_t row, const std::string& column) const {
  const auto value = parsed<std::uint64_t>(text(row, column));
  if (!value) throw run::UsageError(place(row, column) + " is no whole number");
  return *value;
}

Generations read_generations(const fs::path& run, std::uint32_t population) {
  const Table table(run / "generations.csv");
  Generations generations;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!of_population(table, row, population)) continue;
    generations.best.push_back(table.number(row, "best"));
    generations.upper_quartile.push_back(table.number(row, "q3"));
    generations.median.push_back(table.number(row, "median"));
    generations.lower_quartile.push_back(table.number(row, "q1"));
    generations.champion.push_back(table.natural(row, "champion_id"));
  }
  if (generations.best.empty() && table.rows() > 0)
    throw run::UsageError("population " + std::to_string(population) + " is not in " +
                          (run / "generations.csv").string());
  if (generations.best.empty())
    throw run::UsageError(run.string() + ": no generation was finished; there is nothing to draw");
  return generations;
}

Lineage read_lineage(const fs::path& run, std::uint64_t generation, std::uint64_t champion,
                     std::uint32_t population) {
  const std::map<Key, Ancestor> individuals = read_individuals(run, generation, population);
  const auto find = [&](std::uint64_t g, std::uint64_t id) -> const Ancestor& {
    const auto found = individuals.find({g, id});
    if (found == individuals.end())
      throw run::UsageError((run / "individuals.csv").string() + ": individual " +
                            std::to_string(id) + " of generation " + std::to_string(g) +
                            ", an ancestor of the champion, is not on record");
    return found->second;
  };
  Lineage lineage;
  std::uint64_t id = champion;
  for (std::uint64_t g = generation;; --g) {
    const Ancestor& one = find(g, id);
    lineage.line.push_back(one);
    lineage.second_parents.emplace_back();
    if (one.second_parent && g > 0) lineage.second_parents.back() = find(g - 1, *one.second_parent);
    if (!one.first_parent || g == 0) break;
    id = *one.first_parent;
  }
  std::reverse(lineage.line.begin(), lineage.line.end());
  std::reverse(lineage.second_parents.begin(), lineage.second_parents.end());
  lineage.ancestors = count_ancestors(individuals, generation, champion);
  return lineage;
}

std::string objective_of(const fs::path& run) {
  const fs::path file = run / "manifest.json";
  const run::Json manifest = run::parse_json(run::read_file(file), file.string());
  return std::string(run::JsonView(manifest, file.string()).member("objective").text());
}

bool is_campaign(const fs::path& directory) {
  std::error_code error;
  return fs::exists(directory / "index.csv", error);
}

std::vector<Condition> conditions_of(const fs::path& campaign, std::vector<std::string>& warnings) {
  const Table index(campaign / "index.csv");
  std::vector<Condition> conditions;
  std::map<std::string, std::size_t> left_out;
  for (std::size_t row = 0; row < index.rows(); ++row) {
    const std::string& name = index.text(row, "condition");
    const auto known = std::find_if(conditions.begin(), conditions.end(),
                                    [&](const Condition& one) { return one.name == name; });
    Condition& condition =
        known != conditions.end() ? *known : conditions.emplace_back(Condition{name, {}});
    if (index.text(row, "status") == "complete")
      condition.runs.push_back(campaign / index.text(row, "directory"));
    else
      ++left_out[name];
  }
  for (const Condition& condition : conditions)
    if (left_out.contains(condition.name))
      warnings.push_back("condition " + condition.name + ": " +
                         plugins::plural(left_out[condition.name], "run") + " of " +
                         std::to_string(left_out[condition.name] + condition.runs.size()) +
                         " not complete, left out");
  std::erase_if(conditions, [](const Condition& one) { return one.runs.empty(); });
  if (conditions.empty())
    throw run::UsageError(campaign.string() +
                          ": no run of this campaign is complete; there is nothing to draw");
  return conditions;
}

std::vector<fs::path> runs_in(const std::vector<fs::path>& given) {
  std::vector<fs::path> runs;
  for (const fs::path& path : given) {
    std::error_code error;
    if (fs::exists(path / "generations.csv", error)) {
      runs.push_back(path);
      continue;
    }
    std::vector<fs::path> inside;
    for (const fs::directory_entry& entry : fs::directory_iterator(path, error))
      if (fs::exists(entry.path() / "generations.csv", error)) inside.push_back(entry.path());
    if (is_campaign(path))
      throw run::UsageError(path.string() + " is a campaign, which is drawn alone");
    if (inside.empty())
      throw run::UsageError(path.string() +
                            " is no run directory, and there is none in it: no generations.csv");
    std::sort(inside.begin(), inside.end());
    runs.insert(runs.end(), inside.begin(), inside.end());
  }
  return runs;
}

}  // namespace somas::report
