#include "core/run/store.hpp"

#include <ctime>
#include <sqlite3.h>
#include <system_error>
#include <unistd.h>

#include "core/run/journal.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

constexpr int store_version = 2;
constexpr int application_id = 0x534F4D41;  // "SOMA"

constexpr const char* schema = R"sql(
CREATE TABLE meta (               -- the experiment
  key   TEXT PRIMARY KEY,         -- original_yaml, resolved_yaml, checksum of both
  value TEXT NOT NULL
) WITHOUT ROWID;

CREATE TABLE generations (        -- a row per finished generation and population
  generation INTEGER, population INTEGER,  -- populations count from 1
  best REAL, q3 REAL, median REAL, q1 REAL, worst REAL, mean REAL,  -- fitness
  champion_id INTEGER,
  champion_genome_length INTEGER,
  champion_survival INTEGER, champion_censored INTEGER, champion_divisions INTEGER,
  champion_specializations INTEGER, champion_peak_cells INTEGER, champion_biomass_share REAL,
  champion_xxh3_128 TEXT,         -- of its file
  evaluations INTEGER, censored INTEGER, refused_divisions INTEGER, cell_steps REAL,
  checksum BLOB,                  -- of all rows of this generation and population
  PRIMARY KEY (population, generation)
) WITHOUT ROWID;

CREATE TABLE individuals (
  population INTEGER, generation INTEGER, id INTEGER,
  parent1 INTEGER, parent2 INTEGER,        -- ids in the generation before
  operator TEXT,
  fitness REAL,                   -- mean over the trials
  genome_length INTEGER,          -- bytes
  opponents TEXT,                 -- NULL in mode solo
  controller BLOB, tree BLOB,     -- genes; no tree where it does not evolve
  PRIMARY KEY (population, generation, id)
);

CREATE TABLE trials (
  population INTEGER, generation INTEGER, individual INTEGER, trial INTEGER,
  fitness REAL,
  task BLOB, seat INTEGER,        -- the row of evaluations
  PRIMARY KEY (population, generation, individual, trial)
) WITHOUT ROWID;

CREATE TABLE evaluations (        -- the journal: a row per organism of a simulation
  task BLOB, seat INTEGER,        -- XXH3-128 of all that decides the result; place in the roster
  generation INTEGER,             -- the first that asked for it
  survival INTEGER, censored INTEGER, divisions INTEGER, specializations INTEGER,
  refused_divisions INTEGER, final_cells INTEGER, peak_cells INTEGER,
  cell_steps REAL, biomass_share REAL, score REAL,
  checksum INTEGER,
  PRIMARY KEY (task, seat)
) WITHOUT ROWID;

CREATE TABLE failures (           -- tasks that were set aside
  task BLOB PRIMARY KEY,
  generation INTEGER,
  seed TEXT,                      -- of the simulation, hexadecimal
  attempts INTEGER,
  cause TEXT, plugin TEXT,
  step INTEGER,                   -- NULL: before the first
  checksum INTEGER
) WITHOUT ROWID;

CREATE TABLE failed_organisms (   -- the roster of a task that was set aside
  task BLOB, seat INTEGER,
  key INTEGER,                    -- of its random streams
  x REAL, y REAL,                 -- where its founder is
  controller BLOB, tree BLOB,     -- genes, as in individuals
  checksum INTEGER,
  PRIMARY KEY (task, seat)
) WITHOUT ROWID;

CREATE TABLE timing (             -- all that depends on the clock
  generation INTEGER PRIMARY KEY,
  seconds REAL, workers INTEGER, finished TEXT
);
CREATE TABLE sessions (           -- a row each time the run was begun or resumed
  session INTEGER PRIMARY KEY,
  began TEXT, host TEXT, process INTEGER, workers INTEGER, generation INTEGER,
  canary INTEGER, reference TEXT  -- the reference simulation, and its hash
);
)sql";

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

std::string name_of(Database::Access access, const std::filesystem::path& file) {
  std::error_code ignored;
  if (access != Database::Access::create && !std::filesystem::exists(file, ignored))
    throw UsageError("no such file: " + file.string());
  return file.string();
}

std::string checksum_of(const StoreMeta& meta) {
  Hasher hasher;
  hasher.add(std::string_view(meta.original_yaml)).add(std::string_view(meta.resolved_yaml));
  return hex_bytes(hasher.key());
}

