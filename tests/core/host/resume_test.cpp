// A run that was stopped, in whatever way, ends as one that was not.
#include <cstdlib>

#include <gmock/gmock.h>
#include <sys/mount.h>

#include "core/run/json.hpp"
#include "tests/core/host/toy_runs.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::write_file;
using test::eventually;
using test::HostProcess;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

class Resume : public test::ToyRuns {
 protected:
  /// Starts an endless run in "a", waits for two generations, sends a signal; the exit code.
  int signalled(int signal) {
    HostProcess process(scratch_.path(), {"toy.yaml", "--generations", "1000000", "--out", "a"});
    EXPECT_TRUE(eventually([&] { return generations_in("a") >= 2; }));
    process.send(signal);
    return process.wait();
  }
  /// Goes on with "a" for some generations and compares it with a run that was never stopped.
  void expect_the_same_end(const std::string& threads = "2") {
    const std::string generations = std::to_string(generations_in("a") + 3);
    ASSERT_EQ(host({"resume", "a", "--generations", generations, "--threads", threads}), 0) << err_;
    ASSERT_EQ(host({"toy.yaml", "--generations", generations, "--out", "whole"}), 0) << err_;
    expect_same("a", "whole");
    EXPECT_EQ(generations_in("a"), std::stoul(generations));
  }
};

TEST_F(Resume, SomeGenerationsAndTheRestAreTheWholeRun) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "5", "--out", "whole"}), 0) << err_;
  for (int k = 1; k < 5; ++k) {
    const std::string name = "k" + std::to_string(k);
    const std::string before = k % 2 == 0 ? "2" : "1", after = k % 2 == 0 ? "1" : "2";
    ASSERT_EQ(
        host({"toy.yaml", "--generations", std::to_string(k), "--threads", before, "--out", name}),
        0);
    ASSERT_EQ(host({"resume", name, "--generations", "5", "--threads", after}), 0) << err_;
    expect_same(name, "whole");
    EXPECT_THAT(out_, StartsWith(name + ": 5 generations, best "));
  }
}

class ResumeModes : public Resume, public testing::WithParamInterface<const char*> {};

