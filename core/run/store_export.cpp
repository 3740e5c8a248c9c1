#include "core/run/store_export.hpp"

#include <algorithm>
#include <cstdio>

#include "core/run/csv.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

using evolution::Mode;

// ---- a row -------------------------------------------------------------------------------------

void add_field(CsvLine& line, const Statement& row, int column) {
  switch (row.type(column)) {
    case Statement::Type::integer:
      line.add(row.integer(column));
      break;
    case Statement::Type::real:
      line.add(row.real(column));
      break;
    case Statement::Type::text:
      line.add(row.text(column));
      break;
    case Statement::Type::bytes:
      line.add(hex_bytes(row.bytes(column)));
      break;
    case Statement::Type::null:
      line.add("");
  }
}

std::string lines_of(Statement& rows) {
  std::string text;
  CsvLine line;
  while (rows.step()) {
    for (int column = 0; column < rows.columns(); ++column) add_field(line, rows, column);
    text += line.take();
  }
  return text;
}

std::string header_of(const Database& database, const std::string& sql) {
  const Statement statement(database, sql);
  CsvLine line;
  for (int column = 0; column < statement.columns(); ++column)
    line.add(statement.column_name(column));
  return line.take();
}

// ---- the files of a run ------------------------------------------------------------------------

std::string without_spaces(std::string text) {
  std::erase(text, ' ');
  return text;
}

ExportedFile file_of(const char* name, const std::string& columns, const std::string& rest) {
  const std::string query = "SELECT " + columns + " " + rest;
  return {name, without_spaces(columns) + "\n",
          [query](const Database& database, std::uint64_t generation) {
            Statement rows(database, query);
            return lines_of(rows.with(generation));
          }};
}

// Columns that only some modes have come last.
std::string company(Mode mode, const char* column) {
  std::string columns;
  if (mode != Mode::solo) columns += std::string(", ") + column;
  if (mode == Mode::coevolution) columns += ", population";
  return columns;
}

ExportedFile generations_file(Mode mode) {
  return file_of("generations.csv",
                 "generation, best, q3, median, q1, worst, mean, champion_id, "
                 "champion_genome_length, champion_survival, champion_censored, "
                 "champion_divisions, champion_specializations, champion_peak_cells, evaluations, "
                 "censored, refused_divisions, cell_steps" +
                     company(mode, "champion_biomass_share"),
                 "FROM generations WHERE generation = ? ORDER BY population");
}

ExportedFile individuals_file(Mode mode) {
  return file_of("individuals.csv",
                 "id, generation, parent1, parent2, operator, fitness, genome_length" +
                     company(mode, "opponents"),
                 "FROM individuals WHERE generation = ? ORDER BY population, id");
}

// The ALife data standard for phylogenies. Its ids must be unique, which in two populations those
// of individuals are not.
ExportedFile phylogeny_file(Mode mode) {
  const bool two = mode == Mode::coevolution;
  const auto unique = [&](const std::string& id) {
    return two ? "(2 * " + id + " + population - 1)" : id;
  };
  const std::string query =
      "SELECT " + unique("id") +
      ", CASE WHEN parent1 IS NULL THEN '[none]' WHEN parent2 IS NULL "
      "THEN '[' || " +
      unique("parent1") + " || ']' ELSE '[' || " + unique("parent1") + " || ',' || " +
      unique("parent2") +
      " || ']' END, generation, operator, fitness, "
      "genome_length" +
      (two ? ", population, id" : "") +
      " FROM individuals WHERE generation = ? ORDER BY population, individuals.id";
  return {"phylogeny.csv",
          std::string("id,ancestor_list,origin_time,operator,fitness,genome_length") +
              (two ? ",population,individual\n" : "\n"),
          [query](const Database& database, std::uint64_t generation) {
            Statement rows(database, query);
            return lines_of(rows.with(generation));
          }};
}

ExportedFile timing_file() {
  return {"timing.csv",
          "generation,seconds,evaluations_per_second,cell_steps_per_second,threads,finished\n",
          [](const Database& database, std::uint64_t generation) {
            Statement row(database,
                          "SELECT seconds, workers, finished, max(evaluations), sum(cell_steps) "
                          "FROM timing JOIN generations USING (generation) WHERE generation = ? "
                          "GROUP BY generation");
            if (!row.with(generation).step()) return std::string();
            const double seconds = std::max(row.real(0), 1e-9);
            char rates[96];
            std::snprintf(rates, sizeof rates, "%.3f,%.1f,%.0f", row.real(0), row.real(3) / seconds,
                          row.real(4) / seconds);
            return std::to_string(generation) + "," + rates + "," + std::to_string(row.integer(1)) +
                   "," + std::string(row.text(2)) + "\n";
          }};
}

// ---- the dump ----------------------------------------------------------------------------------

struct Table {
  const char* name;
  const char* order;
};

// Without the columns and tables that depend on the clock, and in an order that does not depend on
// who was evaluated first.
constexpr Table result_tables[] = {{"generations", "generation, population"},
                                   {"individuals", "generation, population, id"},
                                   {"trials", "generation, population, individual, trial"},
                                   {"evaluations", "task, seat"},
                                   {"failures", "task"},
                                   {"failed_organisms", "task, seat"}};

}  // namespace

std::vector<ExportedFile> exported_files(Mode mode) {
  return {generations_file(mode), individuals_file(mode), phylogeny_file(mode), timing_file()};
}

void dump(const Database& database, const std::function<void(std::string_view)>& put) {
  for (const Table& table : result_tables) {
    const std::string query =
        std::string("SELECT * FROM ") + table.name + " ORDER BY " + table.order;
    put(std::string("# ") + table.name + "\n" + header_of(database, query));
    Statement rows(database, query);
    CsvLine line;
    while (rows.step()) {
      for (int column = 0; column < rows.columns(); ++column) add_field(line, rows, column);
      put(line.take());
    }
  }
}

}  // namespace somas::run
