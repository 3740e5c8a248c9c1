// Runs on every backend, and what becomes of them when something dies.
#include <csignal>
#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using test::eventually;
using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

class Backends : public testing::Test {
 protected:
  Backends() { write(""); }

  /// `faults`: settings of the faulty environment and controller.
  void write(const std::string& environment, const std::string& controller = "toy_controller") {
    run::write_file(path("e.yaml"),
                    "somas: 1\nname: e\nseed: 5\n"
                    "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " SOMAS_BINARY_DIR
                    "/tests/fixtures/faulty]\n"
                    "world: {max_steps: 100, max_cells: 20, morphogens: {size: 9}}\n"
                    "evolution: {population: 16, generations: 3, mutation: 1}\n"
                    "environments:\n"
                    "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
                    "  faults: {plugin: faulty_environment, " +
                        environment +
                        "}\n"
                        "specialization: {plugin: toy_tree}\n"
                        "controller: {plugin: " +
                        controller +
                        "}\n"
                        "fitness: {plugin: toy_fitness}\n");
  }

  fs::path path(const std::string& name) const { return scratch_.path() / name; }

  int host(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "e.yaml");
    HostProcess process(scratch_.path(), std::move(arguments));
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }

  /// Everything that does not depend on the clock, the command line or places.
  std::string results(const std::string& run) const {
    std::string all;
    for (const std::string file : {"generations.csv", "individuals.csv", "champions/gen-0000.json",
                                   "champions/gen-0001.json", "champions/gen-0002.json"})
      all += read_file(path(run) / file);
    return all;
  }

  Scratch scratch_;
  std::string out_, err_;
};

/// Evaluator processes whose parent this is.
std::set<pid_t> evaluators_of(pid_t coordinator) {
  std::set<pid_t> found;
  std::error_code error;
  for (const auto& thread :
       fs::directory_iterator("/proc/" + std::to_string(coordinator) + "/task", error)) {
    std::ifstream in(thread.path() / "children");
    for (pid_t child = 0; in >> child;) found.insert(child);
  }
  return found;
}

bool alive(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string number, name, state;
  in >> number >> name >> state;
  return in && state != "Z";
}

TEST_F(Backends, GiveTheSameBytes) {
  ASSERT_EQ(host({"--threads", "1", "--out", "threads"}), 0) << err_;
  for (const char* workers : {"1", "2", "4"}) {
    const std::string out = std::string("pool") + workers;
    ASSERT_EQ(host({"--workers", workers, "--out", out}), 0) << err_;
    EXPECT_TRUE(results(out) == results("threads")) << workers;
  }
}

TEST_F(Backends, GiveTheSameBytesWithThreadsInEachWorld) {
  ASSERT_EQ(host({"--threads", "1", "--out", "threads"}), 0) << err_;
  ASSERT_EQ(host({"--threads", "1", "--world-threads", "3", "--out", "shared"}), 0) << err_;
  EXPECT_TRUE(results("shared") == results("threads"));
  ASSERT_EQ(host({"--workers", "1", "--world-threads", "3", "--out", "pool"}), 0) << err_;
  EXPECT_TRUE(results("pool") == results("threads"));
}

TEST_F(Backends, TellEvaluatorsOfTheThreadsInEachWorld) {
  write("fault: loop, cells: 2");
  HostProcess process(scratch_.path(),
                      {"e.yaml", "--workers", "1", "--world-threads", "3", "--out", "a"});
  std::set<pid_t> evaluators;
  ASSERT_TRUE(eventually([&] {
    evaluators = evaluators_of(process.id());
    return evaluators.size() == 1;
  }));
  std::string words;
  EXPECT_TRUE(eventually([&] {
    words = read_file("/proc/" + std::to_string(*evaluators.begin()) + "/cmdline");
    return words.ends_with(
        std::string("\0"
                    "3\0",
                    3));
  })) << words;
  process.send(SIGTERM);
  EXPECT_EQ(process.wait(), 143) << process.err();
}

TEST_F(Backends, TakeOneTo256ThreadsInAWorld) {
  for (const char* wrong : {"0", "257", "-1", "two"}) {
    EXPECT_EQ(host({"--world-threads", wrong, "--out", "a"}), 2) << wrong;
    EXPECT_THAT(err_, HasSubstr("is not a whole number from 1 to 256"));
  }
}

