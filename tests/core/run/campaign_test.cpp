// The plan of a campaign and its tables: pure functions.
#include "core/run/campaign.hpp"

#include <gmock/gmock.h>

#include "core/run/campaign_progress.hpp"
#include "core/run/campaign_tables.hpp"

namespace somas::run {
namespace {

using experiment::Design;
using experiment::Factor;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

Factor factor(const std::string& name, const std::vector<std::string>& values) {
  Factor factor{.name = name, .levels = {}};
  for (const std::string& value : values)
    factor.levels.push_back({value, {{name + "=" + value, {}, {}}}});
  return factor;
}

std::vector<std::string> names(const std::vector<Factor>& factors) {
  std::vector<std::string> names;
  for (const Condition& condition : conditions_of(
           {.name = "n", .seed = 1, .replicates = 1, .factors = factors, .original_yaml = ""}))
    names.push_back(condition.name);
  return names;
}

TEST(Conditions, AreAllCombinationsTheLastFactorFastest) {
  EXPECT_THAT(names({factor("evolution.mutation", {"0.2", "0.5"}),
                     factor("controller.plugin", {"grn", "ctrnn"})}),
              ElementsAre("mutation=0.2+controller=grn", "mutation=0.2+controller=ctrnn",
                          "mutation=0.5+controller=grn", "mutation=0.5+controller=ctrnn"));
  EXPECT_THAT(names({}), ElementsAre("all"));
}

TEST(Conditions, HaveNamesThatDirectoriesCanHave) {
  EXPECT_THAT(names({factor("a.x", {"1"}), factor("b.x", {"2"})}), ElementsAre("a.x=1+b.x=2"));
  EXPECT_THAT(
      names({factor("a.budgets.0", {"[1, 2]", "[1; 2]", "../..", "/"})}),
      ElementsAre("budgets.0=1-2", "budgets.0=1-2-2", "budgets.0=..-..", "budgets.0=level"));
  std::vector<Factor> many;
  for (char c = 'a'; c <= 'z'; ++c)
    many.push_back(factor(std::string(12, c), {std::string(12, c)}));
  EXPECT_EQ(names(many)[0].size(), 200u);
}

Campaign two_by_two() {
  Campaign campaign;
  campaign.file = "e.yaml";
  campaign.directory = "c";
  campaign.seed = 7;
  campaign.replicates = 2;
  campaign.factors = {"world.radius"};
  campaign.conditions = conditions_of({.name = "n",
                                       .seed = 7,
                                       .replicates = 2,
                                       .factors = {factor("world.radius", {"1", "2"})},
                                       .original_yaml = ""});
  return campaign;
}

TEST(Campaigns, SeedsDependOnTheReplicateAlone) {
  const Campaign campaign = two_by_two();
  std::vector<std::string> seeds, directories;
  for (const PlannedRun& run : campaign.runs()) {
    seeds.push_back(std::to_string(run.seed));
    directories.push_back(run.directory.string());
  }
  EXPECT_THAT(seeds, ElementsAre("7", "8", "7", "8"));
  EXPECT_THAT(directories, ElementsAre("radius=1/replicate-001", "radius=1/replicate-002",
                                       "radius=2/replicate-001", "radius=2/replicate-002"));
}

TEST(Campaigns, NameTheCommandOfEachRun) {
  Campaign campaign = two_by_two();
  campaign.overrides = {"evolution.population=5"};
  EXPECT_THAT(
      campaign.command_of(campaign.runs()[3], 0),
      ElementsAre("somas-host", "run", "e.yaml", "--single", "--set", "evolution.population=5",
                  "--set", "world.radius=2", "--seed", "8", "--out", "c/radius=2/replicate-002"));
}

TEST(CampaignTables, HaveALineARunAndStatisticsOfTheCompleteOnes) {
  Campaign campaign = two_by_two();
  campaign.replicates = 4;
  const auto ended = [](RunStatus status, double best) {
    return RunStanding{.status = status,
                       .generations = 3,
                       .best = best,
                       .best_generation = 1,
                       .final_best = best - 1,
                       .final_median = best / 2,
                       .set_aside = 0,
                       .reason = status == RunStatus::failed ? "a, \"b\"\nc" : ""};
  };
  std::vector<RunStanding> standings(8);
  standings[0] = ended(RunStatus::complete, 10);
  standings[1] = ended(RunStatus::complete, 40);
  standings[2] = ended(RunStatus::failed, 1000);
  standings[3] = ended(RunStatus::complete, 20);
  const std::string index = index_csv(campaign, standings);
  EXPECT_THAT(index,
              StartsWith("run,condition,replicate,seed,status,directory,world.radius,"
                         "generations,best,best_generation,final_best,final_median,"
                         "set_aside,reason\n"
                         "1,radius=1,1,7,complete,radius=1/replicate-001,1,3,10,1,9,5,0,\n"));
  EXPECT_THAT(index, HasSubstr("\n3,radius=1,3,9,failed,radius=1/replicate-003,1,3,1000,1,999,500,"
                               "0,\"a, \"\"b\"\" c\"\n"));
  EXPECT_THAT(index, HasSubstr("\n5,radius=2,1,7,waiting,radius=2/replicate-001,2,,,,,,,\n"));
  EXPECT_EQ(summary_csv(campaign, standings),
            "condition,world.radius,runs,complete,failed,"
            "best_median,best_lower_quartile,best_upper_quartile,best_iqr,best_min,best_max,"
            "final_best_median,final_best_lower_quartile,final_best_upper_quartile,final_best_iqr,"
            "final_best_min,final_best_max,"
            "final_median_median,final_median_lower_quartile,final_median_upper_quartile,"
            "final_median_iqr,final_median_min,final_median_max\n"
            "radius=1,1,4,3,1,20,15,30,15,10,40,19,14,29,15,9,39,10,7.5,15,7.5,5,20\n"
            "radius=2,2,4,0,0,,,,,,,,,,,,,,,,,,\n");
}

TEST(CampaignLine, FitsAndTellsWhatMattersMost) {
  const CampaignStanding standing{.runs = 12,
                                  .done = 3,
                                  .failed = 1,
                                  .active = 4,
                                  .share = 0.25,
                                  .rate = 54,
                                  .seconds_left = 200};
  EXPECT_EQ(long_text(standing),
            "3 of 12 runs done, 1 failed, 4 at work; 54 evaluations/s, 3m20s left");
  EXPECT_EQ(text_within(standing, 100),
            "[#####...............] 3 of 12 runs done, 1 failed, 4 at work; 54 evaluations/s, "
            "3m20s left");
  for (const std::size_t columns : {20, 40, 60, 79, 120})
    EXPECT_LE(text_within(standing, columns).size(), columns);
  EXPECT_THAT(text_within(standing, 60), HasSubstr("3m20s left"));
}

}  // namespace
}  // namespace somas::run
