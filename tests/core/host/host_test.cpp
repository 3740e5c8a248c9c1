// The host from end to end, on toy plugins.
#include <algorithm>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/run/json.hpp"
#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using test::eventually;
using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::Not;
using testing::StartsWith;

const std::string experiment_text =
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

class Host : public testing::Test {
 protected:
  Host() { write_file(path("toy.yaml"), experiment_text); }

  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  std::string text(const std::string& name) const { return read_file(path(name)); }

  /// Runs to the end.
  int host(std::vector<std::string> arguments, rlim_t limit = 0) {
    HostProcess process(scratch_.path(), std::move(arguments), limit);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }

  std::size_t generations_in(const std::string& run) const {
    std::error_code error;
    if (!fs::exists(path(run) / "generations.csv", error)) return 0;
    const std::string lines = text(run + "/generations.csv");
    const auto count = std::count(lines.begin(), lines.end(), '\n');
    return count > 0 ? static_cast<std::size_t>(count - 1) : 0;
  }

  /// Starts an endless run, waits for two generations, sends a signal.
  int signalled(int signal) {
    HostProcess process(scratch_.path(), {"toy.yaml", "--generations", "1000000", "--out", "a"});
    EXPECT_TRUE(eventually([&] { return generations_in("a") >= 2; }));
    process.send(signal);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }

  Scratch scratch_;
  std::string out_, err_;
};

// ---- run ---------------------------------------------------------------------------------------

TEST_F(Host, RunsAFileIntoARunDirectory) {
  ASSERT_EQ(host({"toy.yaml"}), 0) << err_;
  EXPECT_THAT(out_, StartsWith("runs/toy-seed5: 3 generations, best "));
  EXPECT_THAT(err_, AllOf(HasSubstr("run runs/toy-seed5: 3 generations of 12, seed 5"),
                          HasSubstr("generation 2 (3 of 3): best ")));
  EXPECT_EQ(generations_in("runs/toy-seed5"), 3u);
  EXPECT_EQ(text("runs/toy-seed5/experiment.yaml"), experiment_text);
}

TEST_F(Host, RunsAgainBesideTheEarlierRun) {
  ASSERT_EQ(host({"run", "toy.yaml"}), 0) << err_;
  ASSERT_EQ(host({"run", "toy.yaml"}), 0) << err_;
  EXPECT_EQ(text("runs/toy-seed5/generations.csv"), text("runs/toy-seed5-2/generations.csv"));
}

TEST_F(Host, QuietSaysNothing) {
  ASSERT_EQ(host({"toy.yaml", "--quiet"}), 0);
  EXPECT_THAT(out_, IsEmpty());
  EXPECT_THAT(err_, IsEmpty());
}

