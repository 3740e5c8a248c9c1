// Campaigns: replicates and sweeps, by real processes.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <sstream>

#include <gmock/gmock.h>

#include "core/run/json.hpp"
#include "tests/core/host/toy_runs.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using test::eventually;
using test::HostProcess;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Row = std::map<std::string, std::string>;

/// Lines of a CSV file, by column.
std::vector<Row> table(const fs::path& file) {
  std::istringstream lines(read_file(file));
  const auto split = [](const std::string& whole) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (const char c : whole) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        fields.emplace_back();
      else
        fields.back() += c;
    }
    return fields;
  };
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = split(line);
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> values = split(line);
    EXPECT_EQ(values.size(), names.size()) << line;
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = values.at(i);
  }
  return rows;
}

class Campaigns : public test::ToyRuns {
 protected:
  Campaigns() {
    write_file(path("sweep.yaml"), test::toy_yaml +
                                       "replicates: 2\n"
                                       "sweep:\n"
                                       "  evolution.mutation: [0.2, 0.8]\n"
                                       "  environments.field.hazard: [0.1, 0.3]\n");
  }

  [[nodiscard]] std::vector<Row> index(const std::string& campaign) const {
    return table(path(campaign + "/index.csv"));
  }
  [[nodiscard]] std::vector<std::string> column(const std::string& campaign,
                                                const std::string& name) const {
    std::vector<std::string> values;
    for (const Row& row : index(campaign)) values.push_back(row.at(name));
    return values;
  }
  [[nodiscard]] std::size_t complete(const std::string& campaign) const {
    std::error_code error;
    if (!fs::exists(path(campaign + "/index.csv"), error)) return 0;
    const std::vector<std::string> statuses = column(campaign, "status");
    return static_cast<std::size_t>(std::count(statuses.begin(), statuses.end(), "complete"));
  }

  /// The same tables, and the same results of every run.
  void expect_same_campaigns(const std::string& one, const std::string& other) const {
    for (const char* file : {"/index.csv", "/summary.csv", "/experiment.yaml"})
      EXPECT_EQ(text(one + file), text(other + file)) << file;
    for (const std::string& run : column(one, "directory"))
      expect_same(one + "/" + run, other + "/" + run);
  }

  fs::path faulty(const std::string& sweep) const {
    fs::path file = path("faulty.yaml");
    write_file(file,
               "somas: 1\nname: faulty\nseed: 5\n"
               "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " SOMAS_BINARY_DIR
               "/tests/fixtures/faulty]\n"
               "world: {max_steps: 90, max_cells: 20, morphogens: {size: 9}}\n"
               "evolution: {population: 12, generations: 2}\n"
               "environments:\n"
               "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 60}\n"
               "  faults: {plugin: faulty_environment}\n"
               "specialization: {plugin: toy_tree}\n"
               "controller: {plugin: toy_controller}\n"
               "fitness: {plugin: toy_fitness}\n"
               "sweep:\n" +
                   sweep);
    return file;
  }
};

TEST_F(Campaigns, EveryRunIsTheSingleRunOfItsSeedAndValuesByteForByte) {
  ASSERT_EQ(host({"sweep.yaml", "--out", "c", "--workers", "2"}), 0) << err_;
  EXPECT_THAT(out_, StartsWith("c: 8 runs of 4 conditions, 8 complete, best "));
  EXPECT_THAT(err_, AllOf(HasSubstr("cost: 288 evaluations"),
                          HasSubstr("4 conditions x 2 replicates = 8 runs, seeds 5 to 6"),
                          HasSubstr("8 of 8 runs done")));
  EXPECT_THAT(column("c", "seed"), testing::ElementsAre("5", "6", "5", "6", "5", "6", "5", "6"));
  fs::rename(path("c"), path("campaign"));
  const std::vector<Row> rows = index("campaign");
  for (const std::size_t i : {0u, 7u}) {
    // The command on record, word by word, makes the same files, the manifest included.
    const std::string run = rows[i].at("directory");
    const std::string file = "campaign/" + run + "/manifest.json";
    const run::Json manifest = run::parse_json(text(file), file);
    std::vector<std::string> words = manifest["command_line"].get<std::vector<std::string>>();
    words.erase(words.begin());
    ASSERT_EQ(host(words), 0) << err_;
    expect_same("campaign/" + run, "c/" + run);
    EXPECT_EQ(text(file), text("c/" + run + "/manifest.json"));
  }
  // And so does what a person would type.
  ASSERT_EQ(host({"toy.yaml", "--set", "evolution.mutation=0.8", "--set",
                  "environments.field.hazard=0.1", "--seed", "6", "--out", "hand"}),
            0);
  const std::string same = "campaign/mutation=0.8+hazard=0.1/replicate-002";
  EXPECT_EQ(text("hand/individuals.csv"), text(same + "/individuals.csv"));
  EXPECT_EQ(text("hand/resolved.yaml"), text(same + "/resolved.yaml"));
}

