#include "core/run/runner.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <sstream>
#include <thread>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>

#include "core/run/progress.hpp"
#include "core/run/replay.hpp"
#include "core/run/run_directory.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;
using test::FullDisk;
using test::Scratch;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  std::istringstream in(read_file(file));
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class Runner : public testing::Test {
 protected:
  RunReport run_into(const std::string& name, const RunOptions& given = {}) {
    RunOptions options = given;
    options.out = scratch_.path() / name;
    options.quiet = true;
    if (options.threads == 0) options.threads = 1;
    return run(experiment_, options, terminal_, stop_);
  }
  std::string text_of(const std::string& file) const { return read_file(scratch_.path() / file); }

  Scratch scratch_;
  Terminal terminal_{stderr};
  experiment::Experiment experiment_ = test::toy_experiment();
  evaluation::StopToken stop_;
};

TEST_F(Runner, LeavesAWholeRunDirectory) {
  const RunReport report = run_into("a", {.command_line = {"somas-host", "toy.yaml"}});
  EXPECT_EQ(report.generations, 4u);
  EXPECT_FALSE(report.stopped);
  EXPECT_THAT(Scratch::names_in(scratch_.path() / "a"),
              ElementsAre("champions", "experiment.yaml", "generations.csv", "individuals.csv",
                          "manifest.json", "phylogeny.csv", "resolved.yaml", "run.sqlite",
                          "summary.json", "timing.csv"));
  EXPECT_THAT(Scratch::names_in(scratch_.path() / "a/champions"),
              ElementsAre("gen-0000.json", "gen-0001.json", "gen-0002.json", "gen-0003.json"));
  EXPECT_EQ(text_of("a/experiment.yaml"), "somas: original\n");
  EXPECT_EQ(text_of("a/resolved.yaml"), "somas: resolved\n");
  EXPECT_THAT(lines_of(scratch_.path() / "a/generations.csv"), SizeIs(1 + 4));
  EXPECT_THAT(lines_of(scratch_.path() / "a/individuals.csv"), SizeIs(1 + 4 * 20));
  EXPECT_THAT(lines_of(scratch_.path() / "a/timing.csv"), SizeIs(1 + 4));
  EXPECT_THAT(text_of("a/summary.json"), HasSubstr("\"status\": \"complete\""));
  EXPECT_EQ(last_generation(scratch_.path() / "a"), 3u);

  const Json manifest = parse_json(text_of("a/manifest.json"), "manifest");
  EXPECT_EQ(manifest["seed"], 11);
  EXPECT_EQ(manifest["objective"], "longevity");
  EXPECT_EQ(manifest["command_line"][1], "toy.yaml");
  EXPECT_THAT(manifest["build"]["flags"].get<std::string>(), HasSubstr("-ffp-contract=off"));
}

TEST_F(Runner, GivesTheSameBytesForAnyNumberOfThreads) {
  run_into("one", {.threads = 1});
  run_into("two", {.threads = 2});
  run_into("five", {.threads = 5});
  for (const char* file : {"generations.csv", "individuals.csv", "champions/gen-0003.json"}) {
    EXPECT_EQ(text_of("one/" + std::string(file)), text_of("two/" + std::string(file)));
    EXPECT_EQ(text_of("one/" + std::string(file)), text_of("five/" + std::string(file)));
  }
}

TEST_F(Runner, AnotherSeedIsAnotherRun) {
  run_into("one");
  experiment_.seed = 12;
  run_into("two");
  EXPECT_NE(text_of("one/generations.csv"), text_of("two/generations.csv"));
}

TEST_F(Runner, TheLineOfAGenerationAgreesWithItsIndividuals) {
  run_into("a");
  const std::vector<std::string> individuals = lines_of(scratch_.path() / "a/individuals.csv");
  double best = 0;
  for (std::size_t i = 1; i <= 20; ++i) {
    std::istringstream fields(individuals[i]);
    std::vector<std::string> field;
    for (std::string text; std::getline(fields, text, ',');) field.push_back(text);
    ASSERT_THAT(field, SizeIs(7));
    EXPECT_EQ(field[4], "random");
    best = std::max(best, std::stod(field[5]));
  }
  std::istringstream line(lines_of(scratch_.path() / "a/generations.csv")[1]);
  std::string number, recorded;
  std::getline(line, number, ',');
  std::getline(line, recorded, ',');
  EXPECT_EQ(number, "0");
  EXPECT_EQ(std::stod(recorded), best);
}

