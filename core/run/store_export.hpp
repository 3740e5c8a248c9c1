// Text out of the store: the CSV files of a run, and a dump of all results.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "core/evolution/settings.hpp"
#include "core/run/sqlite.hpp"

namespace somas::run {

/// A file of a run that comes from the store, line by line.
struct ExportedFile {
  const char* name;  ///< "generations.csv"
  std::string header;
  /// The lines of a generation; those that are being added count.
  std::function<std::string(const Database&, std::uint64_t generation)> lines;
};

/// generations.csv, individuals.csv, phylogeny.csv and timing.csv, in this order.
[[nodiscard]] std::vector<ExportedFile> exported_files(evolution::Mode mode);

/// Every row of every table of results, as text in a fixed order: two stores with the same dump
/// hold the same results. Calls `put` with a piece at a time.
void dump(const Database& database, const std::function<void(std::string_view)>& put);

}  // namespace somas::run
