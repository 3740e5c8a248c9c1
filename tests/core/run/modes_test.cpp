// Runs in which individuals meet: what their files say, and that records prove themselves.
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evaluation/simulate.hpp"
#include "core/evolution/reproduction.hpp"
#include "core/run/contest.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/runner.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;
using evolution::Mode;
using test::Scratch;
using testing::EndsWith;
using testing::HasSubstr;
using testing::SizeIs;

using Fields = std::vector<std::string>;

Fields split(const std::string& text, char at) {
  Fields fields;
  std::istringstream in(text);
  for (std::string field; std::getline(in, field, at);) fields.push_back(field);
  return fields;
}

class Modes : public testing::TestWithParam<Mode> {
 protected:
  Modes() {
    experiment_.evolution.mode = GetParam();
    experiment_.evolution.population = 8;
    experiment_.evolution.generations = 3;
    experiment_.evolution.roster.size = 2;
    experiment_.evolution.roster.distance = 3;
  }
  RunReport run_into(const std::string& name, unsigned threads = 1) {
    return run(experiment_, {.out = scratch_.path() / name, .threads = threads, .quiet = true},
               terminal_, {});
  }
  std::string text_of(const std::string& file) const { return read_file(scratch_.path() / file); }
  Fields lines_of(const std::string& file) const { return split(text_of(file), '\n'); }
  bool two_populations() const { return GetParam() == Mode::coevolution; }

  Scratch scratch_;
  Terminal terminal_{stderr};
  experiment::Experiment experiment_ = test::toy_experiment();
};

TEST_P(Modes, GiveTheSameBytesForAnyNumberOfThreads) {
  run_into("one", 1);
  run_into("two", 2);
  Fields files = {"generations.csv", "individuals.csv", "summary.json"};
  for (const std::string& name : Scratch::names_in(scratch_.path() / "one/champions"))
    files.push_back("champions/" + name);
  EXPECT_THAT(files, SizeIs(3 + (two_populations() ? 6 : 3)));
  for (const std::string& file : files)
    EXPECT_EQ(text_of("one/" + file), text_of("two/" + file)) << file;
}

TEST_P(Modes, RecordChampionsWhoseRosterLivesTheSameLife) {
  run_into("a");
  const evolution::Heredity heredity(*experiment_.ecosystem);
  for (std::uint64_t generation = 0; generation < 3; ++generation)
    for (std::uint32_t population = 1; population <= (two_populations() ? 2u : 1u); ++population) {
      const fs::path file = champion_path(scratch_.path() / "a", generation, population);
      const std::string text = read_file(file);
      const Champion champion = parse_champion(text, "test", heredity);
      EXPECT_EQ(to_text(champion, heredity), text);
      EXPECT_EQ(champion.population, two_populations() ? population : 0);
      ASSERT_THAT(champion.roster, SizeIs(2));
      const RosterSeat& rival = champion.roster[1 - champion.own_seat];
      EXPECT_EQ(rival.id.has_value(), GetParam() != Mode::hall_of_fame || generation > 0);
      EXPECT_EQ(rival.population, two_populations() ? 3 - population : 0);

      const auto again = record_life(*experiment_.ecosystem, task_of(champion), champion.own_seat);
      EXPECT_EQ(first_difference(champion.life, *again), std::nullopt);
      EXPECT_EQ(again->outcome.survival, champion.life.outcome.survival);
      EXPECT_EQ(again->outcome.biomass_share, champion.life.outcome.biomass_share);
      EXPECT_EQ(champion.individual.trials[0], again->score);
      // The company matters: alone the world is another one.
      const LifeRecord alone =
          record_life(*experiment_.ecosystem, champion.individual.genome, champion.seed).value();
      EXPECT_EQ(first_difference(champion.life, alone), 0u);
    }
}

