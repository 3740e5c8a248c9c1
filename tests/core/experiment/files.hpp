// Experiment files in a directory that lives as long as a test.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "core/experiment/experiment.hpp"

namespace somas::experiment {

inline const std::filesystem::path toy_plugins = SOMAS_BINARY_DIR "/tests/fixtures/plugins";
inline const std::filesystem::path bad_plugins = SOMAS_BINARY_DIR "/tests/fixtures/bad";

/// The blocks that every experiment needs, in five lines.
inline const std::string blocks =
    "environments:\n  toy_environment: {}\n"
    "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
    "fitness: {plugin: toy_fitness}\n";

class Files : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::path file = directory_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

  static Experiment load_toy(const std::filesystem::path& file,
                             std::vector<std::string> overrides = {}) {
    return load(file, {std::move(overrides), {toy_plugins}});
  }

  /// What load() complains about, with the directory's name left out; empty when it does not.
  std::string complaint_of(const std::filesystem::path& file,
                           std::vector<std::string> overrides = {}) const {
    try {
      static_cast<void>(load_toy(file, std::move(overrides)));
      return "";
    } catch (const InputError& error) {
      std::string text = error.what();
      const std::string prefix = directory_.string() + "/";
      for (std::size_t at; (at = text.find(prefix)) != std::string::npos;)
        text.erase(at, prefix.size());
      return text;
    }
  }
  std::string complaint(const std::string& text, std::vector<std::string> overrides = {}) const {
    return complaint_of(write("e.yaml", text), std::move(overrides));
  }

  std::filesystem::path directory_ = [] {
    std::string name = testing::TempDir() + "somas_experiment_XXXXXX";
    return std::filesystem::path(::mkdtemp(name.data()));
  }();
};

}  // namespace somas::experiment
