// An experiment as a value: everything that an experiment file says, resolved and validated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/evolution/settings.hpp"
#include "core/experiment/record_settings.hpp"
#include "core/model/config.hpp"
#include "core/model/ecosystem.hpp"

namespace somas::plugins {
class Library;
}

namespace somas::experiment {

/// A place in a YAML file. Lines and columns count from 1; 0: not from a file (then `origin` says
/// where, e.g. "--set seed=x").
struct Position {
  std::string origin;
  std::size_t line = 0;
  std::size_t column = 0;

  [[nodiscard]] std::string text() const;  ///< "exp1.yaml:3:5"
};

/// Bad input: position, key, what is allowed, a suggestion. what() is the whole message; exit
/// code 2.
class InputError : public std::runtime_error {
 public:
  InputError(Position position, const std::string& message);
  [[nodiscard]] const Position& position() const { return position_; }

 private:
  Position position_;
};

/// A plugin class in use.
struct PluginUse {
  std::string id;       ///< of the class, as in the file
  std::string version;  ///< of its library
};

/// A loaded experiment. `ecosystem` is wired and validated; it keeps its plugins alive.
struct Experiment {
  std::string name;
  std::uint64_t seed = 1;
  evolution::Settings evolution;
  RecordSettings record;
  std::shared_ptr<const model::Ecosystem> ecosystem;
  PluginUse specialization, controller;  ///< who can read genomes

  std::string original_yaml;    ///< the experiment file, byte for byte
  std::string resolved_yaml;    ///< every key with its value, loadable again, extends folded in
  std::string simulation_yaml;  ///< of these, what decides a simulation: world and plugins' blocks

  /// A library in use, for the manifest.
  struct Library {
    std::filesystem::path file;
    std::string plugin_id, version, fingerprint;
    std::vector<std::string> classes;  ///< ids in use by this experiment
  };
  std::vector<Library> libraries;
};

/// A value that is to be replaced: "path.to.key=value".
struct Override {
  std::string text;
  Position position;      ///< of the value
  Position key_position;  ///< of the key
};

struct LoadOptions {
  std::vector<std::string> overrides;                     ///< "path.to.key=value" (--set), in order
  std::vector<std::filesystem::path> plugin_directories;  ///< --plugin-path
  /// Plugins that are linked into this program; if given, no files are looked for.
  std::shared_ptr<const plugins::Library> linked_in{};
  std::vector<Override> levels{};  ///< of a sweep's factors, after --set
};

/// Reads, resolves, validates and wires. Throws InputError.
[[nodiscard]] Experiment load(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace somas::experiment