void put_meta(const Database& database, const StoreMeta& meta) {
  Statement statement(database, "INSERT OR REPLACE INTO meta VALUES (?, ?)");
  statement.with("original_yaml", meta.original_yaml).run();
  statement.with("resolved_yaml", meta.resolved_yaml).run();
  statement.with("checksum", checksum_of(meta)).run();
}

void hash_rows(Statement& rows, Hasher& hasher) {
  while (rows.step()) {
    for (int column = 0; column < rows.columns(); ++column) {
      const Statement::Type type = rows.type(column);
      hasher.add(static_cast<std::uint64_t>(type));
      if (type == Statement::Type::integer) hasher.add(rows.natural(column));
      if (type == Statement::Type::real) hasher.add(rows.real(column));
      if (type == Statement::Type::text) hasher.add(rows.text(column));
      if (type == Statement::Type::bytes) hasher.add(rows.bytes(column));
    }
  }
}

std::optional<std::uint64_t> parent(const evolution::Individual& individual, std::size_t which) {
  if (which >= individual.parents.size()) return std::nullopt;
  return individual.parents[which];
}

}  // namespace

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

void Store::create(const std::filesystem::path& file, const StoreMeta& meta) {
  const Database database(file, Database::Access::create);
  database.execute("PRAGMA synchronous=FULL; BEGIN");
  database.execute(schema);
  put_meta(database, meta);
  database.execute(("PRAGMA application_id=" + std::to_string(application_id)).c_str());
  database.execute(("PRAGMA user_version=" + std::to_string(store_version)).c_str());
  database.execute("COMMIT");
}

Store::Store(const std::filesystem::path& file, Database::Access access)
    : database_(name_of(access, file), access) {
  if (database_.integer_of("PRAGMA application_id") != application_id)
    throw DamagedStore(file.string() + " is damaged: it is no store of a run");
  if (const auto version = database_.integer_of("PRAGMA user_version"); version != store_version)
    throw UsageError(file.string() + " has version " + std::to_string(version) +
                     " of the store's format; this host reads version " +
                     std::to_string(store_version));
  if (access != Database::Access::write) return;
  verify();
  // A write-ahead log: others may read meanwhile, and a commit is one write at the end of a file.
  database_.execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL");
  // Room for what a generation has just written: it is read again for its checksum and the CSV
  // files.
  database_.execute("PRAGMA cache_size=-32768");
}

Store::~Store() { rollback(); }

StoreMeta Store::meta() const {
  return {database_.text_of("SELECT value FROM meta WHERE key = 'original_yaml'"),
          database_.text_of("SELECT value FROM meta WHERE key = 'resolved_yaml'")};
}

void Store::set_meta(const StoreMeta& meta) {
  database_.execute("BEGIN");
  put_meta(database_, meta);
  database_.execute("COMMIT");
}

void Store::verify() const {
  const std::string fault = database_.text_of("PRAGMA quick_check(1)");
  if (fault != "ok") throw DamagedStore(database_.file().string() + " is damaged: " + fault);

  if (checksum_of(meta()) != database_.text_of("SELECT value FROM meta WHERE key = 'checksum'"))
    throw DamagedStore(database_.file().string() +
                       " is damaged: the experiment does not have the checksum that it had");
  Statement rows(database_,
                 "SELECT generation, population, checksum FROM generations "
                 "ORDER BY population, generation");
  std::int64_t expected = 0, population = 1;
  std::vector<std::int64_t> counts;
  while (rows.step()) {
    if (rows.integer(1) != population) {
      counts.push_back(expected);
      ++population;
      expected = 0;
    }
    const auto damaged = [&](const std::string& what) {
      throw DamagedStore(database_.file().string() + " is damaged: generation " +
                         std::to_string(rows.integer(0)) + ", population " +
                         std::to_string(rows.integer(1)) + ": " + what);
    };
    if (rows.integer(0) != expected++ || rows.integer(1) != population)
      damaged("not the one that should follow");
    const std::string recorded = hex_bytes(rows.bytes(2));
    if (recorded != hex_bytes(checksum_of_generation(database_, rows.natural(0),
                                                     static_cast<std::uint32_t>(rows.integer(1)))))
      damaged("its rows do not have the checksum that they had");
  }
  for (const std::int64_t count : counts)
    if (count != expected)
      throw DamagedStore(database_.file().string() +
                         " is damaged: one population has more generations than the other");
  verify_journal(database_);
}

