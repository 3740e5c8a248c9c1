// The same runs under a launcher, on ranks of this machine.
#include <csignal>
#include <fstream>
#include <sstream>

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
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Children of a process, in the order of their ids.
std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> found;
  std::error_code error;
  for (const auto& thread :
       fs::directory_iterator("/proc/" + std::to_string(parent) + "/task", error)) {
    std::ifstream in(thread.path() / "children");
    for (pid_t child = 0; in >> child;) found.push_back(child);
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool alive(pid_t process) {
  std::istringstream in(text_of("/proc/" + std::to_string(process) + "/stat"));
  std::string number, name, state;
  return (in >> number >> name >> state) && state != "Z";
}

/// Seconds of processor that a process has used.
double cpu_seconds(pid_t process) {
  std::istringstream in(text_of("/proc/" + std::to_string(process) + "/stat"));
  std::vector<std::string> fields;
  for (std::string field; in >> field;) fields.push_back(field);
  const double ticks = std::stod(fields.at(13)) + std::stod(fields.at(14));
  return ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

class Mpi : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(SOMAS_BINARY_DIR "/lib/somas/somas_mpi.so"))
      GTEST_SKIP() << "built without MPI";
    write("none");
  }

  void write(const std::string& faults) {
    run::write_file(path("e.yaml"),
                    "somas: 1\nname: e\nseed: 5\n"
                    "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " SOMAS_BINARY_DIR
                    "/tests/fixtures/faulty]\n"
                    "world: {max_steps: 60, max_cells: 20, morphogens: {size: 9}}\n"
                    "evolution: {population: 16, generations: 2}\n"
                    "environments:\n"
                    "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
                    "  faults: {plugin: faulty_environment, fault: " +
                        faults +
                        "}\n"
                        "specialization: {plugin: toy_tree}\n"
                        "controller: {plugin: toy_controller}\n"
                        "fitness: {plugin: toy_fitness}\n");
  }

  fs::path path(const std::string& name) const { return scratch_.path() / name; }

  /// mpirun in the scratch directory.
  HostProcess launch(unsigned ranks, std::vector<std::string> arguments) const {
    std::vector<std::string> words = {"/usr/bin/mpirun",
                                      "--oversubscribe",
                                      "--bind-to",
                                      "none",
                                      "--mca",
                                      "plm",
                                      "isolated",
                                      "--mca",
                                      "btl_vader_single_copy_mechanism",
                                      "none",
                                      "-np",
                                      std::to_string(ranks)};
    if (::getuid() == 0) words.insert(words.begin() + 1, "--allow-run-as-root");
    words.push_back(SOMAS_BINARY_DIR "/bin/somas-host");
    words.insert(words.end(), arguments.begin(), arguments.end());
    return HostProcess(HostProcess::Program{}, scratch_.path(), words);
  }

  std::string results(const std::string& run) const {
    return text_of(path(run) / "generations.csv") + text_of(path(run) / "individuals.csv") +
           text_of(path(run) / "champions/gen-0000.json") +
           text_of(path(run) / "champions/gen-0001.json");
  }

  Scratch scratch_;
};

TEST_F(Mpi, RanksNeverReachTheResults) {
  HostProcess alone(scratch_.path(), {"e.yaml", "--threads", "1", "--out", "alone"});
  ASSERT_EQ(alone.wait(), 0) << alone.err();
  for (const unsigned ranks : {1u, 2u, 4u, 8u}) {
    const std::string out = "ranks" + std::to_string(ranks);
    HostProcess job = launch(ranks, {"e.yaml", "--workers", "1", "--out", out});
    ASSERT_EQ(job.wait(), 0) << job.err();
    EXPECT_TRUE(results(out) == results("alone")) << ranks;
    EXPECT_THAT(job.out(), HasSubstr(out + ": 2 generations, best "));
    EXPECT_THAT(job.err(), HasSubstr(std::to_string(ranks) + " rank"));
  }
}

