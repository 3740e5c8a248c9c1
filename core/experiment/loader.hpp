// From an experiment file to a wired Experiment; see experiment.hpp for the entrance.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"
#include "core/experiment/keys.hpp"
#include "core/experiment/node.hpp"
#include "core/experiment/validate.hpp"
#include "core/plugins/registry.hpp"

namespace somas::experiment {

/// Where plugins are looked for when no file says more: --plugin-path, then the standard places.
/// Throws InputError for a directory that is none.
[[nodiscard]] std::vector<plugins::SearchDirectory> search_path(
    const std::vector<std::filesystem::path>& plugin_directories);

/// One loading; the steps of load() in order.
class Loader {
 public:
  Loader(std::filesystem::path file, const LoadOptions& options)
      : file_(std::move(file)), options_(options) {}

  [[nodiscard]] Experiment load();

 private:
  // A plugin's block of the file: the class it names and the parameters it gives.
  struct Block {
    std::string path;      // "environments.nutrients"
    std::string instance;  // the name that the model knows it by
    const Node* node;
    plugins::PluginClass plugin;
    plugins::ParameterValue parameters;
  };

  void read();
  void check_core();
  void find_plugins();
  void check_blocks();
  void wire();
  void check_states() const;
  [[nodiscard]] std::string resolved() const;
  [[nodiscard]] std::string simulation_part() const;
  [[nodiscard]] PluginUse plugin_of(const std::string& instance) const;
  [[nodiscard]] std::vector<Experiment::Library> libraries() const;

  void check_environments();
  [[nodiscard]] bool only_set(const Node& environment) const;
  [[nodiscard]] std::string no_such_environment(const std::string& name) const;
  void check_single(PluginKind kind);
  void check_block(PluginKind kind, const Node& node, const std::string& path,
                   const std::string& instance, const std::string& default_plugin);
  template <class Interface>
  [[nodiscard]] std::shared_ptr<Interface> create(const Block& block) const;
  [[nodiscard]] const Block& block(const std::string& instance) const;
  [[noreturn]] void blame(const std::string& instance, const std::string& path,
                          const std::string& message) const;

  std::filesystem::path file_;
  LoadOptions options_;
  Problems problems_;
  Validator validator_{problems_};
  std::string text_;
  Node root_;
  std::vector<std::string> environments_;  // of the file, before --set
  plugins::ParameterValue core_;
  CoreValues values_;
  std::vector<std::filesystem::path> directories_;  // of the file's `plugins`, absolute
  std::optional<plugins::Registry> registry_;
  std::vector<Block> blocks_;
  std::shared_ptr<const model::Ecosystem> ecosystem_;
};

}  // namespace somas::experiment