TEST_P(ResumeModes, GoOnAsIfNeverStopped) {
  const std::string mode = "evolution.mode=" + std::string(GetParam());
  ASSERT_EQ(host({"toy.yaml", "--set", mode, "--generations", "5", "--out", "whole"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--set", mode, "--generations", "2", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"resume", "a", "--generations", "5"}), 0) << err_;
  expect_same("a", "whole");
}

INSTANTIATE_TEST_SUITE_P(Modes, ResumeModes,
                         testing::Values("rosters", "coevolution", "hall_of_fame"));

TEST_F(Resume, AGenomeThatSeededTheRunIsKeptUntilItIsNeeded) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  fs::rename(path("a/champions/gen-0002.json"), path("seed.json"));
  ASSERT_EQ(host({"toy.yaml", "--genome", "seed.json", "--out", "whole"}), 0) << err_;
  // Stopped before its first generation was finished; the genome's file is gone since.
  fs::copy(path("whole"), path("b"), fs::copy_options::recursive);
  fs::remove(path("seed.json"));
  const run::Database store(path("b/run.sqlite"), run::Database::Access::write);
  store.execute(
      "DELETE FROM generations; DELETE FROM individuals; DELETE FROM trials; "
      "DELETE FROM timing");
  ASSERT_EQ(host({"resume", "b"}), 0) << err_;
  expect_same("b", "whole");
}

TEST_F(Resume, AfterCtrlC) {
  EXPECT_EQ(signalled(SIGINT), 130);
  expect_the_same_end();
}

TEST_F(Resume, AfterTermination) {
  EXPECT_EQ(signalled(SIGTERM), 143);
  expect_the_same_end("1");
}

TEST_F(Resume, AfterTheSignalsThatSchedulersSend) {
  EXPECT_EQ(signalled(SIGUSR1), 143);
  EXPECT_THAT(text("a/summary.json"), HasSubstr("\"status\": \"stopped\""));
  expect_the_same_end();
  for (const int signal : {SIGUSR2, SIGXCPU}) {
    fs::remove_all(path("a"));
    EXPECT_EQ(signalled(signal), 143);
  }
}

TEST_F(Resume, AfterAKill) {
  EXPECT_EQ(signalled(SIGKILL), 1000 + SIGKILL);
  // As a kill at a worse moment may leave them.
  write_file(path("a/champions/gen-99999.json"), "half a champ");
  write_file(path("a/.summary.json.tmp123"), "{");
  write_file(path("a/individuals.csv"), text("a/individuals.csv") + "99,2,1");
  fs::remove(path("a/phylogeny.csv"));
  expect_the_same_end();
  EXPECT_FALSE(fs::exists(path("a/run.lock")));
}

TEST_F(Resume, ACompleteRunIsLeftAsItIs) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const auto before = test::results_of(path("a"));
  EXPECT_EQ(host({"resume", "a"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("is complete"));
  EXPECT_EQ(test::results_of(path("a")), before);
  EXPECT_EQ(host({"resume", "a", "--generations", "2"}), 2);
  EXPECT_THAT(err_, HasSubstr("--generations 2: a has finished 3 generations already"));
}

// ---- what has changed --------------------------------------------------------------------------

TEST_F(Resume, AChangedPluginIsRefusedUnlessAccepted) {
  fs::copy(SOMAS_BINARY_DIR "/tests/fixtures/plugins", path("mine"), fs::copy_options::recursive);
  const std::string set = "plugins=[" + path("mine").string() + "]";
  ASSERT_EQ(host({"toy.yaml", "--set", set, "--generations", "2", "--out", "a"}), 0) << err_;
  const fs::path plugin = path("mine/toy_fitness.somas.so");
  const std::string before = run::hash_of_file(plugin);
  write_file(plugin, run::read_file(plugin) + "x");
  EXPECT_EQ(host({"resume", "a", "--generations", "4"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("a cannot go on as it began:\n  plugin "),
                          HasSubstr("toy_fitness.somas.so"), HasSubstr(before),
                          HasSubstr("--accept-changes")));
  EXPECT_EQ(generations_in("a"), 2u);

  ASSERT_EQ(host({"resume", "a", "--generations", "4", "--accept-changes"}), 0) << err_;
  const run::Json manifest = run::parse_json(text("a/manifest.json"), "manifest");
  ASSERT_EQ(manifest["accepted_changes"].size(), 1u);
  EXPECT_EQ(manifest["accepted_changes"][0]["from_generation"], 2);
  EXPECT_THAT(manifest["accepted_changes"][0]["changes"][0].get<std::string>(), HasSubstr(before));
  // It is what the run uses now.
  EXPECT_EQ(host({"resume", "a", "--generations", "5"}), 0) << err_;
}

TEST_F(Resume, AChangedExperimentIsRefusedUnlessAccepted) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "2", "--out", "a"}), 0) << err_;
  std::string resolved = text("a/resolved.yaml");
  const std::size_t at = resolved.find("hazard: 0.2");
  ASSERT_NE(at, std::string::npos);
  resolved.replace(at, 11, "hazard: 0.3");
  write_file(path("a/resolved.yaml"), resolved);
  EXPECT_EQ(host({"resume", "a", "--generations", "4"}), 2);
  EXPECT_THAT(err_, HasSubstr("the experiment (resolved.yaml) is not that of the run"));
  EXPECT_EQ(host({"resume", "a", "--generations", "4", "--accept-changes"}), 0) << err_;
  EXPECT_THAT(text("a/manifest.json"), HasSubstr("accepted_changes"));
  EXPECT_THAT(text("a/resolved.yaml"), HasSubstr("hazard: 0.3"));
}