TEST_F(Backends, GiveTheSameBytesWhenPluginsThrow) {
  write("fault: throw, cells: 2");
  ASSERT_EQ(host({"--threads", "2", "--out", "threads"}), 0) << err_;
  ASSERT_EQ(host({"--workers", "2", "--out", "pool"}), 0) << err_;
  EXPECT_TRUE(results("pool") == results("threads"));
  ASSERT_EQ(host({"--workers", "2", "--out", "sound", "--set", "environments.faults.fault=none"}),
            0);
  EXPECT_FALSE(results("pool") == results("sound")) << "nothing was set aside";
}

TEST_F(Backends, ACrashIsContainedAndIsNoBetterThanAnException) {
  write("fault: throw, cells: 2");
  ASSERT_EQ(host({"--workers", "2", "--out", "thrown"}), 0) << err_;
  write("fault: segfault, cells: 2");
  ASSERT_EQ(host({"--workers", "2", "--out", "crashed"}), 0) << err_;
  EXPECT_EQ(read_file(path("crashed/individuals.csv")), read_file(path("thrown/individuals.csv")));
}

TEST_F(Backends, APluginThatAlwaysFailsEndsTheRunByName) {
  write("fault: segfault, step: 0");
  EXPECT_EQ(host({"--workers", "2", "--out", "a"}), 3);
  EXPECT_THAT(err_, HasSubstr("no evaluator can simulate this experiment: faults: act(fields): "
                              "SIGSEGV"));
}

TEST_F(Backends, AHangingSimulationStopsTheRunWithAnExitCodeOfItsOwn) {
  write("fault: loop, cells: 2");
  EXPECT_EQ(host({"--workers", "2", "--watchdog", "1", "--out", "a"}), 6);
  EXPECT_THAT(err_, HasSubstr("no step of the simulation in 1 s in faults: act(fields) at step"));
}

TEST_F(Backends, ACrashInVariationNamesThePlugin) {
  write("fault: none", "faulty_controller, fault: segfault");
  EXPECT_EQ(host({"--workers", "1", "--out", "a"}), 3);
  EXPECT_THAT(err_, AllOf(HasSubstr("SIGSEGV in controller: mutate"), HasSubstr("saved")));
  // What was finished is.
  EXPECT_TRUE(fs::exists(path("a/champions/gen-0000.json")));
}

TEST_F(Backends, AnExceptionInVariationNamesThePlugin) {
  write("fault: none", "faulty_controller, fault: throw");
  EXPECT_EQ(host({"--workers", "1", "--out", "a"}), 3);
  EXPECT_THAT(err_, HasSubstr("generation 1: controller: mutate: as was asked for"));
  EXPECT_TRUE(fs::exists(path("a/champions/gen-0000.json")));
}

TEST_F(Backends, ACrashByThreadsNamesThePluginToo) {
  write("fault: abort, cells: 2");
  EXPECT_EQ(host({"--threads", "2", "--out", "a"}), 3);
  EXPECT_THAT(err_, HasSubstr("SIGABRT in faults: act(fields)"));
}

TEST_F(Backends, NoEvaluatorOutlivesACoordinatorThatIsKilled) {
  write("fault: loop, cells: 2");  // and none of them listens any more
  HostProcess process(scratch_.path(), {"e.yaml", "--workers", "2", "--out", "a"});
  std::set<pid_t> evaluators;
  ASSERT_TRUE(eventually([&] {
    evaluators = evaluators_of(process.id());
    return evaluators.size() == 2;
  }));
  process.send(SIGKILL);
  EXPECT_EQ(process.wait(), 1000 + SIGKILL);
  for (const pid_t evaluator : evaluators)
    EXPECT_TRUE(eventually([&] { return !alive(evaluator); })) << evaluator;
}

TEST_F(Backends, ASignalStopsARunThoughItsSimulationsHang) {
  write("fault: loop, cells: 2");
  HostProcess process(scratch_.path(), {"e.yaml", "--workers", "2", "--out", "a"});
  ASSERT_TRUE(eventually([&] { return evaluators_of(process.id()).size() == 2; }));
  process.send(SIGTERM);
  EXPECT_EQ(process.wait(), 143) << process.err();
}

TEST_F(Backends, OptionsThatContradictEachOtherAreRefused) {
  EXPECT_EQ(host({"--threads", "2", "--backend", "processes"}), 2);
  EXPECT_EQ(host({"--workers", "0"}), 2);
  EXPECT_EQ(host({"--backend", "clouds"}), 2);
  HostProcess evaluator(scratch_.path(), {"evaluator-process"});
  EXPECT_EQ(evaluator.wait(), 2);
}

}  // namespace
}  // namespace somas
