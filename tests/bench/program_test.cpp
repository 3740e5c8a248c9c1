// The benchmarks' results as files, and the roofline on its page.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/core/run/scratch.hpp"

namespace somas::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

struct Ended {
  int code = -1;
  std::string output;
};

/// The program with these arguments, a shell's; what it prints on both streams unless redirected.
Ended bench(const std::string& arguments) {
  const std::string command = "exec '" SOMAS_BINARY_DIR "/bench/bench_somas' " + arguments;
  std::FILE* pipe = ::popen(("{ " + command + "; } 2>&1").c_str(), "r");
  if (pipe == nullptr) return {};
  Ended ended;
  std::array<char, 4096> part{};
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    ended.output.append(part.data(), n);
  const int status = ::pclose(pipe);
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ended;
}

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What stays the same from one measurement to the next: no numbers, no name of a processor, nor
/// what bounds a phase.
std::string skeleton(const std::string& text) {
  std::string lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("One core of: ")) line = "One core of: it";
    line = std::regex_replace(line, std::regex("[0-9]+(\\.[0-9]+)?( %)?|\\| - \\|"), "#");
    line = std::regex_replace(line, std::regex("\\| (arithmetic|roots, divisions|L#|DRAM) \\| #"),
                              "| bound | #");
    lines += line + "\n";
  }
  return lines;
}

/// The part of the page that the command writes.
std::string roofline_of_the_page() {
  const std::string page = read(SOMAS_SOURCE_DIR "/docs/roofline.md");
  const std::string mark = "<!-- measured: roofline -->\n\n";
  const std::size_t begin = page.find(mark), end = page.find("\n<!-- end -->", begin);
  if (begin == std::string::npos || end == std::string::npos) return "no roofline on the page";
  return page.substr(begin + mark.size(), end - begin - mark.size());
}

TEST(Bench, WritesJsonWithTimesAndCounters) {
  const Scratch scratch;
  const std::filesystem::path file = scratch.path() / "results.json";
  // Two benchmarks with different counters.
  const Ended ended = bench(
      "--benchmark_filter='^expression|controller_step/cells:100/' "
      "--benchmark_min_time=0.001 --benchmark_out='" +
      file.string() + "'");
  ASSERT_EQ(ended.code, 0) << ended.output;
  const json results = json::parse(read(file));
  ASSERT_EQ(results.at("benchmarks").size(), 2u);
  for (const json& benchmark : results.at("benchmarks")) {
    EXPECT_GT(benchmark.at("cpu_time").get<double>(), 0) << benchmark;
    EXPECT_FALSE(benchmark.contains("error_occurred")) << benchmark;
    const bool has_cells = benchmark.at("name").get<std::string>().starts_with("controller_step");
    EXPECT_EQ(benchmark.contains("time/cell"), has_cells) << benchmark;
  }
}

TEST(Bench, LivesInColoniesAsInTheRecordedLife) {
  const Scratch scratch;
  const std::filesystem::path file = scratch.path() / "results.json";
  const Ended ended = bench(
      "--benchmark_filter='whole_step/cells:1000/' "
      "--benchmark_min_time=0.2 --benchmark_out='" +
      file.string() + "'");
  ASSERT_EQ(ended.code, 0) << ended.output;
  const json results = json::parse(read(file)).at("benchmarks").at(0);
  EXPECT_NEAR(results.at("cells").get<double>(), 1000, 100);
  // The recorded life, steps 700 to 850: 0.0055 births and 0.0066 deaths a cell-step.
  EXPECT_NEAR(results.at("births/step/cell").get<double>(), 0.006, 0.003);
  EXPECT_NEAR(results.at("deaths/step/cell").get<double>(), 0.007, 0.003);
  EXPECT_NEAR(results.at("particles/cell").get<double>(), 9.5, 1.5);
  EXPECT_LE(results.at("bytes/cell").get<double>(), 300);
}

TEST(Bench, RefusesCsvWithAReason) {
  for (const char* option : {"--benchmark_format=csv", "--benchmark_out_format=csv"}) {
    const Ended ended = bench(option);
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.output, HasSubstr("there is no CSV")) << option;
    EXPECT_THAT(ended.output, HasSubstr("JSON")) << option;
  }
}

TEST(Bench, RefusesUnknownOptions) {
  EXPECT_EQ(bench("--bench_filter=mechanics").code, 2);
  const Ended ended = bench("--roofline --quik");
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.output, HasSubstr("--roofline [--json | --update]"));
}

TEST(Roofline, HasTheRowsAndColumnsOfItsPage) {
  const Ended ended = bench("--roofline --quick");
  ASSERT_EQ(ended.code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("| finding pairs |"));
  EXPECT_EQ(skeleton(ended.output), skeleton(roofline_of_the_page()))
      << "renew it with: ./dev bench --roofline --update";
}

TEST(Roofline, AsJsonHasWorkAndTimeOfEveryPhase) {
  const Ended ended = bench("--roofline --quick --json");
  ASSERT_EQ(ended.code, 0) << ended.output;
  const json roofline = json::parse(ended.output);
  for (const auto& [name, ceiling] : roofline.at("ceilings").items())
    EXPECT_GT(ceiling.get<double>(), 0) << name;
  ASSERT_EQ(roofline.at("worlds").size(), 2u);
  for (const json& world : roofline.at("worlds")) {
    EXPECT_EQ(world.at("phases").size(), 11u);
    for (const json& phase : world.at("phases")) {
      EXPECT_GT(phase.at("bytes").get<double>(), 0) << phase;
      EXPECT_GT(phase.at("least_seconds").get<double>(), 0) << phase;
    }
  }
}

}  // namespace
}  // namespace somas::test