TEST_F(Campaigns, ResultsDoNotDependOnLayoutPoolOrCompany) {
  ASSERT_EQ(host({"sweep.yaml", "--out", "two", "--workers", "2"}), 0) << err_;
  ASSERT_EQ(host({"sweep.yaml", "--out", "one", "--workers", "1", "--runs-at-once", "1", "-q"}), 0);
  EXPECT_EQ(out_ + err_, "");
  expect_same_campaigns("two", "one");
  ASSERT_EQ(host({"sweep.yaml", "--out", "threads", "--threads", "2"}), 0) << err_;
  expect_same_campaigns("two", "threads");
  // Factors in another order, levels in another order, one more of them, and more replicates.
  ASSERT_EQ(host({"toy.yaml", "--sweep", "environments.field.hazard=0.3,0.2,0.1", "--sweep",
                  "evolution.mutation=0.8", "--replicates", "3", "--out", "other"}),
            0)
      << err_;
  EXPECT_EQ(index("other").size(), 9u);
  for (const char* replicate : {"1", "2"})
    for (const char* hazard : {"0.1", "0.3"}) {
      const std::string levels[] = {"mutation=0.8", "hazard=" + std::string(hazard)};
      const std::string run = "/replicate-00" + std::string(replicate) + "/individuals.csv";
      EXPECT_EQ(text("two/" + levels[0] + "+" + levels[1] + run),
                text("other/" + levels[1] + "+" + levels[0] + run));
    }
}

TEST_F(Campaigns, TablesSayWhatTheRunsSay) {
  ASSERT_EQ(host({"sweep.yaml", "--out", "c"}), 0) << err_;
  std::map<std::string, std::vector<double>> finals;
  for (const Row& row : index("c")) {
    const std::vector<Row> generations =
        table(path("c/" + row.at("directory") + "/generations.csv"));
    double best = 0;
    for (const Row& generation : generations)
      best = std::max(best, std::stod(generation.at("best")));
    EXPECT_EQ(std::stod(row.at("best")), best);
    EXPECT_EQ(generations.at(std::stoul(row.at("best_generation"))).at("best"), row.at("best"));
    EXPECT_EQ(row.at("final_best"), generations.back().at("best"));
    EXPECT_EQ(row.at("final_median"), generations.back().at("median"));
    EXPECT_EQ(row.at("generations"), "3");
    finals[row.at("condition")].push_back(std::stod(row.at("final_best")));
  }
  const std::vector<Row> summary = table(path("c/summary.csv"));
  ASSERT_EQ(summary.size(), 4u);
  for (const Row& row : summary) {
    const std::vector<double>& two = finals.at(row.at("condition"));
    EXPECT_EQ(row.at("complete"), "2");
    EXPECT_EQ(std::stod(row.at("final_best_median")), (two[0] + two[1]) / 2);
    EXPECT_EQ(std::stod(row.at("final_best_max")), std::max(two[0], two[1]));
    EXPECT_EQ(std::stod(row.at("final_best_iqr")), std::abs(two[0] - two[1]) / 2);
  }
}