std::uint64_t Store::generations() const {
  return static_cast<std::uint64_t>(
      database_.integer_of("SELECT count(*) FROM generations WHERE population = 1"));
}

std::vector<evolution::Population> Store::populations(std::uint64_t generation) const {
  std::vector<evolution::Population> populations;
  Statement individuals(database_,
                        "SELECT population, id, parent1, parent2, operator, fitness, controller, "
                        "tree FROM individuals WHERE population = ? AND generation = ? "
                        "ORDER BY id");
  Statement trials(database_,
                   "SELECT fitness FROM trials WHERE population = ? AND generation = ? AND "
                   "individual = ? ORDER BY trial");
  Statement failed(database_,
                   "SELECT count(*) FROM trials JOIN failures USING (task) WHERE population = ? "
                   "AND trials.generation = ? AND individual = ?");
  for (std::uint32_t population = 1; population <= 2; ++population) {
    evolution::Population members;
    individuals.with(population, generation);
    while (individuals.step()) {
      evolution::Individual& individual = members.emplace_back();
      individual.id = individuals.natural(1);
      for (const int column : {2, 3})
        if (!individuals.is_null(column)) individual.parents.push_back(individuals.natural(column));
      const auto origin = evolution::operator_named(individuals.text(4));
      if (!origin)
        throw DamagedStore(database_.file().string() + " is damaged: no operator is called '" +
                           std::string(individuals.text(4)) + "'");
      individual.origin = *origin;
      individual.fitness = individuals.real(5);
      const Bytes controller = individuals.bytes(6), tree = individuals.bytes(7);
      individual.genome.controller.assign(controller.begin(), controller.end());
      individual.genome.tree.assign(tree.begin(), tree.end());
      trials.with(population, generation, individual.id);
      while (trials.step()) individual.trials.push_back(trials.real(0));
      failed.with(population, generation, individual.id).step();
      individual.set_aside = failed.natural(0) > 0;
      failed.run();
    }
    if (!members.empty()) populations.push_back(std::move(members));
  }
  return populations;
}

std::vector<FormerChampion> Store::champions() const {
  std::vector<FormerChampion> champions;
  Statement rows(database_,
                 "SELECT individuals.id, controller, tree FROM generations JOIN individuals "
                 "USING (population, generation) WHERE population = 1 AND "
                 "individuals.id = champion_id ORDER BY generation");
  while (rows.step()) {
    FormerChampion& champion = champions.emplace_back();
    champion.id = rows.natural(0);
    const Bytes controller = rows.bytes(1), tree = rows.bytes(2);
    champion.genome.controller.assign(controller.begin(), controller.end());
    champion.genome.tree.assign(tree.begin(), tree.end());
  }
  return champions;
}

std::optional<Store::Best> Store::best() const {
  Statement rows(database_,
                 "SELECT best, generation FROM generations ORDER BY best DESC, generation LIMIT 1");
  if (!rows.step()) return std::nullopt;
  return Best{rows.real(0), rows.natural(1)};
}

std::optional<Store::Last> Store::last() const {
  Statement rows(database_,
                 "SELECT best, median FROM generations WHERE population = 1 "
                 "ORDER BY generation DESC LIMIT 1");
  if (!rows.step()) return std::nullopt;
  return Last{rows.real(0), rows.real(1)};
}

std::uint64_t Store::failures() const {
  return static_cast<std::uint64_t>(database_.integer_of("SELECT count(*) FROM failures"));
}

std::string Store::champion_hash(std::uint64_t generation, std::uint32_t population) const {
  Statement row(database_,
                "SELECT champion_xxh3_128 FROM generations WHERE generation = ? AND "
                "population = ?");
  return row.with(generation, population).step() ? std::string(row.text(0)) : "";
}

void Store::add(std::span<const Generation> populations, const Timing& timing) {
  // What the journal has open belongs to earlier work; this commit, unlike its own, is flushed.
  if (database_.in_transaction()) database_.execute("COMMIT");
  database_.execute("PRAGMA synchronous=FULL; BEGIN IMMEDIATE");
  for (const Generation& generation : populations) add(generation);
  Statement statement(database_, "INSERT INTO timing VALUES (?, ?, ?, ?)");
  statement.with(populations.front().number, timing.seconds, timing.threads, now_utc()).run();
}