TEST_F(Host, ThreadsNeverReachTheResults) {
  ASSERT_EQ(host({"toy.yaml", "--threads", "1", "--out", "one"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--threads", "2", "--out", "two"}), 0) << err_;
  EXPECT_EQ(text("one/generations.csv"), text("two/generations.csv"));
  EXPECT_EQ(text("one/individuals.csv"), text("two/individuals.csv"));
  EXPECT_EQ(text("one/champions/gen-0002.json"), text("two/champions/gen-0002.json"));
}

TEST_F(Host, TheResolvedFileGivesTheSameRun) {
  ASSERT_EQ(host({"toy.yaml", "--set", "evolution.mutation=0.3", "--out", "one"}), 0) << err_;
  ASSERT_EQ(host({"one/resolved.yaml", "--out", "two"}), 0) << err_;
  EXPECT_EQ(text("one/generations.csv"), text("two/generations.csv"));
  EXPECT_EQ(text("one/resolved.yaml"), text("two/resolved.yaml"));
}

TEST_F(Host, SeedAndGenerationsAreOverrides) {
  ASSERT_EQ(host({"toy.yaml", "--seed", "9", "--generations", "1"}), 0) << err_;
  EXPECT_EQ(generations_in("runs/toy-seed9"), 1u);
  EXPECT_THAT(text("runs/toy-seed9/resolved.yaml"),
              AllOf(HasSubstr("seed: 9"), HasSubstr("generations: 1")));
}

TEST_F(Host, AChampionSeedsAnotherRun) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--out", "b", "--genome", "a/champions/gen-0002.json"}), 0) << err_;
  EXPECT_THAT(text("b/individuals.csv"), HasSubstr("\n0,0,,,seed,"));
}

// ---- signals -----------------------------------------------------------------------------------

TEST_F(Host, CtrlCLeavesAUsableRun) {
  EXPECT_EQ(signalled(SIGINT), 130);
  EXPECT_THAT(out_, HasSubstr("stopped after "));
  EXPECT_THAT(text("a/summary.json"), HasSubstr("\"status\": \"stopped\""));
  EXPECT_EQ(host({"replay", "a"}), 0) << err_;
}

TEST_F(Host, TermEndsAsCtrlCDoesWithItsOwnCode) {
  EXPECT_EQ(signalled(SIGTERM), 143);
  EXPECT_EQ(host({"replay", "a"}), 0) << err_;
}

TEST_F(Host, AHangUpEndsAsCtrlCDoesWithItsOwnCode) {
  EXPECT_EQ(signalled(SIGHUP), 129);
  EXPECT_THAT(text("a/summary.json"), HasSubstr("\"status\": \"stopped\""));
}

TEST_F(Host, AKilledRunHasASummaryOfItsGenerations) {
  EXPECT_EQ(signalled(SIGKILL), 1000 + SIGKILL);
  const run::Json summary = run::parse_json(text("a/summary.json"), "summary");
  EXPECT_EQ(summary["status"], "running");
  EXPECT_GE(summary["generations"].get<std::size_t>() + 1, generations_in("a"));
  EXPECT_TRUE(summary.contains("best"));
}

// ---- bad input ---------------------------------------------------------------------------------

TEST_F(Host, AnUnknownKeyIsNamedWithItsPlace) {
  std::string text = experiment_text;
  text.replace(text.find("population"), 10, "poplation_");
  write_file(path("bad.yaml"), text);
  EXPECT_EQ(host({"bad.yaml"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("bad.yaml:6:13"), HasSubstr("poplation_"),
                          HasSubstr("did you mean 'population'?")));
  EXPECT_FALSE(fs::exists(path("runs")));
}

TEST_F(Host, AnEarlierRunIsNeverOverwritten) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const std::string before = text("a/generations.csv");
  EXPECT_EQ(host({"toy.yaml", "--out", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("directory a is not empty"));
  EXPECT_EQ(text("a/generations.csv"), before);
}

TEST_F(Host, BadCommandLinesAreBadInput) {
  EXPECT_EQ(host({}), 2);
  EXPECT_EQ(host({"none.yaml"}), 2);
  EXPECT_THAT(err_, HasSubstr("none.yaml"));
  EXPECT_EQ(host({"toy.yaml", "--colour"}), 2);
  EXPECT_EQ(host({"toy.yaml", "--threads", "0"}), 2);
  EXPECT_EQ(host({"toy.yaml", "--seed", "-1"}), 2);
  EXPECT_EQ(host({"toy.yaml", "--genome", "toy.yaml"}), 2);
  EXPECT_THAT(err_, HasSubstr("toy.yaml:1: not valid JSON"));
  EXPECT_EQ(host({"replay", "nowhere"}), 2);
  EXPECT_FALSE(fs::exists(path("runs")));
}

TEST_F(Host, NumbersAreRefusedInTheUsersWords) {
  for (const char* option : {"--seed", "--generations", "--threads"})
    for (const char* number : {"-1", "99999999999999999999", "1.5"}) {
      EXPECT_EQ(host({"toy.yaml", option, number}), 2);
      EXPECT_THAT(err_, StartsWith("somas-host: " + std::string(option) + ": '" + number + "' is"));
    }
  EXPECT_EQ(host({"replay", "a", "--generation", "-1"}), 2);
  EXPECT_THAT(err_, StartsWith("somas-host: --generation: '-1' is"));
}

TEST_F(Host, OddFilesAndNamesAreBadInput) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0666), 0);
  EXPECT_EQ(host({"pipe"}), 2);
  EXPECT_EQ(host({"./pipe"}), 2);
  EXPECT_THAT(err_, HasSubstr("not a regular file"));
  EXPECT_EQ(host({"toy.yaml", "--genome", "pipe"}), 2);
  EXPECT_THAT(err_, HasSubstr("not a regular file"));
  EXPECT_EQ(host({"toy.yaml", "--out", ""}), 2);
  EXPECT_EQ(host({"toy.yaml", "--out", "toy.yaml/x"}), 2);
  EXPECT_EQ(host({"toy.yaml", "--set", "extends=other.yaml"}), 2);
  EXPECT_THAT(err_, HasSubstr("cannot be set here"));
  EXPECT_EQ(host({"toy.yaml", "--set", "name=\"a\\nb\""}), 2);
  EXPECT_THAT(err_, HasSubstr("control characters; byte 2"));
  EXPECT_EQ(host({"toy.yaml", "--set", "name=" + std::string(101, 'n')}), 2);
  EXPECT_THAT(err_, HasSubstr("at most 100"));
  EXPECT_FALSE(fs::exists(path("runs")));
}

TEST_F(Host, ComplaintsAboutTheCommandLineSayWhoComplains) {
  const std::vector<std::vector<std::string>> wrong = {
      {}, {"toy.yaml", "--colour"}, {"replay"}, {"toy.yaml", "--threads", "0"}};
  for (const std::vector<std::string>& words : wrong) {
    EXPECT_EQ(host(words), 2);
    EXPECT_THAT(err_, AllOf(StartsWith("somas-host: "),
                            HasSubstr("; run with --help for more information\n")));
    EXPECT_THAT(out_, IsEmpty());
  }
}

TEST_F(Host, OneGenerationIsNotPlural) {
  ASSERT_EQ(host({"toy.yaml", "--generations", "1", "--out", "a"}), 0) << err_;
  EXPECT_THAT(out_, StartsWith("a: 1 generation, best "));
  EXPECT_THAT(err_, HasSubstr("run a: 1 generation of 12, "));
}

TEST_F(Host, AGenomeOfAnotherControllerIsRefusedByName) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  run::Json champion = run::parse_json(text("a/champions/gen-0002.json"), "champion");
  EXPECT_EQ(champion["genome"]["controller"]["plugin"], "toy_controller");
  EXPECT_EQ(champion["genome"]["controller"]["version"], "1.0");
  champion["genome"]["controller"]["plugin"] = "grn";
  write_file(path("other.json"), run::to_text(champion));
  EXPECT_EQ(host({"toy.yaml", "--out", "b", "--genome", "other.json"}), 2);
  EXPECT_THAT(err_, HasSubstr("made for the controller 'grn', version 1.0; this experiment's "
                              "controller is 'toy_controller'"));
  EXPECT_FALSE(fs::exists(path("b")));
}