TEST_F(Campaigns, KilledAtAnyTimeAndResumedEndAsThoseNeverStopped) {
  const std::vector<std::string> longer = {"--set", "evolution.generations=12"};
  std::vector<std::string> whole = {"sweep.yaml", "--out", "whole"};
  whole.insert(whole.end(), longer.begin(), longer.end());
  ASSERT_EQ(host(whole), 0) << err_;
  std::vector<std::string> words = {"sweep.yaml", "--out", "c", "--runs-at-once", "2"};
  words.insert(words.end(), longer.begin(), longer.end());
  std::size_t before = 0;
  for (const std::size_t least : {1u, 4u}) {
    HostProcess process(scratch_.path(), words);
    ASSERT_TRUE(eventually([&] { return complete("c") >= least; }));
    process.send(SIGKILL);
    EXPECT_EQ(process.wait(), 1000 + SIGKILL);
    before = complete("c");
    ASSERT_LT(before, 8u) << "it ended before it was killed";
    words = {"resume", "c", "--runs-at-once", "2"};
  }
  ASSERT_EQ(host({"resume", "c", "--workers", "1"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("; " + std::to_string(before) + " done"));
  expect_same_campaigns("whole", "c");
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path("c")))
    EXPECT_THAT(entry.path().filename().string(), Not(AnyOf(HasSubstr(".tmp"), "run.lock")));
  // There is nothing left to do.
  ASSERT_EQ(host({"resume", "c"}), 0) << err_;
  expect_same_campaigns("whole", "c");
}

TEST_F(Campaigns, KilledBeforeTheyBeganStartAnew) {
  fs::create_directories(path("c/conditions"));
  for (const char* file :
       {"c/run.lock", "c/experiment.yaml", "c/conditions/mutation=9.yaml", "c/.campaign.json.tmp1"})
    write_file(path(file), "");
  ASSERT_EQ(host({"sweep.yaml", "--out", "c"}), 0) << err_;
  EXPECT_EQ(complete("c"), 8u);
  EXPECT_FALSE(fs::exists(path("c/conditions/mutation=9.yaml")));
  // One that has begun is never overwritten.
  ASSERT_EQ(host({"sweep.yaml", "--out", "c"}), 2);
  EXPECT_THAT(err_, HasSubstr("directory c is not empty"));
}

