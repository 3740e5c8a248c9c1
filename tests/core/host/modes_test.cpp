// Several organisms in one world, from the command line, on toy plugins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/json.hpp"
#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class HostModes : public testing::Test {
 protected:
  HostModes() {
    write_file(path("toy.yaml"),
               "somas: 1\nname: toy\nseed: 5\n"
               "plugins: [" SOMAS_BINARY_DIR
               "/tests/fixtures/plugins]\n"
               "world: {max_steps: 100, max_cells: 20, morphogens: {size: 9}}\n"
               "evolution: {population: 8, generations: 3, trials: 2, roster: {distance: 3}}\n"
               "environments:\n  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
               "specialization: {plugin: toy_tree}\ncontroller: {plugin: toy_controller}\n"
               "fitness: {plugin: toy_fitness}\n");
  }
  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  int host(std::vector<std::string> arguments) {
    HostProcess process(scratch_.path(), std::move(arguments));
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  int run_mode(const std::string& mode, const std::string& out) {
    return host({"toy.yaml", "--set", "evolution.mode=" + mode, "--set",
                 "world.strangers={adhere: true, feed: true}", "--out", out});
  }

  Scratch scratch_;
  std::string out_, err_;
};

TEST_F(HostModes, ReplayReproducesEveryChampionOfEachMode) {
  for (const std::string mode : {"rosters", "coevolution", "hall_of_fame"}) {
    ASSERT_EQ(run_mode(mode, mode), 0) << err_;
    for (const char* generation : {"0", "1", "2"}) {
      EXPECT_EQ(host({"replay", mode, "--generation", generation}), 0) << err_;
      EXPECT_THAT(out_, AllOf(HasSubstr("\nwith "), HasSubstr("; share of biomass "),
                              HasSubstr("reproduced: survival and all ")));
      const bool two = mode == "coevolution";
      EXPECT_EQ(host({"replay", mode, "--generation", generation, "--population", "2"}),
                two ? 0 : 2);
      if (!two) {
        EXPECT_THAT(err_, HasSubstr("only mode coevolution has two populations"));
      }
    }
  }
}

TEST_F(HostModes, AReplayComparesShareAndCompany) {
  ASSERT_EQ(run_mode("rosters", "a"), 0) << err_;
  const fs::path file = path("a/champions/gen-0002.json");
  const run::Json whole = run::parse_json(read_file(file), "champion");
  run::Json champion = whole;
  champion["replay"]["biomass_share"] = 2;
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a"}), 4);
  EXPECT_THAT(out_, HasSubstr("\n  biomass_share: recorded 2, replayed 0."));

  champion = whole;
  for (run::Json& seat : champion["roster"])
    if (!seat["champion"].get<bool>()) seat["x"] = seat["x"].get<double>() + 0.5;
  write_file(file, run::to_text(champion));
  EXPECT_EQ(host({"replay", "a"}), 4);
  EXPECT_THAT(out_, HasSubstr("first differing step 0"));

  write_file(file, run::to_text(whole));
  EXPECT_EQ(host({"replay", "a", "--anatomy"}), 2);
  EXPECT_THAT(err_, HasSubstr("--anatomy is of an organism alone in its world; this champion had 1 "
                              "for company"));
}

TEST_F(HostModes, SettingsThatDoNotGoTogetherAreRefused) {
  const auto complaint = [&](std::vector<std::string> sets) {
    std::vector<std::string> words = {"validate", "toy.yaml"};
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    EXPECT_EQ(host(words), 2) << out_;
    return err_;
  };
  EXPECT_THAT(complaint({}), HasSubstr("toy.yaml:6:74: evolution.roster.distance: has no meaning "
                                       "in evolution.mode solo; allowed modes: "));
  EXPECT_THAT(complaint({"evolution.mode=rosters", "evolution.roster.size=3"}),
              HasSubstr("evolution.population: 8 does not fill rosters of 3"));
  EXPECT_THAT(complaint({"evolution.mode=coevolution", "evolution.roster.size=3"}),
              HasSubstr("evolution.roster.size: 3 is odd"));
  EXPECT_THAT(complaint({"evolution.mode=rosters", "evolution.roster.distance=61"}),
              HasSubstr("evolution.roster.distance: 61 is outside the world; allowed: at most "
                        "world.radius, 60"));
  EXPECT_THAT(complaint({"evolution.mode=duels"}), HasSubstr("allowed: solo, rosters, "));
  EXPECT_EQ(host({"validate", "toy.yaml", "--set", "evolution.mode=rosters"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("  mode: rosters, 2 organisms a world\n"));
}

TEST_F(HostModes, SavedChampionsCompete) {
  ASSERT_EQ(run_mode("rosters", "a"), 0) << err_;
  const std::string first = "a/champions/gen-0000.json", last = "a/champions/gen-0002.json";
  const std::string mode = "evolution.mode=rosters";
  ASSERT_EQ(host({"compete", "toy.yaml", "--set", mode, "--genome", first, "--genome", last,
                  "--seeds", "3", "--csv", "c.csv"}),
            0)
      << err_;
  EXPECT_THAT(out_, AllOf(StartsWith("toy: 2 competitors in 3 worlds; "),
                          HasSubstr("  2: a/champions/gen-0002.json\n"), HasSubstr("sign test p")));
  EXPECT_THAT(
      read_file(path("c.csv")),
      StartsWith("seed,competitor,genome,survival,censored,biomass_share,score,peak_cells\n"));
  EXPECT_EQ(host({"compete", "toy.yaml", "--set", mode, "--genome", first, "--against", "random"}),
            0)
      << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr(" in 30 worlds"), HasSubstr("  2: random\n")));
  EXPECT_EQ(host({"compete", "toy.yaml", "--set", mode, "--genome", first}), 2);
  EXPECT_THAT(err_, HasSubstr("needs two competitors"));
  EXPECT_EQ(host({"compete", "toy.yaml", "--set", mode, "--genome", first, "--genome", last,
                  "--csv", first}),
            2);
  EXPECT_THAT(err_, HasSubstr("is one of the genomes"));
  EXPECT_EQ(host({"compete", "toy.yaml", "--set", mode, "--against", "everybody"}), 2);
}

}  // namespace
}  // namespace somas