TEST_F(Host, AnEditedGenomeJoinsWithAWarning) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  run::Json champion = run::parse_json(text("a/champions/gen-0002.json"), "champion");
  run::Json& level = champion["genome"]["controller"]["genes"]["levels"][0]["level"];
  level = 255 - level.get<int>();
  write_file(path("edited.json"), run::to_text(champion));
  ASSERT_EQ(host({"toy.yaml", "--quiet", "--out", "b", "--genome", "edited.json"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("warning: edited.json: the genome was edited"));
}

TEST_F(Host, AMisspeltCommandIsNotAMissingFile) {
  EXPECT_EQ(host({"relpay", "a"}), 2);
  EXPECT_THAT(
      err_, AllOf(HasSubstr("neither a command nor a file"), HasSubstr("did you mean 'replay'?")));
}

TEST_F(Host, HelpListsTheExitCodes) {
  EXPECT_EQ(host({"--help"}), 0);
  EXPECT_THAT(out_, AllOf(HasSubstr("replay"), HasSubstr("130"), HasSubstr("143")));
  EXPECT_EQ(host({"--version"}), 0);
  EXPECT_THAT(out_, MatchesRegex("somas-host [0-9.]+\n"));
  const int status = std::system(SOMAS_BINARY_DIR "/bin/somas-host --help >&- 2>&-");
  EXPECT_EQ(WEXITSTATUS(status), 5);
}

// ---- a full disk -------------------------------------------------------------------------------

TEST_F(Host, AFullDiskNamesTheFileAndKeepsFinishedGenerations) {
  EXPECT_EQ(host({"toy.yaml", "--generations", "1000", "--out", "a"}, 300'000), 5);
  EXPECT_THAT(err_, HasSubstr("cannot write a/"));
  const std::size_t generations = generations_in("a");
  EXPECT_GT(generations, 0u);
  EXPECT_LT(generations, 1000u);
  const run::Json summary = run::parse_json(text("a/summary.json"), "summary");
  EXPECT_EQ(summary["generations"], generations);
  EXPECT_EQ(summary["status"], "failed");
  EXPECT_EQ(host({"replay", "a"}), 0) << err_;
}

// ---- replay ------------------------------------------------------------------------------------

TEST_F(Host, ReplayReproducesEveryChampion) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  for (const char* generation : {"0", "1", "2"})
    EXPECT_EQ(host({"replay", "a", "--generation", generation, "--csv", "c.csv"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("reproduced: survival and all "));
  EXPECT_THAT(err_, IsEmpty());
  EXPECT_THAT(text("c.csv"), StartsWith("step,feeder,shield,cells,hash\n0,1,0,1,"));
  EXPECT_EQ(host({"replay", "a", "--generation", "3"}), 2);
  EXPECT_THAT(err_, HasSubstr("the last one is 2"));
}

TEST_F(Host, ATamperedGenomeIsNotReproduced) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  // Every output turned round: the cells do something else from the first step on.
  const fs::path file = path("a/champions/gen-0002.json");
  run::Json champion = run::parse_json(read_file(file), "champion");
  for (run::Json& gene : champion["genome"]["controller"]["genes"]["levels"])
    gene["level"] = 255 - gene["level"].get<int>();
  fs::remove(file);
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a"}), 4);
  EXPECT_THAT(out_, AllOf(HasSubstr("NOT reproduced"), HasSubstr("first differing step ")));
  EXPECT_THAT(err_, HasSubstr("the genome was edited"));
}

TEST_F(Host, ATamperedHashNamesItsStep) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const fs::path file = path("a/champions/gen-0001.json");
  run::Json champion = run::parse_json(read_file(file), "champion");
  champion["steps"]["world_hash"][3] = "0000000000000000";
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a", "--generation", "1"}), 4);
  EXPECT_THAT(out_, HasSubstr("first differing step 3: recorded hash 0000000000000000"));
}

TEST_F(Host, WhatIfIsNotChecked) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  EXPECT_EQ(host({"replay", "a", "--set", "environments.field.hazard=50"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("recorded: survival "), HasSubstr("what if:  survival "),
                          Not(HasSubstr("reproduced"))));
  // Other ports than the genome's.
  EXPECT_EQ(host({"replay", "a", "--set", "world.morphogens.kinds=[]"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("made to fit"));
}

TEST_F(Host, AChangedPluginIsToldBeforeItIsBlamed) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  run::Json manifest = run::parse_json(text("a/manifest.json"), "manifest");
  manifest["plugins"][0]["xxh3_128"] = "00000000000000000000000000000000";
  write_file(path("a/manifest.json"), run::to_text(manifest));
  EXPECT_EQ(host({"replay", "a"}), 0) << err_;
  EXPECT_THAT(err_, AllOf(HasSubstr("warning: plugin somas.test."),
                          HasSubstr("is not the file of the run")));
}

TEST_F(Host, ReplayFindsThePluginsOfTheRun) {
  std::string text = experiment_text;
  const std::size_t line = text.find("plugins: [");
  text.erase(line, text.find('\n', line) + 1 - line);
  write_file(path("toy.yaml"), text);
  const std::string plugins = SOMAS_BINARY_DIR "/tests/fixtures/plugins";
  ASSERT_EQ(host({"toy.yaml", "--plugin-path", plugins, "--out", "a"}), 0) << err_;
  EXPECT_EQ(host({"replay", "a"}), 0) << err_;
}

TEST_F(Host, AReplayNeverOverwritesItsRun) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const std::string before = text("a/generations.csv");
  fs::create_symlink("a/summary.json", path("link"));
  for (const char* file : {"a/generations.csv", "link", "a/champions/gen-0000.json",
                           "a/../a/genomes/x", "a/resolved.yaml"}) {
    EXPECT_EQ(host({"replay", "a", "--csv", file}), 2) << file;
    EXPECT_THAT(err_, HasSubstr("belongs to the run"));
    EXPECT_EQ(host({"replay", "a", "--anatomy-csv", file}), 2) << file;
  }
  EXPECT_EQ(text("a/generations.csv"), before);
  EXPECT_EQ(host({"replay", "a/", "--csv", "a/summary.json"}), 2);
  EXPECT_EQ(host({"replay", "a", "--csv", "x.csv", "--anatomy-csv", "./x.csv"}), 2);
  EXPECT_THAT(err_, HasSubstr("name the same file: x.csv"));
  EXPECT_EQ(host({"replay", "a", "--csv", "none/x.csv"}), 5);
  EXPECT_THAT(out_, IsEmpty());
  EXPECT_EQ(host({"replay", "a", "--csv", "a/mine.csv"}), 0) << err_;
}

TEST_F(Host, ReplayDrawsTheOrganismAtChosenSteps) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  ASSERT_EQ(host({"replay", "a", "--picture", "p.svg", "--steps", "0,2", "--steps", "1"}), 0)
      << err_;
  EXPECT_THAT(out_, HasSubstr("reproduced: "));
  EXPECT_THAT(text("p.svg"), AllOf(StartsWith("<?xml"), HasSubstr("</svg>")));
  ASSERT_EQ(host({"replay", "a", "--picture", "p.pdf", "--steps", "1"}), 0) << err_;
  EXPECT_THAT(text("p.pdf"), StartsWith("%PDF-"));
  ASSERT_EQ(host({"replay", "a", "--picture", "p.PNG", "--steps", "1", "--view", "world", "--width",
                  "300"}),
            0)
      << err_;
  EXPECT_THAT(text("p.PNG"), HasSubstr("PNG"));
  ASSERT_EQ(host({"replay", "a", "--picture", "q.svg", "--steps", "0,1,2"}), 0) << err_;
  EXPECT_EQ(text("p.svg"), text("q.svg"));
}

TEST_F(Host, APictureThatCannotBeIsRefusedAndLeavesNoFile) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const auto refused = [&](std::vector<std::string> more, const char* because) {
    more.insert(more.begin(), {"replay", "a"});
    EXPECT_EQ(host(more), 2);
    EXPECT_THAT(err_, HasSubstr(because));
    EXPECT_THAT(out_, IsEmpty());
  };
  refused({"--from-step", "2", "--picture", "p.png", "--steps", "1,3"},
          "step 1 comes before the step at which the replay begins");
  refused({"--picture", "p.gif", "--steps", "1"}, "ends in .svg, .pdf or .png");
  refused({"--picture", "p.png", "--steps", "100000"}, "beyond the life; its last step is ");
  refused({"--picture", "p.png", "--steps", "1", "--grid", "x"}, "there is no grid 'x'; grids: ");
  refused({"--picture", "p.png", "--steps", "1", "--view", "x"}, "--view");
  refused({"--picture", "p.png", "--steps", "1,2", "--width", "150"}, "at least 200");
  refused({"--picture", "p.png"}, "requires --steps");
  refused({"--steps", "1"}, "requires --picture");
  refused({"--picture", "p.png", "--steps", "1", "--csv", "./p.png"}, "name the same file");
  EXPECT_FALSE(fs::exists(path("p.png")));

  EXPECT_EQ(host({"replay", "a", "--picture", "none/p.png", "--steps", "1"}), 5);
  // Larger than any file may be: the write fails half-way.
  EXPECT_EQ(host({"replay", "a", "--picture", "p.png", "--steps", "1"}, 1024), 5) << err_;
  EXPECT_FALSE(fs::exists(path("p.png")));
}

