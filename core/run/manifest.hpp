// Where a run came from: versions, plugins and their hashes, build, processor, seed, command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"
#include "core/run/json.hpp"

namespace somas::run {

/// A saved genome that seeds the first generation.
struct GivenGenome {
  std::filesystem::path file;
  std::string text;
};

/// No clock and nothing random in it: two runs of the same command on one machine give one manifest.
[[nodiscard]] Json manifest_of(const experiment::Experiment& experiment,
                               const std::filesystem::path& file,
                               const std::vector<std::string>& command_line,
                               const std::vector<GivenGenome>& genomes);

/// What differs between the plugins of a manifest and those in use now, a sentence each.
[[nodiscard]] std::vector<std::string> changed_plugins(const Json& manifest,
                                                       const std::string& origin,
                                                       const experiment::Experiment& now);

}  // namespace somas::run
