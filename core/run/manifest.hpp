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

/// How a run was asked for.
struct Request {
  std::filesystem::path file;  ///< the experiment
  std::vector<std::string> command_line{};
  std::vector<std::filesystem::path> plugin_path{};  ///< --plugin-path
  std::vector<GivenGenome> genomes{};
};

/// No clock and nothing random in it: two runs of the same command on one machine give one
/// manifest.
[[nodiscard]] Json manifest_of(const experiment::Experiment& experiment, const Request& request);

/// The --plugin-path of the run, absolute.
[[nodiscard]] std::vector<std::filesystem::path> plugin_path_of(const Json& manifest,
                                                                const std::string& origin);

/// What differs between the plugins of a manifest and those in use now, a sentence each.
[[nodiscard]] std::vector<std::string> changed_plugins(const Json& manifest,
                                                       const std::string& origin,
                                                       const experiment::Experiment& now);

}  // namespace somas::run
