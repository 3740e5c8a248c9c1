#include "core/run/champion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ChampionFile : public testing::Test {
 protected:
  ChampionFile() {
    champion_.experiment = "toy";
    champion_.generation = 3;
    champion_.seed = 0xFFFFFFFFFFFFFFF0ull;
    champion_.individual.id = 63;
    champion_.individual.parents = {41, 45};
    champion_.individual.origin = evolution::Operator::crossover_mutation;
    champion_.individual.genome = test::toy_genome(*ecosystem_, 7);
    evolution::assign_fitness(champion_.individual, {0.1, 1.0 / 3});
    champion_.life = record_life(*ecosystem_, champion_.individual.genome, champion_.seed).value();
  }

  std::string edited(const std::string& from, const std::string& to) const {
    std::string text = to_text(champion_, heredity_);
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    return text.replace(place, from.size(), to);
  }
  std::string complaint(const std::string& text) const {
    try {
      static_cast<void>(parse_champion(text, "gen-0003.json", heredity_));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }

  std::shared_ptr<const model::Ecosystem> ecosystem_ = test::toy_ecosystem();
  evolution::Heredity heredity_{*ecosystem_};
  Champion champion_;
};

TEST_F(ChampionFile, ReadsBackExactly) {
  const std::string text = to_text(champion_, heredity_);
  const Champion read = parse_champion(text, "test", heredity_);
  EXPECT_TRUE(read.genes_match_bytes);
  EXPECT_EQ(read.experiment, "toy");
  EXPECT_EQ(read.generation, 3u);
  EXPECT_EQ(read.seed, champion_.seed);
  EXPECT_EQ(read.individual.id, 63u);
  EXPECT_THAT(read.individual.parents, ElementsAre(41, 45));
  EXPECT_EQ(read.individual.origin, evolution::Operator::crossover_mutation);
  EXPECT_EQ(read.individual.genome, champion_.individual.genome);
  EXPECT_EQ(read.individual.fitness, champion_.individual.fitness);
  EXPECT_EQ(read.individual.trials, champion_.individual.trials);
  EXPECT_EQ(read.life.hashes, champion_.life.hashes);
  EXPECT_EQ(read.life.census, champion_.life.census);
  EXPECT_EQ(read.life.states, champion_.life.states);
  EXPECT_EQ(read.life.score, champion_.life.score);
  EXPECT_EQ(read.life.outcome.cell_steps, champion_.life.outcome.cell_steps);
  EXPECT_EQ(to_text(read, heredity_), text);
}

TEST_F(ChampionFile, ReplayedFromItsFileItLivesTheSameLife) {
  const Champion read = parse_champion(to_text(champion_, heredity_), "test", heredity_);
  const LifeRecord again = record_life(*ecosystem_, read.individual.genome, read.seed).value();
  EXPECT_FALSE(again.hashes.empty());
  EXPECT_EQ(first_difference(read.life, again), std::nullopt);
}

TEST_F(ChampionFile, AnEditedGeneCountsAndIsNoticed) {
  const std::string first = std::to_string(champion_.individual.genome.controller[0]);
  const Champion read =
      parse_champion(edited("\"bytes\": [" + first, "\"bytes\": [77"), "test", heredity_);
  EXPECT_FALSE(read.genes_match_bytes);
  EXPECT_EQ(read.individual.genome.controller[0], 77);
}

TEST_F(ChampionFile, ErrorsNameThePlace) {
  EXPECT_THAT(complaint(edited("somas-champion/1", "somas-champion/9")),
              HasSubstr("gen-0003.json: format is \"somas-champion/9\""));
  EXPECT_THAT(complaint(edited("crossover+mutation", "sorcery")),
              HasSubstr("gen-0003.json.operator: expected the name of an operator"));
  EXPECT_THAT(complaint(edited("\"bytes\": [", "\"bytes\": [300, ")),
              HasSubstr("gen-0003.json.genome.controller.genes: controller: from_json: a byte is 0 "
                        "to 255"));
  EXPECT_THAT(complaint(edited("\"bytes\": [", "\"bytes\": [\"x\", ")),
              HasSubstr("gen-0003.json.genome.controller.genes.bytes[0]: expected an integer"));
  EXPECT_THAT(complaint(edited("\"count\": ", "\"count\": 1")),
              HasSubstr("gen-0003.json.steps.world_hash: expected a hash a step"));
}