TEST_F(Mpi, TheRunsOfACampaignShareAllRanks) {
  HostProcess alone(scratch_.path(),
                    {"e.yaml", "--replicates", "3", "--threads", "1", "--out", "alone", "-q"});
  ASSERT_EQ(alone.wait(), 0) << alone.err();
  HostProcess job = launch(2, {"e.yaml", "--replicates", "3", "--workers", "1", "--out", "ranks"});
  ASSERT_EQ(job.wait(), 0) << job.err();
  EXPECT_THAT(job.err(), HasSubstr("2 evaluator processes of 2 ranks"));
  EXPECT_TRUE(read_file(path("alone/index.csv")) == read_file(path("ranks/index.csv")));
  for (const char* run : {"/all/replicate-001", "/all/replicate-002", "/all/replicate-003"})
    EXPECT_TRUE(results("alone" + std::string(run)) == results("ranks" + std::string(run))) << run;
}

TEST_F(Mpi, FaultsAreContainedOnAllRanks) {
  write("segfault, cells: 2");
  HostProcess alone(scratch_.path(), {"e.yaml", "--workers", "1", "--out", "alone"});
  ASSERT_EQ(alone.wait(), 0) << alone.err();
  HostProcess job = launch(3, {"e.yaml", "--workers", "1", "--out", "ranks"});
  ASSERT_EQ(job.wait(), 0) << job.err();
  EXPECT_TRUE(results("ranks") == results("alone"));
}

TEST_F(Mpi, BadInputIsSaidOnceAndEndsAllRanks) {
  HostProcess job = launch(3, {"nothing.yaml"});
  EXPECT_EQ(job.wait(), 2);
  const std::string message = "nothing.yaml: no such file";
  EXPECT_THAT(job.err(), HasSubstr(message));
  EXPECT_EQ(job.err().find(message), job.err().rfind(message));
}

TEST_F(Mpi, SupervisorsLoadNoPluginAndSleep) {
  write("none, pause: 20");
  HostProcess job = launch(3, {"e.yaml", "--workers", "2", "--out", "a"});
  std::vector<pid_t> ranks;
  // Simulations have begun everywhere.
  ASSERT_TRUE(eventually([&] {
    ranks = children_of(job.id());
    return ranks.size() == 3 && children_of(ranks[1]).size() == 2 &&
           children_of(ranks[2]).size() == 2;
  })) << job.err();
  const double before = cpu_seconds(ranks[1]);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_LT(cpu_seconds(ranks[1]) - before, 0.4) << "of 2 seconds";
  EXPECT_THAT(text_of("/proc/" + std::to_string(ranks[1]) + "/maps"), Not(HasSubstr(".somas.so")));
  EXPECT_THAT(text_of("/proc/" + std::to_string(ranks[0]) + "/maps"), HasSubstr(".somas.so"));
}

TEST_F(Mpi, ALostRankEndsTheJobAndNobodyStaysBehind) {
  HostProcess job =
      launch(3, {"e.yaml", "--workers", "1", "--generations", "100000", "--out", "a"});
  std::vector<pid_t> all;
  ASSERT_TRUE(eventually([&] {
    all = children_of(job.id());
    return all.size() == 3 && children_of(all[1]).size() == 1 &&
           fs::exists(path("a/champions/gen-0001.json"));
  })) << job.err();
  const pid_t victim = all[1];
  for (const pid_t rank : std::vector<pid_t>(all))
    for (const pid_t evaluator : children_of(rank)) all.push_back(evaluator);
  ::kill(victim, SIGKILL);
  EXPECT_NE(job.wait(), 0);
  EXPECT_THAT(job.err(), HasSubstr("rank 1"));
  for (const pid_t process : all)
    EXPECT_TRUE(eventually([&] { return !alive(process); })) << process;
  EXPECT_THAT(text_of(path("a/generations.csv")), Not(IsEmpty()));
}

}  // namespace
}  // namespace somas