TEST_F(Host, ReplayWritesIntoTheStandardOutput) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  // Here a file; a rename would leave the report in another one.
  ASSERT_EQ(host({"replay", "a", "--csv", "/proc/self/fd/1"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("reproduced: "), HasSubstr("\nstep,feeder,shield,cells,")));
}

TEST_F(Host, EveryNumberOfTheRecordIsCompared) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  const fs::path file = path("a/champions/gen-0002.json");
  const run::Json whole = run::parse_json(read_file(file), "champion");
  for (const char* field : {"survival", "score", "divisions", "specializations",
                            "refused_divisions", "final_cells", "peak_cells", "cell_steps"}) {
    run::Json champion = whole;
    run::Json& number = champion["replay"][field];
    if (number.is_number_float())
      number = number.get<double>() + 1;
    else
      number = number.get<std::uint64_t>() + 1;
    write_file(file, run::to_text(champion));
    EXPECT_EQ(host({"replay", "a"}), 4) << field;
    EXPECT_THAT(out_, HasSubstr("\n  " + std::string(field) + ": recorded "));
  }
  run::Json champion = whole;
  champion["generation"] = 1;
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("gen-0002.json.generation: 1 in the file, 2 in its name"));
  champion = whole;
  champion["id"] = champion["id"].get<std::uint64_t>() + 1;
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("gen-0002.json.id: "));
}