TEST_F(ChampionFile, AGenomeStandsAloneOrInAChampion) {
  const model::Genome& genome = champion_.individual.genome;
  EXPECT_EQ(parse_genome(to_text(champion_, heredity_), "test", heredity_).genome, genome);
  EXPECT_EQ(parse_genome(to_text(genome_to_json(genome, heredity_)), "test", heredity_).genome,
            genome);
}

TEST_F(ChampionFile, NamesTheControllerOfItsGenome) {
  const GenomeOwners grn{.controller = {"grn", "0.1"}, .specialization = {}};
  const GenomeOwners ctrnn{.controller = {"ctrnn", "0.1"}, .specialization = {}};
  const std::string text = to_text(champion_, heredity_, grn);
  EXPECT_EQ(parse_genome(text, "test", heredity_, grn).genome, champion_.individual.genome);
  EXPECT_THAT(parse_genome(text, "test", heredity_, grn).warnings, IsEmpty());
  const std::string expected =
      "gen.json.genome.controller: the genome was made for the controller 'grn', version 0.1; "
      "this experiment's controller is 'ctrnn'";
  const auto refusal = [&](const auto& parse) -> std::string {
    try {
      static_cast<void>(parse(text, "gen.json", heredity_, ctrnn));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(parse_genome), expected);
  EXPECT_EQ(refusal(parse_champion), expected);
}

TEST_F(ChampionFile, AnotherVersionOfTheControllerIsAWarning) {
  const std::string text =
      to_text(champion_, heredity_, {.controller = {"grn", "0.1"}, .specialization = {}});
  EXPECT_THAT(parse_genome(text, "gen.json", heredity_,
                           {.controller = {"grn", "0.2"}, .specialization = {}})
                  .warnings,
              ElementsAre("gen.json.genome.controller: the genome was made for the controller "
                          "'grn', version 0.1; here it is version 0.2"));
}

TEST_F(ChampionFile, AFileThatNamesNoControllerLoadsOrCausesDoubt) {
  const GenomeOwners grn{.controller = {"grn", "0.1"}, .specialization = {}};
  EXPECT_EQ(parse_genome(to_text(champion_, heredity_), "test", heredity_, grn).genome,
            champion_.individual.genome);
  try {
    static_cast<void>(parse_genome("{\"controller\": {\"genes\": {\"weights\": []}}}", "gen.json",
                                   heredity_, grn));
    FAIL() << "no exception";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("; the file does not say which controller it is for: is it "
                                        "'grn'?"));
  }
}

TEST_F(ChampionFile, AnEditedGenomeAloneIsNoticedToo) {
  const std::string first = std::to_string(champion_.individual.genome.controller[0]);
  EXPECT_THAT(parse_genome(edited("\"bytes\": [" + first, "\"bytes\": [77"), "gen.json", heredity_)
                  .warnings,
              ElementsAre("gen.json: the genome was edited: genes and bytes disagree; the genes "
                          "count"));
}

TEST_F(ChampionFile, RecordingsDifferFromTheFirstStepThatDoes) {
  LifeRecord other = champion_.life;
  EXPECT_EQ(first_difference(other, champion_.life), std::nullopt);
  ASSERT_GT(other.hashes.size(), 4u);
  other.hashes[3] ^= 1;
  other.hashes[4] ^= 1;
  EXPECT_EQ(first_difference(other, champion_.life), 3u);
  other.census[0][1] += 1;
  EXPECT_EQ(first_difference(other, champion_.life), 1u);
  other = champion_.life;
  other.hashes.pop_back();
  EXPECT_EQ(first_difference(other, champion_.life), other.hashes.size());
}

TEST_F(ChampionFile, ARecordingAsCsvHasALineAStep) {
  LifeRecord life;
  life.states = {"a", "b,c"};
  life.hashes = {1, 0xABC};
  life.census = {{1, 2}, {0, 3}};
  EXPECT_EQ(to_csv(life),
            "step,a,\"b,c\",cells,hash\n"
            "0,1,0,1,0000000000000001\n"
            "1,2,3,5,0000000000000abc\n");
}

}  // namespace
}  // namespace somas::run
