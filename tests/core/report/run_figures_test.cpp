// Figures of a run's tables, written by hand here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/report/chart.hpp"
#include "core/report/evolution_figure.hpp"
#include "core/report/lineage_figure.hpp"
#include "core/report/run_tables.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "tests/core/report/drawn.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using somas::test::Scratch;
using test::filled;
using test::title;
using test::written;
using testing::AllOf;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class FiguresOfARun : public testing::Test {
 protected:
  FiguresOfARun() {
    make_run("a", 5, {{10, 4}, {20, 8}, {40, 16}});
    run::write_file(scratch.path() / "a/individuals.csv",
                    "id,generation,parent1,parent2,operator,fitness,genome_length\n"
                    "0,0,,,random,10,5\n"
                    "1,0,,,random,4,5\n"
                    "2,1,0,1,crossover,20,5\n"
                    "3,1,0,,elite,9,5\n"
                    "4,2,2,3,crossover+mutation,40,5\n"
                    "5,2,3,,mutation,7,5\n");
  }
  struct Row {
    double best, median;
  };
  void make_run(const std::string& name, int seed, const std::vector<Row>& rows,
                const std::string& objective = "survival") {
    const fs::path run = scratch.path() / name;
    fs::create_directories(run);
    run::write_file(run / "manifest.json", "{\"seed\": " + std::to_string(seed) +
                                               ", \"objective\": \"" + objective + "\"}");
    std::string text = "generation,best,q3,median,q1,champion_id\n";
    for (std::size_t g = 0; g < rows.size(); ++g) {
      text += std::to_string(g);
      for (const double value :
           {rows[g].best, rows[g].median + 1, rows[g].median, rows[g].median - 1})
        text += "," + std::to_string(value);
      text += "," + std::to_string(2 * g) + "\n";
    }
    run::write_file(run / "generations.csv", text);
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return scratch.path() / name; }
  std::string evolution(const std::vector<std::string>& runs, std::uint32_t population = 1) {
    std::vector<fs::path> paths;
    for (const std::string& run : runs) paths.push_back(path(run));
    return evolution_figure(paths, population, {.width_mm = 85}, warnings);
  }

  Scratch scratch;
  std::vector<std::string> warnings;
};

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const run::UsageError& error) {
    return error.what();
  }
  return "not refused";
}

TEST_F(FiguresOfARun, EvolutionHasAxesWithUnitsAndNamesTheRun) {
  const std::string svg = evolution({"a"});
  EXPECT_THAT(written(svg),
              AllOf(HasSubstr("generation\n"), HasSubstr("survival (steps)\n"), HasSubstr("best\n"),
                    HasSubstr("median\n"), HasSubstr("quartiles\n"), HasSubstr("40\n")));
  EXPECT_THAT(title(svg), HasSubstr("Run a (seed 5); 3 generations."));
  EXPECT_TRUE(svg == evolution({"a"}));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST_F(FiguresOfARun, SeveralRunsAreReplicates) {
  make_run("b", 6, {{12, 4}, {30, 8}, {50, 16}});
  const std::string svg = evolution({"a", "b"});
  EXPECT_THAT(title(svg), HasSubstr("Medians and ranges of 2 replicates: a (seed 5), b (seed 6); 3 "
                                    "generations."));
  EXPECT_THAT(written(svg), HasSubstr("range of replicates' best\n"));
  // A directory of runs stands for the runs in it.
  EXPECT_TRUE(evolution({"."}) == svg);
}

TEST_F(FiguresOfARun, ReplicatesOfDifferentLengthAreShownAsFarAsAllGot) {
  make_run("b", 6, {{12, 4}, {30, 8}});
  EXPECT_THAT(title(evolution({"a", "b"})), HasSubstr("2 generations."));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("from 2 to 3 generations")));
}

