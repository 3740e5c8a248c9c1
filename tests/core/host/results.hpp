// All results of a run, to compare it with another.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/run/files.hpp"
#include "core/run/store.hpp"
#include "core/run/store_export.hpp"

namespace somas::test {

/// The files of a run by name, and the dump of its store. What depends on the clock, the command
/// line or the order of work is left out.
inline std::map<std::string, std::string> results_of(const std::filesystem::path& run) {
  std::map<std::string, std::string> results;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(run)) {
    const std::string name = std::filesystem::relative(entry.path(), run).string();
    if (!entry.is_regular_file() || name == "timing.csv" || name == "manifest.json" ||
        name == run::store_name)
      continue;
    results[name] = run::read_file(entry.path());
  }
  const run::Store store(run / run::store_name, run::Database::Access::read);
  run::dump(store.database(), [&](std::string_view piece) { results["(store)"] += piece; });
  return results;
}

}  // namespace somas::test
