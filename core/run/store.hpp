// The database of a run, run.sqlite: all results, and the journal of evaluations. Its tables are
// described in docs/cluster.md.
//
// What depends on the clock stands in tables of its own (timing, sessions); the others hold the
// same rows for the same run, however often it was stopped and wherever it was evaluated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/evolution/ranking.hpp"
#include "core/run/champion.hpp"
#include "core/run/contest.hpp"
#include "core/run/sqlite.hpp"
#include "core/run/task_key.hpp"

namespace somas::run {

/// An evaluated generation of one population.
struct Generation {
  std::uint64_t number = 0;
  const evolution::Population* population = nullptr;
  evolution::Statistics statistics;
  Champion champion;
  std::string champion_hash;             ///< XXH3-128 of the champion's file
  std::uint64_t evaluations = 0;         ///< simulations
  std::uint64_t censored = 0;            ///< of them, alive at the end
  std::uint64_t refused_divisions = 0;   ///< by the cap on cells, summed
  double cell_steps = 0;                 ///< summed
  std::vector<std::string> opponents{};  ///< of each individual; empty in mode solo

  /// Where an individual sat in a trial.
  struct Place {
    TaskKey task;
    std::uint64_t seat = 0;
  };
  std::vector<Place> places{};  ///< by individual, then trial
};

struct Timing {
  double seconds = 0;
  unsigned threads = 1;
};

/// The name of the store in a run directory.
inline constexpr const char* store_name = "run.sqlite";

/// What a run is, written when it begins.
struct StoreMeta {
  std::string original_yaml, resolved_yaml;
};

/// One connection to the store of a run; used by one thread at a time. All calls throw WriteError
/// and DamagedStore.
class Store {
 public:
  /// Makes the file, which must not exist, with empty tables.
  static void create(const std::filesystem::path& file, const StoreMeta& meta);

  /// Opens the store of a run. Access::write also verifies all of it: structure, and a checksum of
  /// every generation and evaluation.
  Store(const std::filesystem::path& file, Database::Access access);
  ~Store();

  [[nodiscard]] StoreMeta meta() const;
  void set_meta(const StoreMeta& meta);

  /// Finished ones; they are 0, 1, ...
  [[nodiscard]] std::uint64_t generations() const;
  /// The populations of a finished generation, evaluated.
  [[nodiscard]] std::vector<evolution::Population> populations(std::uint64_t generation) const;
  /// The champions of all finished generations, of the first population.
  [[nodiscard]] std::vector<FormerChampion> champions() const;
  struct Best {
    double fitness = 0;
    std::uint64_t generation = 0;
  };
  /// Over all finished generations; the earliest of equals.
  [[nodiscard]] std::optional<Best> best() const;
  /// Of the last finished generation, of the first population.
  struct Last {
    double best = 0, median = 0;
  };
  [[nodiscard]] std::optional<Last> last() const;
  /// Simulations that were set aside.
  [[nodiscard]] std::uint64_t failures() const;
  /// XXH3-128 of the champion's file.
  [[nodiscard]] std::string champion_hash(std::uint64_t generation, std::uint32_t population) const;

  /// Adds a generation, one record per population, to the transaction that is open or is opened by
  /// this. Until commit() nothing of it is there.
  void add(std::span<const Generation> populations, const Timing& timing);
  /// On the disk when this returns.
  void commit();
  void rollback() noexcept;

  /// Notes that somebody went on with the run.
  void note_session(unsigned workers);
  /// What the reference simulation gives, in the session that was noted last.
  void note_reference(const evaluation::Reference& reference);
  /// The one noted last, in any session.
  [[nodiscard]] std::optional<evaluation::Reference> reference() const;
  /// Makes the store one plain file, readable where nothing may be written. For the end of a run;
  /// does nothing while others read it.
  void settle() noexcept;

  [[nodiscard]] const Database& database() const { return database_; }

 private:
  void verify() const;
  void add(const Generation& generation);

  Database database_;
};

/// "2026-01-31T23:59:59Z", now.
[[nodiscard]] std::string now_utc();

/// XXH3-128 of the rows that make a finished generation (without the checksum itself).
[[nodiscard]] TaskKey checksum_of_generation(const Database& database, std::uint64_t generation,
                                             std::uint32_t population);

}  // namespace somas::run