TEST_P(Modes, ScoreAnIndividualByTheMeanOfItsRows) {
  run_into("a");
  const evolution::Settings& settings = experiment_.evolution;
  const evolution::Heredity heredity(*experiment_.ecosystem);
  std::vector<evolution::Population> populations;
  for (std::uint32_t p = 0; p < evolution::population_count(settings); ++p)
    populations.push_back(
        evolution::initial(settings, heredity, evolution::population_seed(experiment_.seed, p)));
  const Contest contest(settings, heredity, experiment_.seed, 0, populations, {});
  std::vector<std::map<std::size_t, double>> sums(populations.size());
  const std::vector<evaluation::Task> tasks = contest.tasks();
  for (std::size_t m = 0; m < tasks.size(); ++m) {
    const auto result = evaluation::simulate(*experiment_.ecosystem, tasks[m]);
    for (std::size_t s = 0; s < 2; ++s) {
      const evolution::Seat& seat = contest.matches()[m].seats[s];
      if (seat.source != evolution::Source::hall)
        sums[static_cast<std::size_t>(seat.source)][seat.index] += result->rows[s].score;
    }
  }
  const Fields lines = lines_of("a/individuals.csv");
  for (std::size_t p = 0; p < populations.size(); ++p)
    for (std::size_t i = 0; i < 8; ++i) {
      const Fields fields = split(lines[1 + p * 8 + i], ',');
      EXPECT_EQ(fields[0], std::to_string(i));
      EXPECT_DOUBLE_EQ(std::stod(fields[5]), sums[p][i] / 2);
    }
}

TEST_P(Modes, NameTheOpponentsOfEveryIndividual) {
  run_into("a");
  const Fields lines = lines_of("a/individuals.csv");
  EXPECT_THAT(lines[0], EndsWith(two_populations() ? "genome_length,opponents,population"
                                                   : "genome_length,opponents"));
  ASSERT_THAT(lines, SizeIs(1 + 3 * 8 * (two_populations() ? 2 : 1)));
  std::map<std::string, Fields> met;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const Fields fields = split(lines[k], ',');
    const Fields trials = split(fields[7], ';');
    ASSERT_THAT(trials, SizeIs(2)) << lines[k];
    const std::string name = two_populations() ? fields[8] + ":" + fields[0] : fields[0];
    met[name] = trials;
    if (GetParam() == Mode::hall_of_fame) {
      EXPECT_EQ(trials[0] == "random", fields[1] == "0");
    }
  }
  if (GetParam() == Mode::hall_of_fame) return;
  // Whom I met has met me.
  for (const auto& [name, trials] : met)
    for (std::size_t t = 0; t < 2; ++t) {
      ASSERT_TRUE(met.contains(trials[t])) << trials[t];
      EXPECT_EQ(met[trials[t]][t], name);
    }
}

TEST_P(Modes, WriteALineForEachPopulationOfAGeneration) {
  run_into("a");
  const Fields lines = lines_of("a/generations.csv");
  EXPECT_THAT(lines[0], HasSubstr("cell_steps,champion_biomass_share"));
  ASSERT_THAT(lines, SizeIs(1 + 3 * (two_populations() ? 2 : 1)));
  EXPECT_THAT(lines_of("a/timing.csv"), SizeIs(1 + 3));
  const evolution::Heredity heredity(*experiment_.ecosystem);
  for (std::uint32_t population = 1; population <= (two_populations() ? 2u : 1u); ++population) {
    const fs::path run = scratch_.path() / "a";
    const Champion champion =
        parse_champion(read_file(champion_path(run, 1, population)), "test", heredity);
    EXPECT_EQ(champion_id(run, 1, population), champion.individual.id);
    const std::size_t line = two_populations() ? 2 + population : 2;
    EXPECT_EQ(std::stod(split(lines[line], ',')[18]), champion.life.outcome.biomass_share);
    EXPECT_EQ(std::stoull(split(lines[line], ',')[14]), GetParam() == Mode::rosters ? 8u : 16u);
  }
  EXPECT_EQ(last_generation(scratch_.path() / "a"), 2u);
}

