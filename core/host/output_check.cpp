#include "core/host/output_check.hpp"

#include <array>
#include <string>
#include <string_view>

#include "core/run/errors.hpp"
#include "core/run/files.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 14> files_of_a_run = {
    "experiment.yaml", "resolved.yaml", "manifest.json", "generations.csv",    "individuals.csv",
    "phylogeny.csv",   "timing.csv",    "summary.json",  "failed-genome.json", "run.sqlite",
    "champions",       "genomes",       "states",        "recordings"};

}  // namespace

void refuse_file_of_run(const char* option, const fs::path& file, const fs::path& run) {
  const fs::path inside =
      run::target_of(file).lexically_relative(run::target_of(run / ".").lexically_normal());
  if (inside.empty()) return;
  for (const std::string_view name : files_of_a_run)
    if (*inside.begin() == fs::path(name))
      throw run::UsageError(std::string(option) + ": " + file.string() +
                            " belongs to the run, and is never overwritten; name another file");
}

}  // namespace somas::host
