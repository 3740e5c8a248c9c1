// Recordings from end to end: files are whole or absent, whatever happens to the host.
#include <algorithm>
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/recording/file.hpp"
#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using test::eventually;
using test::HostProcess;
using test::Scratch;
using testing::ElementsAre;
using testing::HasSubstr;

class HostRecording : public testing::Test {
 protected:
  HostRecording() {
    run::write_file(path("toy.yaml"),
                    "somas: 1\nname: toy\nseed: 5\nplugins: [" SOMAS_BINARY_DIR
                    "/tests/fixtures/plugins]\n"
                    "world: {max_steps: 200, max_cells: 20, morphogens: {size: 9}}\n"
                    "evolution: {population: 4, generations: 2}\n"
                    "environments:\n"
                    "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
                    "specialization: {plugin: toy_tree}\n"
                    "controller: {plugin: toy_controller}\n"
                    "fitness: {plugin: toy_fitness}\n"
                    "record: {every: 5}\n");
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return scratch_.path() / name; }
  int host(std::vector<std::string> arguments, rlim_t limit = 0) {
    HostProcess process(scratch_.path(), std::move(arguments), limit);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  /// Names of recordings; a file under construction has a name of its own.
  [[nodiscard]] std::vector<std::string> recordings() const {
    std::vector<std::string> names;
    std::error_code error;
    if (!fs::exists(path("a/recordings"), error)) return names;
    for (const std::string& name : Scratch::names_in(path("a/recordings")))
      if (!name.starts_with('.')) names.push_back(name);
    return names;
  }

  Scratch scratch_;
  std::string out_, err_;
};

TEST_F(HostRecording, TheOptionIsTheKey) {
  ASSERT_EQ(host({"toy.yaml", "--record", "champions", "--out", "a"}), 0) << err_;
  EXPECT_THAT(recordings(), ElementsAre("gen-0000.h5", "gen-0001.h5"));
  EXPECT_THAT(run::read_file(path("a/resolved.yaml")),
              HasSubstr("record:\n  what: champions\n  every: 5\n"));
  EXPECT_EQ(recording::read_header(path("a/recordings/gen-0001.h5")).every, 5u);
  EXPECT_EQ(host({"toy.yaml", "--record", "champion"}), 2);
  EXPECT_THAT(err_, HasSubstr("champion"));
}

TEST_F(HostRecording, AReplayWritesTheFileOfTheRun) {
  ASSERT_EQ(host({"toy.yaml", "--record", "champions", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--record", "again.h5"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("recording: again.h5\n"));
  EXPECT_EQ(run::read_file(path("again.h5")), run::read_file(path("a/recordings/gen-0001.h5")));
  ASSERT_EQ(host({"replay", "a", "--generation", "0", "--record", "again.h5"}), 0) << err_;
  EXPECT_EQ(run::read_file(path("again.h5")), run::read_file(path("a/recordings/gen-0000.h5")));
}

TEST_F(HostRecording, AReplayRecordsWhatIsAskedFor) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--record", "all.h5", "--every", "1", "--fields-every", "4"}), 0);
  const recording::Recording all = recording::read(path("all.h5"));
  EXPECT_EQ(all.frames.size(), all.ending.steps);
  EXPECT_EQ(all.header.fields_every, 4u);
  ASSERT_EQ(host({"replay", "a", "--record", "late.h5", "--from-step", "7", "--set",
                  "environments.field.hazard=0"}),
            0)
      << err_;
  const recording::Recording late = recording::read(path("late.h5"));
  EXPECT_EQ(late.header.first_step, 7u);
  EXPECT_EQ(late.ending.steps, 200u);
  EXPECT_THAT(late.header.provenance.resolved_yaml, HasSubstr("hazard: 0\n"));
}

TEST_F(HostRecording, AReplayMakesPageRecordingAndPictureAtOnce) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--record", "alone.h5"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--html", "alone.html"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--record", "r.h5", "--html", "p.html", "--picture", "p.svg",
                  "--steps", "3", "--csv", "c.csv"}),
            0)
      << err_;
  EXPECT_EQ(run::read_file(path("r.h5")), run::read_file(path("alone.h5")));
  EXPECT_EQ(run::read_file(path("p.html")), run::read_file(path("alone.html")));
  EXPECT_TRUE(fs::exists(path("p.svg")));
  EXPECT_TRUE(fs::exists(path("c.csv")));
}