TEST_F(FiguresOfARun, ACampaignIsALineAndABandACondition) {
  make_run("c/m=1/replicate-001", 1, {{10, 4}, {20, 8}});
  make_run("c/m=1/replicate-002", 2, {{14, 4}, {22, 8}});
  make_run("c/m=2/replicate-001", 1, {{30, 4}, {50, 8}, {90, 9}});
  const std::string head = "run,condition,replicate,seed,status,directory,m,generations\n";
  const std::string lines =
      "1,m=1,1,1,complete,m=1/replicate-001,1,2\n"
      "2,m=1,2,2,complete,m=1/replicate-002,1,2\n"
      "3,m=2,1,1,complete,m=2/replicate-001,2,3\n";
  run::write_file(path("c/index.csv"), head + lines + "4,m=2,2,2,failed,m=2/replicate-002,2,\n");
  const std::string svg = evolution({"c"});
  EXPECT_THAT(title(svg), HasSubstr("Campaign c, a line a condition: median over its replicates"));
  EXPECT_THAT(written(svg), AllOf(HasSubstr("m=1 (2 replicates)\n"), HasSubstr("m=2 (1 replicate)"),
                                  HasSubstr("best survival (steps)\n")));
  // The band of each.
  EXPECT_EQ(filled(svg, colour_of_state(0)), 1);
  EXPECT_EQ(filled(svg, colour_of_state(1)), 1);
  EXPECT_EQ(filled(svg, colour_of_state(2)), 0);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("condition m=2: 1 run of 2 not complete, left out")));
}

TEST_F(FiguresOfARun, ACampaignOfOneConditionIsItsReplicates) {
  make_run("c/all/replicate-001", 1, {{10, 4}, {20, 8}});
  make_run("c/all/replicate-002", 2, {{14, 4}, {22, 8}});
  run::write_file(path("c/index.csv"),
                  "condition,status,directory\n"
                  "all,complete,all/replicate-001\nall,complete,all/replicate-002\n");
  EXPECT_TRUE(evolution({"c"}) == evolution({"c/all"}));
  EXPECT_THAT(refusal([&] {
                (void)evolution({"a", "c"});
              }),
              HasSubstr("is a campaign, which is drawn alone"));
  run::write_file(path("c/index.csv"), "condition,status,directory\nall,waiting,all/r\n");
  EXPECT_THAT(refusal([&] { (void)evolution({"c"}); }), HasSubstr("no run of this campaign is"));
}

TEST_F(FiguresOfARun, FitnessOfDifferentKindsIsNotMixed) {
  make_run("b", 6, {{1, 1}}, "biomass");
  EXPECT_THAT(refusal([&] {
                (void)evolution({"a", "b"});
              }),
              AllOf(HasSubstr("'survival'"), HasSubstr("'biomass'")));
}

TEST_F(FiguresOfARun, OneGenerationIsDrawnAsPoints) {
  make_run("b", 6, {{12, 4}});
  EXPECT_EQ(filled(evolution({"b"}), rgb(0x0072B2)), 1);
}

TEST_F(FiguresOfARun, EmptyAndDamagedTablesAreNamed) {
  make_run("b", 6, {});
  EXPECT_THAT(refusal([&] { (void)evolution({"b"}); }),
              HasSubstr("no generation was finished; there is nothing to draw"));
  fs::create_directory(path("empty"));
  EXPECT_THAT(refusal([&] { (void)evolution({"empty"}); }),
              HasSubstr("is no run directory, and there is none in it"));
  EXPECT_THAT(refusal([&] { (void)evolution({"a"}, 2); }), HasSubstr("population 2 is not in"));
  run::write_file(path("b/generations.csv"), "generation,best\n0\n");
  EXPECT_THAT(refusal([&] { (void)evolution({"b"}); }),
              HasSubstr("generations.csv:2: 1 field, but the header has 2"));
  run::write_file(path("b/generations.csv"), "generation,best\n0,x\n");
  EXPECT_THAT(refusal([&] { (void)evolution({"b"}); }),
              HasSubstr("generations.csv:2: best: 'x' is no number"));
}