TEST_F(Resume, AnotherHostIsRefused) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "2", "--out", "a"}), 0) << err_;
  run::Json manifest = run::parse_json(text("a/manifest.json"), "manifest");
  manifest["host_xxh3_128"] = std::string(32, '0');
  write_file(path("a/manifest.json"), run::to_text(manifest));
  EXPECT_EQ(host({"resume", "a", "--generations", "4"}), 2);
  EXPECT_THAT(err_, HasSubstr("the host is not the one of the run"));
}

TEST_F(Resume, AMachineThatComputesOtherBitsIsRefusedUnlessAccepted) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "2", "--out", "a"}), 0) << err_;
  {
    // As if it had been begun on another one.
    const run::Database database(path("a/run.sqlite"), run::Database::Access::write);
    EXPECT_EQ(database.text_of("SELECT length(reference) FROM sessions"), "16");
    database.execute("UPDATE sessions SET reference = '0123456789abcdef'");
  }
  for (const char* backend : {"threads", "processes"}) {
    EXPECT_EQ(host({"resume", "a", "--generations", "4", "--backend", backend}), 6);
    EXPECT_THAT(err_, AllOf(HasSubstr("the reference simulation gives "),
                            HasSubstr("instead of 0123456789abcdef")));
    EXPECT_EQ(generations_in("a"), 2u);
  }
  EXPECT_EQ(host({"resume", "a", "--generations", "4", "--accept-changes"}), 0) << err_;
  EXPECT_EQ(host({"resume", "a", "--generations", "5"}), 0) << err_;
}

TEST_F(Resume, AChampionThatWasTouchedIsRefused) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "2", "--out", "a"}), 0) << err_;
  const std::string champion = text("a/champions/gen-0001.json");
  write_file(path("a/champions/gen-0001.json"), champion + " ");
  EXPECT_EQ(host({"resume", "a", "--generations", "4"}), 2);
  EXPECT_THAT(err_, HasSubstr("gen-0001.json is not as it was written"));
  fs::remove(path("a/champions/gen-0001.json"));
  EXPECT_EQ(host({"resume", "a", "--generations", "4"}), 2);
  EXPECT_THAT(err_, HasSubstr("gen-0001.json is missing"));
}

// ---- what cannot be resumed --------------------------------------------------------------------