TEST_F(HostRecording, ARecordingMakesThePageThatItsReplayMakes) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--record", "r.h5", "--every", "1", "--html", "p.html"}), 0);
  ASSERT_EQ(host({"replay", "r.h5", "--html", "q.html"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("page: q.html, "));
  EXPECT_EQ(run::read_file(path("q.html")), run::read_file(path("p.html")));
  ASSERT_EQ(host({"replay", "r.h5", "--html", "two.html", "--compare", "r.h5"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--html", "two-b.html", "--compare", "r.h5"}), 0) << err_;
  EXPECT_EQ(run::read_file(path("two.html")), run::read_file(path("two-b.html")));
}

TEST_F(HostRecording, AReplayRefusesWhatItCannotDo) {
  ASSERT_EQ(host({"toy.yaml", "--record", "champions", "--out", "a"}), 0) << err_;
  fs::copy(path("a/recordings/gen-0001.h5"), path("r.h5"));
  const auto refused = [&](std::vector<std::string> arguments, const std::string& message) {
    arguments.insert(arguments.begin(), "replay");
    EXPECT_EQ(host(std::move(arguments)), 2);
    EXPECT_THAT(err_, HasSubstr(message));
    EXPECT_FALSE(fs::exists(path("p")));
  };
  refused({"a", "--record", "p", "--html", "p"}, "--html and --record name the same file: p");
  refused({"a", "--record", "a/recordings/gen-0001.h5"}, "belongs to the run");
  refused({"a", "--record", ""}, "--record: the name is empty");
  refused({"a", "--every", "2"}, "give --html or --record");
  refused({"r.h5"}, "r.h5 is a recording, which cannot be replayed; --html FILE makes a page");
  refused({"r.h5", "--html", "p", "--set", "seed=3"}, "--set needs a run directory");
  refused({"r.h5", "--html", "p", "--every", "3"}, "--every needs a run directory");
  refused({"r.h5", "--html", "r.h5"}, "name the same file");
  refused({"a", "--html", "p", "--compare", "r.h5", "--compare-set", "seed=3"},
          "r.h5 is a recording");
  refused({"toy.yaml", "--html", "p"}, "toy.yaml: not an HDF5 file");
}

TEST_F(HostRecording, OfAReplayIsWholeOrAbsent) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  EXPECT_EQ(host({"replay", "a", "--record", "r.h5"}, 4096), 5);
  EXPECT_THAT(err_, HasSubstr("/r.h5: File too large"));
  EXPECT_FALSE(fs::exists(path("r.h5")));
  EXPECT_EQ(host({"replay", "a", "--record", "none/r.h5"}), 5);
}

TEST_F(HostRecording, AFullDiskNamesTheFileAndLeavesNoHalfOne) {
  // The store has room, the first recording has not.
  EXPECT_EQ(
      host({"toy.yaml", "--record", "champions", "--set", "record.every=1", "--out", "a"}, 60'000),
      5);
  EXPECT_THAT(err_, HasSubstr("cannot write a/recordings/gen-0000.h5: File too large"));
  EXPECT_TRUE(fs::is_empty(path("a/recordings")));
}

TEST_F(HostRecording, AKillLeavesWholeFiles) {
  for (int round = 0; round < 3; ++round) {
    fs::remove_all(path("a"));
    HostProcess process(scratch_.path(), {"toy.yaml", "--record", "all", "--generations", "1000000",
                                          "--set", "record.every=1", "--out", "a"});
    const auto enough = 3 + 2 * static_cast<std::size_t>(round);
    ASSERT_TRUE(eventually([&] { return recordings().size() >= enough; }));
    process.send(SIGKILL);
    EXPECT_EQ(process.wait(), 1000 + SIGKILL);
    for (const std::string& name : recordings())
      EXPECT_GT(recording::read(path("a/recordings") / name).frames.size(), 0u) << name;
  }
}

TEST_F(HostRecording, CtrlCLeavesWholeFiles) {
  HostProcess process(scratch_.path(),
                      {"toy.yaml", "--record", "all", "--generations", "1000000", "--out", "a"});
  ASSERT_TRUE(eventually([&] { return recordings().size() >= 3; }));
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 130);
  for (const std::string& name : Scratch::names_in(path("a/recordings")))
    EXPECT_GT(recording::read(path("a/recordings") / name).frames.size(), 0u) << name;
}

TEST_F(HostRecording, IsExported) {
  ASSERT_EQ(host({"toy.yaml", "--record", "champions", "--out", "a"}), 0) << err_;
  EXPECT_EQ(host({"export", "a/recordings/gen-0001.h5", "--format", "csv", "--out", "tables"}), 0);
  EXPECT_THAT(out_, testing::MatchesRegex("tables: [0-9]+ frames\n"));
  EXPECT_TRUE(fs::exists(path("tables/cells.csv")));
  EXPECT_EQ(host({"export", "a/recordings/gen-0001.h5", "--format", "csv", "--out", "tables"}), 2);
  EXPECT_THAT(err_, HasSubstr("tables is not empty"));
  EXPECT_EQ(host({"export", "toy.yaml", "--format", "csv", "--out", "b"}), 2);
  EXPECT_THAT(err_, HasSubstr("toy.yaml: not an HDF5 file"));
  EXPECT_EQ(host({"export", "a/recordings/gen-0001.h5", "--format", "svg", "--out", "b"}), 2);
}

}  // namespace
}  // namespace somas