TEST_P(Modes, KeepTheGenomesThatBringAPluginDown) {
  test::ToyOptions broken;
  broken.broken_fitness = true;
  experiment_.ecosystem = test::toy_ecosystem(broken);
  try {
    run_into("a");
    FAIL() << "no exception";
  } catch (const PluginError& error) {
    EXPECT_THAT(error.what(), HasSubstr("generation 0, simulation 0: fitness: score"));
  }
  const Json failed = parse_json(text_of("a/failed-genome.json"), "failed");
  ASSERT_THAT(failed["roster"], SizeIs(2));
  const evolution::Heredity heredity(*experiment_.ecosystem);
  EXPECT_NO_THROW(
      static_cast<void>(parse_genome(to_text(failed["roster"][1]["genome"]), "test", heredity)));
}

INSTANTIATE_TEST_SUITE_P(WithCompany, Modes,
                         testing::Values(Mode::rosters, Mode::coevolution, Mode::hall_of_fame),
                         [](const auto& mode) { return std::string(name_of(mode.param)); });

class TwoPopulations : public Modes {};

TEST_P(TwoPopulations, AreDrawnFromStreamsOfTheirOwn) {
  run_into("a");
  const Fields lines = lines_of("a/individuals.csv");
  const evolution::Heredity heredity(*experiment_.ecosystem);
  const auto genome = [&](std::uint32_t population) {
    return parse_genome(read_file(champion_path(scratch_.path() / "a", 0, population)), "test",
                        heredity)
        .genome;
  };
  EXPECT_FALSE(genome(1) == genome(2));
}

INSTANTIATE_TEST_SUITE_P(WithCompany, TwoPopulations, testing::Values(Mode::coevolution));

// ---- the record of a roster ---------------------------------------------------------------------

TEST(RosterRecord, RefusesRostersThatCannotBe) {
  const auto ecosystem = test::toy_ecosystem();
  const evolution::Heredity heredity(*ecosystem);
  Champion champion;
  champion.experiment = "toy";
  champion.individual.genome = test::toy_genome(*ecosystem, 1);
  champion.seed = 5;
  champion.roster = {{.key = 1, .x = -3}, {.key = 2, .x = 3, .id = 4}};
  champion.roster[1].genome = test::toy_genome(*ecosystem, 2);
  champion.life = record_life(*ecosystem, task_of(champion), 0).value();
  const Json whole = parse_json(to_text(champion, heredity), "whole");

  const auto complaint = [&](const Json& json) -> std::string {
    try {
      static_cast<void>(parse_champion(to_text(json), "gen.json", heredity));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint(whole), "");
  Json json = whole;
  json["roster"][1]["key"] = 1;
  EXPECT_THAT(complaint(json), HasSubstr("gen.json.roster[1].key: expected a key that no other"));
  json = whole;
  json["roster"][0]["champion"] = false;
  EXPECT_THAT(complaint(json), HasSubstr("gen.json.roster[0]: \"genome\" is missing"));
  json = whole;
  json["roster"][1]["champion"] = true;
  EXPECT_THAT(complaint(json), HasSubstr("gen.json.roster: expected one champion"));
  json = whole;
  json["roster"].erase(1);
  EXPECT_THAT(complaint(json), HasSubstr("gen.json.roster: expected two organisms at least"));
}

TEST(RosterRecord, OfAnOrganismAloneIsThatOfASingleRun) {
  const auto ecosystem = test::toy_ecosystem();
  const model::Genome genome = test::toy_genome(*ecosystem, 3);
  const LifeRecord single = record_life(*ecosystem, genome, 8).value();
  evaluation::Task roster{{{.genome = &genome, .key = 1, .x = 0, .y = 0}}, 8};
  EXPECT_EQ(first_difference(single, *record_life(*ecosystem, roster, 0)), std::nullopt);
  // Far company that touches nothing changes the world's hash, and nothing of the life.
  const model::Genome other = test::toy_genome(*ecosystem, 4);
  roster.roster.push_back({.genome = &other, .key = 2, .x = 40, .y = 0});
  const LifeRecord two = record_life(*ecosystem, roster, 0).value();
  EXPECT_EQ(two.outcome.survival, single.outcome.survival);
  EXPECT_EQ(two.outcome.divisions, single.outcome.divisions);
  EXPECT_LT(two.outcome.biomass_share, 1);
  EXPECT_EQ(single.outcome.biomass_share, 1);
}

}  // namespace
}  // namespace somas::run