TEST_F(Runner, NeverTouchesAnEarlierRun) {
  run_into("a");
  const std::string before = text_of("a/generations.csv");
  EXPECT_THROW(run_into("a"), UsageError);
  EXPECT_EQ(text_of("a/generations.csv"), before);
}

TEST_F(Runner, TheSlowerOfTwoThatStartAtOnceIsRefused) {
  const fs::path out = make_run_directory(scratch_.path() / "a", "toy", 1);
  const auto refusal = [&]() -> std::string {
    try {
      const RunDirectory second(out, experiment_, Json::object(), {});
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  {
    const RunDirectory first(out, experiment_, Json::object(), {});
    EXPECT_THAT(refusal(), HasSubstr("is in use by process " + std::to_string(::getpid())));
  }
  EXPECT_THAT(refusal(), HasSubstr("is not empty: an earlier run is never overwritten"));
}

TEST_F(Runner, ADirectoryWhoseRunWasKilledBeforeItBeganIsTaken) {
  const fs::path out = scratch_.path() / "a";
  fs::create_directories(out / "champions");
  write_file(out / "experiment.yaml", "half a beginning");
  write_file(out / "run.sqlite", "torn");
  // Without the lock, which comes first, these are somebody's files.
  EXPECT_THROW(run_into("a"), UsageError);
  EXPECT_EQ(text_of("a/experiment.yaml"), "half a beginning");
  write_file(out / "run.lock", "");
  EXPECT_EQ(run_into("a").generations, 4u);
  EXPECT_EQ(text_of("a/experiment.yaml"), "somas: original\n");
}

TEST_F(Runner, AnEmptyDirectoryIsTaken) {
  fs::create_directory(scratch_.path() / "a");
  EXPECT_EQ(run_into("a").generations, 4u);
}

TEST_F(Runner, AFileInTheWayIsABadName) {
  write_file(scratch_.path() / "a", "a file");
  EXPECT_THROW(run_into("a"), UsageError);
}

TEST_F(Runner, ADirectoryThatCannotBeMadeSaysWhy) {
  const auto refusal = [](const fs::path& out) -> std::string {
    try {
      static_cast<void>(make_run_directory(out, "toy", 1));
    } catch (const WriteError& error) {
      return error.what();
    }
    return "";
  };
  // The system itself says "no such file or directory".
  EXPECT_EQ(refusal("/proc/x"),
            "cannot make the directory /proc/x: no directories can be made in /proc");
  EXPECT_EQ(refusal("/proc/x/y"),
            "cannot make the directory /proc/x: no directories can be made in /proc");
  const fs::path file = scratch_.path() / "file";
  write_file(file, "a file");
  EXPECT_THROW(static_cast<void>(make_run_directory(file / "x", "toy", 1)), UsageError);
  EXPECT_THROW(static_cast<void>(make_run_directory(file / "x/y", "toy", 1)), UsageError);
  EXPECT_THROW(static_cast<void>(make_run_directory("", "toy", 1)), UsageError);
  EXPECT_EQ(make_run_directory(scratch_.path() / "new/../other/run/", "toy", 1),
            scratch_.path() / "new/../other/run");
}

TEST_F(Runner, DefaultDirectoriesCountUp) {
  const fs::path here = fs::current_path();
  fs::current_path(scratch_.path());
  EXPECT_EQ(make_run_directory({}, "toy", 3), fs::path("runs/toy-seed3"));
  EXPECT_EQ(make_run_directory({}, "toy", 3), fs::path("runs/toy-seed3-2"));
  EXPECT_EQ(make_run_directory({}, "toy", 3), fs::path("runs/toy-seed3-3"));
  EXPECT_EQ(make_run_directory({}, "../x/y", 3), fs::path("runs/_._x_y-seed3"));
  EXPECT_EQ(make_run_directory({}, "Käfer + 2\n", 3), fs::path("runs/Käfer + 2_-seed3"));
  fs::current_path(here);
}

TEST_F(Runner, AStopBeforeTheFirstGenerationIsSaid) {
  const std::atomic<bool> stop{true};
  stop_ = evaluation::StopToken(stop);
  const RunReport report = run_into("a");
  EXPECT_TRUE(report.stopped);
  EXPECT_EQ(report.generations, 0u);
  EXPECT_THAT(text_of("a/summary.json"), HasSubstr("\"status\": \"stopped\""));
  EXPECT_THROW(static_cast<void>(last_generation(scratch_.path() / "a")), UsageError);
}

TEST_F(Runner, ASavedGenomeJoinsTheFirstGeneration) {
  run_into("a");
  const fs::path champion = champion_path(scratch_.path() / "a", 3);
  run_into("b", {.genomes = {champion}});
  EXPECT_THAT(lines_of(scratch_.path() / "b/individuals.csv")[1], StartsWith("0,0,,,seed,"));
  EXPECT_EQ(text_of("b/genomes/given-0.json"), read_file(champion));
  const Json manifest = parse_json(text_of("b/manifest.json"), "manifest");
  EXPECT_EQ(manifest["genomes"][0]["xxh3_128"], hash_of_file(champion));
}

TEST_F(Runner, ABadGenomeIsRefusedBeforeADirectoryIsMade) {
  write_file(scratch_.path() / "bad.json", "{\"controller\": {}}");
  EXPECT_THROW(run_into("b", {.genomes = {scratch_.path() / "bad.json"}}), UsageError);
  EXPECT_FALSE(fs::exists(scratch_.path() / "b"));
}

TEST_F(Runner, APluginThatFailsIsNamedWithItsGenome) {
  experiment_ = test::toy_experiment({.broken_fitness = true});
  try {
    run_into("a");
    FAIL() << "no exception";
  } catch (const PluginError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("generation 0, individual 0: fitness: score"),
                                    HasSubstr("failed-genome.json")));
  }
  const evolution::Heredity heredity(*experiment_.ecosystem);
  EXPECT_NO_THROW(
      static_cast<void>(parse_genome(text_of("a/failed-genome.json"), "test", heredity)));
  EXPECT_THAT(text_of("a/summary.json"), HasSubstr("\"status\": \"failed\""));
}