TEST_F(Resume, ADirectoryWithoutARunIsRefused) {
  EXPECT_EQ(host({"resume", "nowhere"}), 2);
  EXPECT_THAT(err_, HasSubstr("nowhere: no such run directory"));
  fs::create_directory(path("empty"));
  EXPECT_EQ(host({"resume", "empty"}), 2);
  EXPECT_THAT(err_, HasSubstr("empty holds no run"));
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  fs::remove(path("a/run.sqlite"));
  EXPECT_EQ(host({"resume", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("no such file: a/run.sqlite"));
}

TEST_F(Resume, TwoProcessesOnOneRunAreTold) {
  HostProcess process(scratch_.path(), {"toy.yaml", "--generations", "1000000", "--out", "a"});
  ASSERT_TRUE(eventually([&] { return generations_in("a") >= 1; }));
  fs::create_directory(path("elsewhere"));
  HostProcess second(path("elsewhere"), {"resume", "../a"});
  EXPECT_EQ(second.wait(), 2);
  EXPECT_THAT(second.err(), AllOf(HasSubstr("../a is in use by process "),
                                  HasSubstr("only one process at a time")));
  // Reading is free.
  HostProcess reader(path("elsewhere"), {"dump", "../a", "--hash"});
  EXPECT_EQ(reader.wait(), 0);
}

TEST_F(Resume, ADamagedStoreIsSaidToBeDamagedOrDoesNoHarm) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "3", "--out", "whole"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--generations", "2", "--out", "a"}), 0) << err_;
  const std::string store = text("a/run.sqlite");
  int refused = 0;
  const auto try_with = [&](const std::string& content) {
    fs::remove_all(path("b"));
    fs::copy(path("a"), path("b"), fs::copy_options::recursive);
    write_file(path("b/run.sqlite"), content);
    const int code = host({"resume", "b", "--generations", "3", "--quiet"});
    if (code == 0) return expect_same("b", "whole");
    EXPECT_EQ(code, 2) << err_;
    EXPECT_THAT(err_,
                AllOf(HasSubstr("run.sqlite"), AnyOf(HasSubstr("damaged"), HasSubstr("version"))));
    ++refused;
  };
  try_with("");
  try_with("nonsense");
  for (std::size_t cut = 1; cut < 6; ++cut) try_with(store.substr(0, store.size() * cut / 6));
  EXPECT_EQ(refused, 7);
  for (std::size_t i = 0; i < 40; ++i) {
    std::string bad = store;
    const std::size_t place = (i * 104729 + 40) % bad.size();
    for (std::size_t k = place; k < std::min(bad.size(), place + 3); ++k)
      bad[k] = static_cast<char>(bad[k] ^ 0x55);
    try_with(bad);
  }
  EXPECT_GT(refused, 10);
}

// ---- disks -------------------------------------------------------------------------------------

/// A small file system of its own.
class SmallDisk {
 public:
  SmallDisk(fs::path place, const std::string& size) : place_(std::move(place)) {
    fs::create_directory(place_);
    mounted_ = ::mount("tmpfs", place_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(place_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  [[nodiscard]] bool mounted() const { return mounted_; }
  void remount(unsigned long flags, const std::string& options) const {
    ASSERT_EQ(::mount("tmpfs", place_.c_str(), "tmpfs", MS_REMOUNT | flags, options.c_str()), 0);
  }

 private:
  fs::path place_;
  bool mounted_ = false;
};

TEST_F(Resume, AfterAFullDisk) {
  const SmallDisk disk(path("disk"), "600k");
  if (!disk.mounted()) GTEST_SKIP() << "file systems cannot be mounted here";
  EXPECT_EQ(host({"toy.yaml", "--generations", "200", "--out", "disk/a"}), 5) << err_;
  EXPECT_THAT(err_, AllOf(HasSubstr("cannot write disk/a/"), HasSubstr("No space left on device")));
  const std::size_t finished = generations_in("disk/a");
  EXPECT_GT(finished, 2u);
  // As long as it is full, nothing changes.
  EXPECT_EQ(host({"resume", "disk/a"}), 5) << err_;
  disk.remount(0, "size=60m");
  ASSERT_EQ(host({"resume", "disk/a"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--generations", "200", "--out", "whole"}), 0) << err_;
  expect_same("disk/a", "whole");
}

TEST_F(Resume, WhereNothingMayBeWritten) {
  const SmallDisk disk(path("disk"), "20m");
  if (!disk.mounted()) GTEST_SKIP() << "file systems cannot be mounted here";
  ASSERT_EQ(host({"toy.yaml", "--out", "disk/a"}), 0) << err_;
  ASSERT_EQ(host({"dump", "disk/a", "--hash"}), 0) << err_;
  const std::string hash = out_;
  disk.remount(MS_RDONLY, "");
  EXPECT_EQ(host({"resume", "disk/a", "--generations", "5"}), 5);
  EXPECT_THAT(err_, AllOf(HasSubstr("cannot write disk/a/"), HasSubstr("Read-only file system")));
  EXPECT_EQ(host({"toy.yaml", "--out", "disk/b"}), 5);
  // But read.
  EXPECT_EQ(host({"dump", "disk/a", "--hash"}), 0) << err_;
  EXPECT_EQ(out_, hash);
  EXPECT_EQ(host({"replay", "disk/a"}), 0) << err_;
}

}  // namespace
}  // namespace somas
