#include "core/run/journal.hpp"

#include <map>
#include <string>
#include <utility>

#include "core/run/json.hpp"

namespace somas::run {
namespace {

using evaluation::Failure;
using evaluation::Result;
using evaluation::Row;
using evaluation::Task;

// What a kill can lose; a commit costs some tens of microseconds (the log is not flushed here:
// after a power cut the last of it may be evaluated again).
constexpr std::chrono::milliseconds commit_interval{20};

std::int64_t first_half(const TaskKey& key) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value = value << 8 | key[i];
  return static_cast<std::int64_t>(value);
}

std::int64_t checksum_of(Bytes task, std::uint64_t seat, std::uint64_t generation, const Row& row) {
  const Outcome& o = row.outcome;
  Hasher hasher;
  hasher.add(task).add(seat).add(generation);
  hasher.add(o.survival).add(std::uint64_t{o.censored}).add(o.divisions).add(o.specializations);
  hasher.add(o.refused_divisions)
      .add(std::uint64_t{o.final_cells})
      .add(std::uint64_t{o.peak_cells});
  hasher.add(o.cell_steps).add(o.biomass_share).add(row.score);
  return first_half(hasher.key());
}

std::int64_t checksum_of(Bytes task, std::uint64_t generation, std::string_view seed,
                         const Failure& failure) {
  Hasher hasher;
  hasher.add(task).add(generation).add(seed).add(std::uint64_t{failure.attempts});
  hasher.add(std::string_view(failure.cause)).add(std::string_view(failure.plugin));
  hasher.add(failure.step ? *failure.step + 1 : 0);
  return first_half(hasher.key());
}

std::int64_t checksum_of(Bytes task, std::uint64_t seat, std::uint64_t key, double x, double y,
                         Bytes controller, Bytes tree) {
  Hasher hasher;
  hasher.add(task).add(seat).add(key).add(x).add(y).add(controller).add(tree);
  return first_half(hasher.key());
}

// Columns from `first` on, as the table has them after `generation`.
Row row_of(const Statement& statement, int first) {
  Row row;
  Outcome& o = row.outcome;
  o.survival = statement.natural(first);
  o.censored = statement.integer(first + 1) != 0;
  o.divisions = statement.natural(first + 2);
  o.specializations = statement.natural(first + 3);
  o.refused_divisions = statement.natural(first + 4);
  o.final_cells = static_cast<std::uint32_t>(statement.natural(first + 5));
  o.peak_cells = static_cast<std::uint32_t>(statement.natural(first + 6));
  o.cell_steps = statement.real(first + 7);
  o.biomass_share = statement.real(first + 8);
  row.score = statement.real(first + 9);
  return row;
}

// Columns from `first` on, as the table has them after `seed`.
Failure failure_of(const Statement& statement, int first) {
  Failure failure;
  failure.attempts = static_cast<std::uint32_t>(statement.natural(first));
  failure.cause = statement.text(first + 1);
  failure.plugin = statement.text(first + 2);
  if (!statement.is_null(first + 3)) failure.step = statement.natural(first + 3);
  return failure;
}

// SQLite keeps -0 as 0: so that a result is the same before and after it was on record.
Result normalized(Result result) {
  for (Row& row : result.rows) row.score += 0.0;
  return result;
}

}  // namespace

/// Which tasks are to be evaluated: one of each key that is not on record.
struct Journal::Plan {
  std::vector<TaskKey> keys;                       ///< by task
  std::vector<std::optional<Result>> results;      ///< by task; what is known
  std::vector<Task> fresh;                         ///< to be evaluated
  std::vector<std::vector<std::size_t>> asked_by;  ///< by fresh task: the tasks of its key
  std::size_t known = 0;
};

Journal::Journal(const Database& database, const TaskKey& experiment)
    : database_(database),
      experiment_(experiment),
      find_(database,
            "SELECT survival, censored, divisions, specializations, refused_divisions, "
            "final_cells, peak_cells, cell_steps, biomass_share, score FROM evaluations "
            "WHERE task = ? ORDER BY seat"),
      find_failure_(database, "SELECT attempts, cause, plugin, step FROM failures WHERE task = ?"),
      insert_(database,
              "INSERT INTO evaluations VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      insert_failure_(database, "INSERT INTO failures VALUES (?, ?, ?, ?, ?, ?, ?, ?)"),
      insert_organism_(database, "INSERT INTO failed_organisms VALUES (?, ?, ?, ?, ?, ?, ?, ?)") {}

std::optional<Result> Journal::find(const TaskKey& key, std::size_t organisms) {
  Result result;
  find_.with(Bytes(key));
  while (find_.step()) result.rows.push_back(row_of(find_, 0));
  if (result.rows.size() == organisms && organisms > 0) return result;
  if (!result.rows.empty())
    throw DamagedStore(database_.file().string() + " is damaged: an evaluation has " +
                       std::to_string(result.rows.size()) + " rows, not " +
                       std::to_string(organisms));
  if (!find_failure_.with(Bytes(key)).step()) return std::nullopt;
  result.failure = failure_of(find_failure_, 0);
  result.rows.resize(organisms);
  find_failure_.run();
  return result;
}

Journal::Plan Journal::plan(std::span<const Task> tasks) {
  Plan plan;
  plan.results.resize(tasks.size());
  // One look at the store, not one a task: each would lock the file.
  const bool own = !database_.in_transaction();
  if (own) database_.execute("BEGIN");
  std::map<TaskKey, std::size_t> fresh;  // by key, the place in plan.fresh
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const TaskKey& key = plan.keys.emplace_back(key_of(experiment_, tasks[t]));
    if (const auto known = fresh.find(key); known != fresh.end()) {
      plan.asked_by[known->second].push_back(t);
      continue;
    }
    plan.results[t] = find(key, tasks[t].roster.size());
    if (plan.results[t]) {
      ++plan.known;
      continue;
    }
    fresh.emplace(key, plan.fresh.size());
    plan.fresh.push_back(tasks[t]);
    plan.asked_by.push_back({t});
  }
  if (own) database_.execute("COMMIT");
  return plan;
}