// ---- a full disk -------------------------------------------------------------------------------

TEST_F(Runner, AFullDiskKeepsAllFinishedGenerationsAndNoHalfOne) {
  experiment_.evolution.generations = 50;
  // The store and its log grow most.
  try {
    const FullDisk full(300'000);
    run_into("a");
    FAIL() << "no exception";
  } catch (const WriteError& error) {
    EXPECT_THAT(error.what(), HasSubstr("File too large"));
  }
  const fs::path run = scratch_.path() / "a";
  const std::size_t generations = lines_of(run / "generations.csv").size() - 1;
  EXPECT_GT(generations, 0u);
  EXPECT_LT(generations, 50u);
  EXPECT_THAT(lines_of(run / "individuals.csv"), SizeIs(1 + 20 * generations));
  EXPECT_THAT(lines_of(run / "timing.csv"), SizeIs(1 + generations));
  EXPECT_THAT(Scratch::names_in(run / "champions"), SizeIs(generations));
  EXPECT_EQ(read_file(run / "individuals.csv").back(), '\n');
}

// ---- small things ------------------------------------------------------------------------------

TEST(Replay, OneOfAThingIsNotPlural) {
  ReplayReport report;
  report.replayed.outcome.peak_cells = 1;
  report.replayed.outcome.divisions = 1;
  report.replayed.outcome.specializations = 1;
  EXPECT_THAT(to_text(report), HasSubstr(", peak 1 cell, 1 division, 1 specialization\n"));
}

TEST(Progress, DurationsAreShort) {
  EXPECT_EQ(duration_text(0), "0s");
  EXPECT_EQ(duration_text(47.4), "47s");
  EXPECT_EQ(duration_text(200), "3m20s");
  EXPECT_EQ(duration_text(7500), "2h05m");
  EXPECT_EQ(duration_text(3 * 86400 + 4 * 3600), "3d04h");
}

TEST(Progress, ElsewhereThanOnATerminalAGenerationIsALine) {
  const Scratch scratch;
  const fs::path file = scratch.path() / "log";
  std::FILE* stream = std::fopen(file.c_str(), "w");
  {
    Terminal terminal(stream);
    EXPECT_FALSE(terminal.interactive());
    Progress progress(terminal, 120, 400);
    progress.begin_generation(0);
    progress.update(10);
    progress.end_generation({.best = 548, .median = 20.5});
  }
  std::fclose(stream);
  const std::vector<std::string> lines = lines_of(file);
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_THAT(lines[0], StartsWith("generation 0 (1 of 120): best 548, median 20.5, "));
  EXPECT_THAT(lines[0],
              AllOf(HasSubstr(" evaluations/s, "), HasSubstr(" left"), Not(HasSubstr("\x1b"))));
}

constexpr Standing late{.generation = 118,
                        .generations = 120,
                        .done = 399,
                        .evaluations = 400,
                        .best = 1504,
                        .median = 1477.5,
                        .rate = 1234,
                        .seconds_left = 7500};

TEST(Progress, TheBarShrinksFirstThenTheWords) {
  EXPECT_EQ(text_within(late, 130),
            "[###################.] generation 118 (119 of 120) 399/400: best 1504, median 1477.5, "
            "1234 evaluations/s, 2h05m left");
  EXPECT_EQ(text_within(late, 110),
            "[#########.] generation 118 (119 of 120) 399/400: best 1504, median 1477.5, 1234 "
            "evaluations/s, 2h05m left");
  EXPECT_EQ(text_within(late, 79),
            "gen 118 (119 of 120) 399/400: best 1504, median 1477.5, 1234 eval/s, 2h05m left");
  EXPECT_EQ(text_within(late, 77),
            "gen 118 (119 of 120): best 1504, median 1477.5, 1234 eval/s, 2h05m left");
  EXPECT_EQ(text_within(late, 59), "gen 118: best 1504, median 1477.5, 1234 eval/s, 2h05m left");
  EXPECT_EQ(text_within(late, 20), "gen 118 best 1504 me");
}

TEST(Progress, FromSixtyColumnsOnNothingThatCountsIsLost) {
  Standing large = late;
  large.generation = 99998;
  large.generations = 99999;
  large.best = 123456.7;
  large.median = 98765.4;
  large.rate = 12345;
  for (const Standing& standing : {late, large}) {
    // One column of the terminal stays free.
    for (std::size_t columns = 59; columns < 140; ++columns) {
      const std::string text = text_within(standing, columns);
      EXPECT_LE(text.size(), columns);
      EXPECT_THAT(
          text, testing::ContainsRegex("gen(eration)? [0-9]+.* best [0-9.e+]+,? median [0-9.e+]+,? "
                                       "[0-9]+( evaluations| eval)?/s,? 2h05m left$"));
    }
  }
}

TEST(Progress, OnATerminalTheLineFitsItsWidth) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0)
    GTEST_SKIP() << "no pseudo terminals here";
  const winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
  ::ioctl(master, TIOCSWINSZ, &size);
  std::FILE* stream = std::fopen(::ptsname(master), "w");
  ASSERT_NE(stream, nullptr);
  ::setenv("TERM", "xterm", 1);
  Terminal terminal(stream);
  ASSERT_TRUE(terminal.interactive());
  EXPECT_EQ(terminal.columns(), 79u);
  {
    Progress progress(terminal, 120, 400);
    progress.begin_generation(0);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    progress.end_generation({.best = 548, .median = 320.5});
    progress.begin_generation(1);
  }
  // The other end arrives in pieces.
  std::string shown;
  pollfd readable{.fd = master, .events = POLLIN, .revents = 0};
  while (shown.find(" left") == std::string::npos && ::poll(&readable, 1, 5000) > 0) {
    char piece[512];
    const auto count = ::read(master, piece, sizeof piece);
    if (count <= 0) break;
    shown.append(piece, static_cast<std::size_t>(count));
  }
  std::fclose(stream);
  ::close(master);
  EXPECT_THAT(shown, testing::ContainsRegex(
                         "gen 1 \\(2 of 120\\).*: best 548, median 320.5, [0-9]+ eval/s, "
                         "[0-9a-z]+ left"));
}

}  // namespace
}  // namespace somas::run