void Store::add(const Generation& generation) {
  const std::uint32_t population = std::max(1u, generation.champion.population);
  const std::uint64_t number = generation.number;
  const auto& members = *generation.population;

  Statement individuals(database_,
                        "INSERT INTO individuals VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  Statement trials(database_, "INSERT INTO trials VALUES (?, ?, ?, ?, ?, ?, ?)");
  std::size_t place = 0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const evolution::Individual& member = members[i];
    std::optional<std::string_view> opponents;
    if (!generation.opponents.empty()) opponents = generation.opponents[i];
    individuals
        .with(population, number, member.id, parent(member, 0), parent(member, 1),
              evolution::name_of(member.origin), member.fitness, member.genome.length(), opponents,
              Bytes(member.genome.controller), Bytes(member.genome.tree))
        .run();
    for (std::uint64_t trial = 0; trial < member.trials.size(); ++trial, ++place)
      trials
          .with(population, number, member.id, trial, member.trials[trial],
                Bytes(generation.places[place].task), generation.places[place].seat)
          .run();
  }

  const evolution::Statistics& s = generation.statistics;
  const Outcome& life = generation.champion.life.outcome;
  Statement row(database_,
                "INSERT INTO generations VALUES "
                "(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, NULL)");
  row.with(number, population, s.best, s.upper_quartile, s.median, s.lower_quartile, s.worst,
           s.mean, generation.champion.individual.id,
           generation.champion.individual.genome.length(), life.survival, life.censored,
           life.divisions, life.specializations, life.peak_cells, life.biomass_share,
           generation.champion_hash, generation.evaluations, generation.censored,
           generation.refused_divisions, generation.cell_steps)
      .run();
  const TaskKey checksum = checksum_of_generation(database_, number, population);
  Statement update(database_,
                   "UPDATE generations SET checksum = ? WHERE population = ? AND generation = ?");
  update.with(Bytes(checksum), population, number).run();
}

void Store::commit() { database_.execute("COMMIT; PRAGMA synchronous=NORMAL"); }

void Store::rollback() noexcept {
  if (!database_.in_transaction()) return;
  sqlite3_exec(database_.handle(), "ROLLBACK; PRAGMA synchronous=NORMAL", nullptr, nullptr,
               nullptr);
}

void Store::note_session(unsigned workers) {
  Statement row(database_, "INSERT INTO sessions VALUES (NULL, ?, ?, ?, ?, ?, NULL, NULL)");
  row.with(now_utc(), host_name(), static_cast<std::int64_t>(::getpid()), workers, generations())
      .run();
}

void Store::note_reference(const evaluation::Reference& reference) {
  Statement row(database_,
                "UPDATE sessions SET canary = ?, reference = ? WHERE session = "
                "(SELECT max(session) FROM sessions)");
  row.with(std::uint64_t{reference.canary}, std::string_view(reference.hash)).run();
}

std::optional<evaluation::Reference> Store::reference() const {
  Statement row(database_,
                "SELECT canary, reference FROM sessions WHERE reference IS NOT NULL "
                "ORDER BY session DESC LIMIT 1");
  if (!row.step()) return std::nullopt;
  return evaluation::Reference{static_cast<std::uint32_t>(row.natural(0)),
                               std::string(row.text(1))};
}

void Store::settle() noexcept {
  sqlite3_busy_timeout(database_.handle(), 0);
  sqlite3_exec(database_.handle(), "PRAGMA journal_mode=DELETE", nullptr, nullptr, nullptr);
}

TaskKey checksum_of_generation(const Database& database, std::uint64_t generation,
                               std::uint32_t population) {
  Hasher hasher;
  Statement summary(database,
                    "SELECT generation, population, best, q3, median, q1, worst, mean, "
                    "champion_id, champion_genome_length, champion_survival, champion_censored, "
                    "champion_divisions, champion_specializations, champion_peak_cells, "
                    "champion_biomass_share, champion_xxh3_128, evaluations, censored, "
                    "refused_divisions, cell_steps FROM generations "
                    "WHERE population = ? AND generation = ?");
  hash_rows(summary.with(population, generation), hasher);
  Statement individuals(database,
                        "SELECT * FROM individuals WHERE population = ? AND generation = ? "
                        "ORDER BY id");
  hash_rows(individuals.with(population, generation), hasher);
  Statement trials(database,
                   "SELECT * FROM trials WHERE population = ? AND generation = ? "
                   "ORDER BY individual, trial");
  hash_rows(trials.with(population, generation), hasher);
  return hasher.key();
}

}  // namespace somas::run
