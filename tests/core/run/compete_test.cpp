#include "core/run/compete.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/champion.hpp"
#include "core/run/files.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class Compete : public testing::Test {
 protected:
  Compete() {
    const evolution::Heredity heredity(*experiment_.ecosystem);
    for (std::uint64_t k = 0; k < 3; ++k) {
      const model::Genome genome = test::toy_genome(*experiment_.ecosystem, k);
      write_file(file(k), to_text(genome_to_json(genome, heredity)));
    }
  }
  fs::path file(std::uint64_t k) const {
    return scratch_.path() / ("g" + std::to_string(k) + ".json");
  }
  CompeteReport compete_in(const std::vector<std::uint64_t>& order, bool random = false,
                           unsigned threads = 1) {
    CompeteOptions options;
    options.against_random = random;
    options.seeds = 7;
    options.threads = threads;
    for (const std::uint64_t k : order) options.genomes.push_back(file(k));
    return compete(experiment_, options);
  }

  test::Scratch scratch_;
  experiment::Experiment experiment_ = test::toy_experiment();
};

TEST_F(Compete, PermutedGenomesGivePermutedResults) {
  const CompeteReport report = compete_in({0, 1, 2});
  for (const std::vector<std::uint64_t>& order :
       {std::vector<std::uint64_t>{2, 1, 0}, {1, 2, 0}, {0, 2, 1}}) {
    const CompeteReport permuted = compete_in(order);
    for (std::size_t w = 0; w < 7; ++w) {
      EXPECT_EQ(permuted.bouts[w].seed, report.bouts[w].seed);
      for (std::size_t place = 0; place < 3; ++place) {
        const evaluation::Row &row = permuted.bouts[w].rows[place],
                              &expected = report.bouts[w].rows[order[place]];
        EXPECT_EQ(row.outcome.survival, expected.outcome.survival);
        EXPECT_EQ(row.outcome.cell_steps, expected.outcome.cell_steps);
        EXPECT_EQ(row.outcome.biomass_share, expected.outcome.biomass_share);
      }
    }
  }
}

TEST_F(Compete, SharesOfAWorldAddUpToOne) {
  for (const Bout& bout : compete_in({0, 1}, true).bouts) {
    double sum = 0;
    std::uint64_t survival = 0;
    for (const evaluation::Row& row : bout.rows) {
      sum += row.outcome.biomass_share;
      survival = std::max(survival, row.outcome.survival);
    }
    // A world that nobody outlived the first step of has no biomass to share.
    EXPECT_NEAR(sum, survival > 0 ? 1 : 0, 1e-12);
  }
}

TEST_F(Compete, RandomGenomesAreOthersInEachWorldYetTheSameAgain) {
  const CompeteReport report = compete_in({0}, true);
  EXPECT_EQ(report.competitors.back(), "random");
  EXPECT_EQ(to_csv(report), to_csv(compete_in({0}, true, 3))) << "whatever the threads";
  experiment_.seed = 12;
  EXPECT_NE(to_csv(report), to_csv(compete_in({0}, true)));
}

TEST_F(Compete, NeedsTwo) {
  try {
    static_cast<void>(compete_in({0}));
    FAIL() << "one alone";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("needs two competitors: give --genome twice, or "
                                        "--against random"));
  }
}

TEST(Wins, GoToTheOnlyBestScore) {
  CompeteReport report;
  report.competitors = {"a", "b", "c"};
  for (const std::vector<double>& scores :
       {std::vector<double>{1, 2, 0}, {3, 2, 1}, {2, 2, 1}, {0, 0, 5}, {9, 1, 1}}) {
    Bout& bout = report.bouts.emplace_back();
    for (const double score : scores) bout.rows.push_back({{}, score});
  }
  EXPECT_THAT(wins_of(report).of, ElementsAre(2, 1, 1));
  EXPECT_EQ(wins_of(report).ties, 1u);
  report.objective = "score";
  EXPECT_THAT(to_text(report), HasSubstr("1 above 2 in 2, below in 1: sign test p = 1\n"));
  EXPECT_THAT(to_text(report), HasSubstr("1 above 3 in 4, below in 1: sign test p = 0.375\n"));
}

TEST(SignTest, IsTheTwoSidedBinomialProbability) {
  EXPECT_EQ(sign_test(0, 0), 1);
  EXPECT_EQ(sign_test(5, 5), 1);
  EXPECT_DOUBLE_EQ(sign_test(5, 0), 2.0 / 32);
  EXPECT_DOUBLE_EQ(sign_test(1, 5), 2.0 * (1 + 6) / 64);
  EXPECT_DOUBLE_EQ(sign_test(5, 1), sign_test(1, 5));
  EXPECT_NEAR(sign_test(450, 550), 0.00173053609, 1e-10);
}

}  // namespace
}  // namespace somas::run