// ---- looking -----------------------------------------------------------------------------------

TEST_F(Host, ValidateSummarisesAndWritesNothing) {
  EXPECT_EQ(host({"validate", "toy.yaml"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(StartsWith("OK: toy, seed 5\n"), HasSubstr("states: feeder shield")));
  EXPECT_FALSE(fs::exists(path("runs")));
  EXPECT_EQ(host({"validate", "toy.yaml", "--resolved"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("hazard_start: 20"));
}

TEST_F(Host, ValidateDoesNotRoundTheRadius) {
  EXPECT_EQ(host({"validate", "toy.yaml", "--set", "world.radius=30.75"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("radius 30.75,"));
}

TEST_F(Host, PluginsAndDescribeLookIntoTheGivenDirectory) {
  const std::string plugins = SOMAS_BINARY_DIR "/tests/fixtures/plugins";
  EXPECT_EQ(host({"plugins", "--plugin-path", plugins}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("toy_environment"));
  EXPECT_EQ(host({"describe", "toy_environment", "--plugin-path", plugins}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("hazard_start"));
  EXPECT_EQ(host({"describe", "toy_enviroment", "--plugin-path", plugins}), 2);
  EXPECT_THAT(err_, HasSubstr("did you mean 'toy_environment'?"));
}

}  // namespace
}  // namespace somas
