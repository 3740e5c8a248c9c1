// A run on disk. Layout:
//
//   experiment.yaml          the experiment file, byte for byte
//   resolved.yaml            every key with its value; loads again
//   manifest.json            where the run came from; with it the run has begun
//   run.sqlite               all results (store.hpp); the next four files come from it
//   generations.csv          a line a generation
//   individuals.csv          a line an individual: lineage
//   phylogeny.csv            the same in the ALife data standard
//   timing.csv               all that depends on the clock
//   champions/gen-0000.json  the best of each generation, with its recorded life
//   champions/gen-0000-2.json  the same of the second population, in mode coevolution
//   recordings/gen-0003.h5   recorded lives, if the experiment wants them
//   genomes/given-0.json     saved genomes that seeded the first generation, if any
//   states/                  worlds in mid-life that a replay saved, if any
//   summary.json             how the run ended
//   crash.txt                which plugin crashed the coordinator, if one did
//   run.lock                 while a process works on it
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "core/run/manifest.hpp"
#include "core/run/run_lock.hpp"
#include "core/run/store.hpp"
#include "core/run/store_export.hpp"

namespace somas::run {

/// champions/gen-NNNN.json; of the second population champions/gen-NNNN-2.json.
[[nodiscard]] std::filesystem::path champion_path(const std::filesystem::path& run,
                                                  std::uint64_t generation,
                                                  std::uint32_t population = 1);

/// crash.txt of a run.
[[nodiscard]] std::filesystem::path crash_path(const std::filesystem::path& run);

/// The greatest generation with a champion in `run`. Throws UsageError if there is none.
[[nodiscard]] std::uint64_t last_generation(const std::filesystem::path& run);

/// The champion's id that generations.csv has for a generation; nothing if it has none.
[[nodiscard]] std::optional<std::uint64_t> champion_id(const std::filesystem::path& run,
                                                       std::uint64_t generation,
                                                       std::uint32_t population = 1);

/// Makes the directory of a new run: `out`, which must be absent or empty (UsageError), or
/// runs/NAME-seedSEED, with -2, -3, ... as often as it takes. A directory in which a run was killed
/// before it began counts as empty. Throws WriteError.
[[nodiscard]] std::filesystem::path make_run_directory(
    const std::optional<std::filesystem::path>& out, const std::string& name, std::uint64_t seed);

/// The same for a campaign: `out`, or runs/NAME-campaign.
[[nodiscard]] std::filesystem::path make_campaign_directory(
    const std::optional<std::filesystem::path>& out, const std::string& name);

/// Removes what a start that was killed has left in a directory; its lock must be held. Throws
/// UsageError if there is more.
void clear_beginning(const std::filesystem::path& directory);

/// Removes temporary files that a kill has left in a directory. Throws WriteError.
void remove_temporary_files(const std::filesystem::path& directory);

/// Makes a directory in one that exists, unless it is there already. Throws WriteError.
void make_directory_in(const std::filesystem::path& path);

/// Whether a run has begun in the directory.
[[nodiscard]] bool holds_run(const std::filesystem::path& directory);

/// The files of a run in the making; nobody else can work on it meanwhile. All calls throw
/// WriteError.
class RunDirectory {
 public:
  /// Begins a run in an empty directory. Throws UsageError if it is in use, or not empty any more.
  RunDirectory(std::filesystem::path path, const experiment::Experiment& experiment,
               const Json& manifest, std::span<const GivenGenome> genomes);
  /// Opens a run that has begun; open_files() has to follow. Throws UsageError if it is in use,
  /// DamagedStore.
  explicit RunDirectory(std::filesystem::path path);

  /// Makes the files agree with the store: what a kill left behind goes, the CSV files are written
  /// anew.
  void open_files(const experiment::Experiment& experiment);
  /// The experiment has changed, and so have its files.
  void replace_experiment(const StoreMeta& meta);

  /// A generation gets onto the disk whole, one record per population; if it cannot, nothing of it
  /// stays.
  void commit(std::span<Generation> populations, const evolution::Heredity& heredity,
              const Timing& timing);
  /// Replaces the summary.
  void summarize(const Json& summary);
  /// Flushes everything; the store becomes one plain file.
  void close();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Store& store() { return *store_; }

 private:
  void remove_leftovers() const;

  std::filesystem::path path_;
  RunLock lock_;
  GenomeOwners owners_;
  std::optional<Store> store_;
  std::vector<ExportedFile> exported_;
  std::vector<std::unique_ptr<AppendFile>> files_;  ///< as exported_
};

}  // namespace somas::run