TEST_F(Campaigns, OneThatWasKilledAtItsEndIsClosed) {
  ASSERT_EQ(host({"sweep.yaml", "--out", "c"}), 0) << err_;
  // As after a kill before the files were flushed.
  const std::string run = "c/" + column("c", "directory")[3];
  const std::string before = text(run + "/individuals.csv");
  write_file(path(run + "/run.lock"), "");
  write_file(path(run + "/individuals.csv"), before.substr(0, before.size() / 2));
  ASSERT_EQ(host({"resume", "c"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("; 7 done"));
  EXPECT_EQ(text(run + "/individuals.csv"), before);
}

TEST_F(Campaigns, ASignalStopsThemAndAResumeGoesOn) {
  HostProcess process(scratch_.path(),
                      {"sweep.yaml", "--out", "c", "--generations", "100000", "--runs-at-once", "3",
                       "--sweep", "evolution.mutation=0.8"});
  ASSERT_TRUE(
      eventually([&] { return generations_in("c/mutation=0.8+hazard=0.1/replicate-001") >= 2; }));
  // One process at a time.
  EXPECT_EQ(host({"resume", "c"}), 2);
  EXPECT_THAT(err_, HasSubstr("c is in use by process"));
  process.send(SIGTERM);
  EXPECT_EQ(process.wait(), 143);
  EXPECT_THAT(column("c", "status"),
              testing::UnorderedElementsAre("stopped", "stopped", "stopped", "waiting"));
  for (const std::string& status : column("c", "status"))
    EXPECT_THAT(status, AnyOf("stopped", "waiting"));
}

TEST_F(Campaigns, AConditionThatFailsNeverStopsTheOthers) {
  faulty(
      "  fault:\n"
      "    none: {}\n"
      "    reference: {environments.faults.fault: throw, environments.faults.step: 0}\n"
      "    variation: {controller.plugin: faulty_controller, controller.fault: throw}\n"
      "    some: {environments.faults.fault: throw}\n");
  const int code = host({"faulty.yaml", "--replicates", "2", "--out", "c"});
  const std::vector<Row> rows = index("c");
  ASSERT_EQ(rows.size(), 8u);
  for (const Row& row : rows) {
    const std::string fault = row.at("fault");
    const bool fails = fault == "reference" || fault == "variation";
    EXPECT_EQ(row.at("status"), fails ? "failed" : "complete") << fault;
    EXPECT_EQ(row.at("reason").empty(), !fails) << fault;
    EXPECT_EQ(row.at("reason").find("as was asked for") != std::string::npos, fails) << fault;
    EXPECT_EQ(row.at("generations"), fault == "reference" ? "" : fails ? "1" : "2") << fault;
    if (fails) continue;
    EXPECT_EQ(row.at("set_aside") != "0", fault == "some");
  }
  // That of the first that failed.
  EXPECT_EQ(code, 3) << err_;
  EXPECT_THAT(out_, StartsWith("c: 8 runs of 4 conditions, 4 complete, 4 failed (see index.csv)"));
  EXPECT_THAT(err_, HasSubstr("warning: run fault=reference/replicate-001 failed: no evaluator can "
                              "simulate this experiment"));
  // They fail again, the same way, and the others are left alone.
  const std::string before = text("c/index.csv");
  EXPECT_EQ(host({"resume", "c"}), 3);
  EXPECT_EQ(text("c/index.csv"), before);
}

TEST_F(Campaigns, GoOnWithoutARunThatCrashesTheCoordinator) {
  faulty(
      "  fault:\n"
      "    variation: {controller.plugin: faulty_controller, controller.fault: segfault}\n"
      "    none: {}\n");
  EXPECT_EQ(host({"faulty.yaml", "--out", "c", "--runs-at-once", "1", "--workers", "1"}), 3);
  EXPECT_THAT(err_, HasSubstr("somas-host: SIGSEGV in controller: "));
  EXPECT_THAT(column("c", "status"), testing::ElementsAre("failed", "complete"));
  EXPECT_THAT(column("c", "reason")[0], StartsWith("SIGSEGV in controller: "));
  EXPECT_THAT(out_, StartsWith("c: 2 runs of 2 conditions, 1 complete, 1 failed"));
  // It stays out, unless somebody thinks that it will do now.
  EXPECT_EQ(host({"resume", "c"}), 3) << err_;
  EXPECT_THAT(err_, testing::Not(HasSubstr("SIGSEGV")));
  EXPECT_EQ(host({"resume", "c", "--accept-changes", "--quiet"}), 3) << err_;
  EXPECT_THAT(err_, HasSubstr("SIGSEGV"));
}

TEST_F(Campaigns, NothingStartsUnlessAllConditionsAreSound) {
  write_file(path("bad.yaml"), test::toy_yaml +
                                   "sweep:\n"
                                   "  evolution.mutation: [0.2, 1.5]\n"
                                   "  evolution.mutatoin: [1, 2]\n"
                                   "  environments.field.hazard: [0.1, x]\n");
  EXPECT_EQ(host({"bad.yaml", "--out", "c"}), 2);
  EXPECT_THAT(err_, HasSubstr("bad.yaml:13:29: evolution.mutation: 1.5 is out of range; allowed: "
                              "0 to 1 (condition mutation=1.5"));
  EXPECT_THAT(err_, HasSubstr("bad.yaml:14:3: evolution.mutatoin: unknown key"));
  EXPECT_THAT(err_, HasSubstr("did you mean 'mutation'?\n"));
  EXPECT_THAT(err_, HasSubstr("bad.yaml:15:36: environments.field.hazard: expected a number"));
  EXPECT_FALSE(fs::exists(path("c")));
  EXPECT_EQ(host({"toy.yaml", "--sweep", "evolution.mutation=0.2,1.5", "--out", "c"}), 2);
  EXPECT_THAT(err_, StartsWith("somas-host: --sweep evolution.mutation=0.2,1.5: "
                               "evolution.mutation: 1.5 is out of range"));
  write_file(path("same.yaml"), test::toy_yaml + "sweep: {x: {a: {}, b: {seed: 1}}}\n");
  EXPECT_EQ(host({"same.yaml", "--out", "c"}), 2);
  EXPECT_THAT(err_, HasSubstr("'seed' cannot be swept"));
  write_file(path("same.yaml"),
             test::toy_yaml + "sweep: {x: {a: {}, b: {world.max_steps: 200}}}\n");
  EXPECT_EQ(host({"same.yaml", "--out", "c"}), 2);
  EXPECT_THAT(err_, HasSubstr("the conditions x=a and x=b are the same experiment"));
  EXPECT_FALSE(fs::exists(path("c")));
}

TEST_F(Campaigns, ADryRunAndValidateSayThePlanAndMakeNothing) {
  ASSERT_EQ(host({"validate", "sweep.yaml", "--replicates", "3"}), 0) << err_;
  EXPECT_EQ(out_,
            "OK: toy: 4 conditions x 3 replicates = 12 runs, seeds 5 to 7\n"
            "  factor evolution.mutation: 0.2, 0.8\n"
            "  factor environments.field.hazard: 0.1, 0.3\n"
            "  mutation=0.2+hazard=0.1: 3 generations of 12 evaluations\n"
            "  mutation=0.2+hazard=0.3: 3 generations of 12 evaluations\n"
            "  mutation=0.8+hazard=0.1: 3 generations of 12 evaluations\n"
            "  mutation=0.8+hazard=0.3: 3 generations of 12 evaluations\n"
            "  in all: 432 evaluations\n");
  const std::string plan = out_.substr(4);
  ASSERT_EQ(host({"sweep.yaml", "--replicates", "3", "--dry-run"}), 0) << err_;
  EXPECT_EQ(out_, plan);
  EXPECT_THAT(err_, AllOf(StartsWith("cost: 432 evaluations"), HasSubstr("on the disk")));
  EXPECT_FALSE(fs::exists(path("runs")));
}

TEST_F(Campaigns, GetMoreReplicatesLevelsAndGenerationsAndKeepWhatTheyHave) {
  ASSERT_EQ(host({"toy.yaml", "--sweep", "evolution.mutation=0.2,0.8", "--out", "c"}), 0) << err_;
  const std::string run = "c/mutation=0.2/replicate-001";
  const std::string clock = text(run + "/timing.csv");
  ASSERT_EQ(host({"resume", "c", "--replicates", "2"}), 0) << err_;
  ASSERT_EQ(host({"resume", "c", "--sweep", "evolution.mutation=0.2,0.5,0.8"}), 0) << err_;
  EXPECT_EQ(text(run + "/timing.csv"), clock) << "it was run again";
  ASSERT_EQ(host({"toy.yaml", "--sweep", "evolution.mutation=0.2,0.5,0.8", "--replicates", "2",
                  "--out", "whole"}),
            0);
  expect_same_campaigns("whole", "c");
  ASSERT_EQ(host({"resume", "c", "--generations", "4"}), 0) << err_;
  EXPECT_THAT(column("c", "generations"), testing::Each("4"));

  EXPECT_EQ(host({"resume", "c", "--replicates", "1"}), 2);
  EXPECT_THAT(err_, HasSubstr("--replicates 1: the campaign has 2 already"));
  EXPECT_EQ(host({"resume", "c", "--sweep", "evolution.mutation=0.2,0.9"}), 2);
  EXPECT_THAT(err_, HasSubstr("the condition mutation=0.5 of c would go"));
  EXPECT_EQ(host({"resume", "c", "--sweep", "evolution.crossover=0.2,0.9"}), 2);
  EXPECT_THAT(err_, HasSubstr("with others it is another campaign"));
  EXPECT_EQ(host({"resume", "c", "--generations", "2"}), 2);
  EXPECT_THAT(err_, HasSubstr("has finished 4 already"));
  EXPECT_EQ(host({"resume", run, "--replicates", "3"}), 2);
  EXPECT_THAT(err_, HasSubstr("is no campaign"));
}

TEST_F(Campaigns, AreSeededByAGenomeThatIsKept) {
  ASSERT_EQ(host({"toy.yaml", "--out", "a"}), 0) << err_;
  fs::rename(path("a/champions/gen-0002.json"), path("seed.json"));
  ASSERT_EQ(host({"toy.yaml", "--replicates", "2", "--genome", "seed.json", "--out", "c"}), 0);
  fs::remove(path("seed.json"));
  for (const char* run : {"c/all/replicate-001", "c/all/replicate-002"})
    EXPECT_THAT(text(std::string(run) + "/individuals.csv"), HasSubstr(",seed,"));
  ASSERT_EQ(host({"resume", "c", "--replicates", "3"}), 0) << err_;
  EXPECT_THAT(text("c/all/replicate-003/individuals.csv"), HasSubstr(",seed,"));
}

}  // namespace
}  // namespace somas