TEST_F(FiguresOfARun, TheLineOfFirstParentsLeadsToTheChampion) {
  const Lineage lineage = read_lineage(path("a"), 2, 4, 1);
  ASSERT_EQ(lineage.line.size(), 3u);
  EXPECT_EQ(lineage.line[0].id, 0u);
  EXPECT_EQ(lineage.line[1].id, 2u);
  EXPECT_EQ(lineage.line[2].id, 4u);
  EXPECT_FALSE(lineage.second_parents[0]);
  ASSERT_TRUE(lineage.second_parents[1]);
  EXPECT_EQ(lineage.second_parents[1]->id, 1u);
  ASSERT_TRUE(lineage.second_parents[2]);
  EXPECT_EQ(lineage.second_parents[2]->id, 3u);
  // 4 comes from 2 and 3, which come from 0 and 1.
  EXPECT_THAT(lineage.ancestors, ElementsAre(2, 2, 1));
}

TEST_F(FiguresOfARun, LineageMarksOperatorsAndSecondParents) {
  const std::string svg = lineage_figure(path("a"), {}, 1, {.width_mm = 85});
  EXPECT_THAT(written(svg), AllOf(HasSubstr("random\n"), HasSubstr("crossover\n"),
                                  HasSubstr("crossover+mutation\n"), HasSubstr("ancestors\n"),
                                  HasSubstr("survival (steps)\n")));
  EXPECT_THAT(title(svg),
              HasSubstr("generation 2: champion 4, from individual 0 of generation 0."));
  // A member of the line, and the legend.
  EXPECT_EQ(filled(svg, rgb(0xE69F00)), 2);
  EXPECT_EQ(filled(svg, rgb(0xD55E00)), 2);
  EXPECT_TRUE(svg == lineage_figure(path("a"), 2, 1, {.width_mm = 85}));
}

TEST_F(FiguresOfARun, ALineThatBreaksOffIsSaid) {
  EXPECT_THAT(refusal([&] { (void)lineage_figure(path("a"), 7, 1, {}); }),
              HasSubstr("generation 7 is not on record; the last one is 2"));
  run::write_file(path("a/individuals.csv"),
                  "id,generation,parent1,parent2,operator,fitness,genome_length\n"
                  "4,2,2,3,crossover,40,5\n");
  EXPECT_THAT(refusal([&] { (void)lineage_figure(path("a"), {}, 1, {}); }),
              HasSubstr("individual 3 of generation 1, an ancestor of the champion, is not on"));
}

TEST(Tables, ReadQuotedFields) {
  const Scratch scratch;
  run::write_file(scratch.path() / "t.csv", "a,b\n\"1,\"\"2\"\"\",3\r\n");
  const Table table(scratch.path() / "t.csv");
  ASSERT_EQ(table.rows(), 1u);
  EXPECT_EQ(table.text(0, "a"), "1,\"2\"");
  EXPECT_EQ(table.natural(0, "b"), 3u);
  EXPECT_THAT(refusal([&] { (void)table.text(0, "c"); }), HasSubstr("columns: a, b"));
}

TEST(Ticks, AreRoundNumbersWithinTheAxis) {
  EXPECT_THAT(ticks_of({0, 100, ""}, 5), ElementsAre(0, 20, 40, 60, 80, 100));
  EXPECT_THAT(ticks_of({0, 3, "", true}, 10), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(ticks_of({0, 0.5, ""}, 5),
              ElementsAre(DoubleEq(0), DoubleEq(0.1), DoubleEq(0.2), DoubleEq(3 * 0.1),
                          DoubleEq(0.4), DoubleEq(0.5)));
  EXPECT_THAT(ticks_of({-10, 10, ""}, 4), ElementsAre(-10, -5, 0, 5, 10));
  EXPECT_EQ(round_end(1046), 1200);
  EXPECT_EQ(round_end(100), 100);
  EXPECT_EQ(round_end(0), 1);
}

}  // namespace
}  // namespace somas::report
