// Runs of somas-host on toy plugins, and whether two of them are the same.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/host/results.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas::test {

inline const std::string toy_yaml =
    "somas: 1\n"
    "name: toy\n"
    "seed: 5\n"
    "plugins: [" SOMAS_BINARY_DIR
    "/tests/fixtures/plugins]\n"
    "world: {max_steps: 200, max_cells: 20, morphogens: {size: 9}}\n"
    "evolution: {population: 12, generations: 3}\n"
    "environments:\n"
    "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
    "specialization: {plugin: toy_tree}\n"
    "controller: {plugin: toy_controller}\n"
    "fitness: {plugin: toy_fitness}\n";

class ToyRuns : public testing::Test {
 protected:
  ToyRuns() { run::write_file(path("toy.yaml"), toy_yaml); }

  [[nodiscard]] std::filesystem::path path(const std::string& name) const {
    return scratch_.path() / name;
  }
  [[nodiscard]] std::string text(const std::string& name) const {
    return run::read_file(path(name));
  }

  /// Runs to the end; the exit code.
  int host(std::vector<std::string> arguments) {
    HostProcess process(scratch_.path(), std::move(arguments));
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }

  /// Finished generations of a run, as its file tells them.
  [[nodiscard]] std::size_t generations_in(const std::string& run) const {
    std::error_code error;
    if (!std::filesystem::exists(path(run) / "generations.csv", error)) return 0;
    const std::string lines = text(run + "/generations.csv");
    const auto count = std::count(lines.begin(), lines.end(), '\n');
    return count > 0 ? static_cast<std::size_t>(count - 1) : 0;
  }

  void expect_same(const std::string& one, const std::string& other) const {
    const auto a = results_of(path(one)), b = results_of(path(other));
    EXPECT_GT(a.size(), 5u);
    for (const auto& [name, content] : a) {
      ASSERT_TRUE(b.contains(name)) << name << " is missing in " << other;
      EXPECT_TRUE(content == b.at(name)) << name << " differs between " << one << " and " << other;
    }
    EXPECT_EQ(a.size(), b.size());
  }

  Scratch scratch_;
  std::string out_, err_;
};

}  // namespace somas::test
