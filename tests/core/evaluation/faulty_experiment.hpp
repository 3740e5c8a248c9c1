// Experiments on plugins from files, which evaluator processes can load, with faults on demand.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "core/evaluation/evaluator.hpp"
#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"

namespace somas::test {

/// A file of its own in the directory for temporary files; removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text = {}) {
    static int number = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("somas-" + std::to_string(::getpid()) + "-" + std::to_string(number++) + ".yaml");
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline const std::string faulty_plugins = SOMAS_BINARY_DIR "/tests/fixtures/faulty";

/// `settings`: of the faulty environment, as in YAML ("fault: throw, step: 3"); `directory`: where
/// its file is.
inline experiment::Experiment faulty_experiment(const std::string& settings = {},
                                                const std::string& directory = faulty_plugins) {
  const TemporaryFile file(
      "somas: 1\nname: faulty\nseed: 5\n"
      "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " +
      directory +
      "]\n"
      "world: {max_steps: 60, max_cells: 20, morphogens: {size: 9}}\n"
      "evolution: {population: 12, generations: 3}\n"
      "environments:\n  field: {plugin: faulty_environment, " +
      settings +
      "}\n"
      "  hazard: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
      "specialization: {plugin: toy_tree}\n"
      "controller: {plugin: toy_controller}\n"
      "fitness: {plugin: toy_fitness}\n");
  return experiment::load(file.path());
}

/// Tasks of one organism each, with genomes of their own.
class Work {
 public:
  Work(const experiment::Experiment& experiment, std::size_t count, std::uint64_t seed = 5) {
    const evolution::Heredity heredity(*experiment.ecosystem);
    genomes_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      Rng rng(99, 0, 0, 0, i);
      genomes_.push_back(heredity.random(rng));
      tasks_.push_back({.roster = {{.genome = &genomes_.back()}}, .seed = seed});
    }
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  [[nodiscard]] const std::vector<evaluation::Task>& tasks() const { return tasks_; }
  [[nodiscard]] std::vector<evaluation::Task>& tasks() { return tasks_; }

 private:
  std::vector<model::Genome> genomes_;
  std::vector<evaluation::Task> tasks_;
};

}  // namespace somas::test