std::optional<Journal::Evaluated> Journal::evaluate(std::span<const Task> tasks,
                                                    std::uint64_t generation,
                                                    evaluation::Evaluator& evaluator,
                                                    evaluation::StopToken stop,
                                                    const std::function<void(std::size_t)>& done) {
  Plan plan = this->plan(tasks);
  std::size_t finished = plan.known;
  if (done) done(finished);
  const auto note = [&](std::size_t fresh, const Result& result) {
    const std::vector<std::size_t>& asked_by = plan.asked_by[fresh];
    record(plan.keys[asked_by.front()], plan.fresh[fresh], generation, normalized(result));
    for (const std::size_t task : asked_by) plan.results[task] = normalized(result);
    finished += asked_by.size();
    if (done) done(finished);
  };

  try {
    const bool complete = plan.fresh.empty() || evaluator.evaluate(plan.fresh, stop, note);
    commit();
    if (!complete || stop.stop_requested()) return std::nullopt;
  } catch (...) {
    // The first failure is the one to tell.
    try {
      commit();
    } catch (const std::exception&) {
    }
    throw;
  }

  Evaluated evaluated{{}, std::move(plan.keys)};
  for (std::optional<Result>& result : plan.results)
    evaluated.results.push_back(std::move(result).value());
  return evaluated;
}

void Journal::record(const TaskKey& key, const Task& task, std::uint64_t generation,
                     const Result& result) {
  if (!database_.in_transaction()) database_.execute("BEGIN IMMEDIATE");
  const Bytes name(key);
  if (result.failure) {
    record_failure(key, task, generation, *result.failure);
  } else {
    for (std::uint64_t seat = 0; seat < result.rows.size(); ++seat) {
      const Row& row = result.rows[seat];
      const Outcome& o = row.outcome;
      insert_
          .with(name, seat, generation, o.survival, o.censored, o.divisions, o.specializations,
                o.refused_divisions, o.final_cells, o.peak_cells, o.cell_steps, o.biomass_share,
                row.score, checksum_of(name, seat, generation, row))
          .run();
    }
  }
  commit_now_and_then();
}

void Journal::record_failure(const TaskKey& key, const Task& task, std::uint64_t generation,
                             const Failure& failure) {
  const Bytes name(key);
  const std::string seed = hex64(task.seed);
  insert_failure_
      .with(name, generation, seed, failure.attempts, failure.cause, failure.plugin, failure.step,
            checksum_of(name, generation, seed, failure))
      .run();
  for (std::uint64_t seat = 0; seat < task.roster.size(); ++seat) {
    const evaluation::Organism& organism = task.roster[seat];
    const Bytes controller(organism.genome->controller), tree(organism.genome->tree);
    const double x = organism.x + 0.0, y = organism.y + 0.0;  // as it will be read
    insert_organism_
        .with(name, seat, organism.key, x, y, controller, tree,
              checksum_of(name, seat, organism.key, x, y, controller, tree))
        .run();
  }
}

void Journal::commit_now_and_then() {
  if (std::chrono::steady_clock::now() - committed_ >= commit_interval) commit();
}

void Journal::commit() {
  if (database_.in_transaction()) database_.execute("COMMIT");
  committed_ = std::chrono::steady_clock::now();
}

void verify_journal(const Database& database) {
  const auto damaged = [&](const char* table, Bytes task) {
    throw DamagedStore(database.file().string() + " is damaged: the row " + hex_bytes(task) +
                       " of " + table + " does not have the checksum that it had");
  };
  Statement rows(database,
                 "SELECT task, seat, generation, survival, censored, divisions, specializations, "
                 "refused_divisions, final_cells, peak_cells, cell_steps, biomass_share, score, "
                 "checksum FROM evaluations");
  while (rows.step())
    if (checksum_of(rows.bytes(0), rows.natural(1), rows.natural(2), row_of(rows, 3)) !=
        rows.integer(13))
      damaged("evaluations", rows.bytes(0));

  Statement failures(database,
                     "SELECT task, generation, seed, attempts, cause, plugin, step, checksum "
                     "FROM failures");
  while (failures.step())
    if (checksum_of(failures.bytes(0), failures.natural(1), failures.text(2),
                    failure_of(failures, 3)) != failures.integer(7))
      damaged("failures", failures.bytes(0));

  Statement organisms(database,
                      "SELECT task, seat, key, x, y, controller, tree, checksum "
                      "FROM failed_organisms");
  while (organisms.step())
    if (checksum_of(organisms.bytes(0), organisms.natural(1), organisms.natural(2),
                    organisms.real(3), organisms.real(4), organisms.bytes(5),
                    organisms.bytes(6)) != organisms.integer(7))
      damaged("failed_organisms", organisms.bytes(0));
}

}  // namespace somas::run
