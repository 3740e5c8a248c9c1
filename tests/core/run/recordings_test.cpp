#include "core/run/recordings.hpp"

#include <atomic>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/recording/file.hpp"
#include "core/run/json.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/runner.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;
using experiment::Recorded;
using recording::Recording;
using test::Scratch;
using testing::ElementsAre;
using testing::SizeIs;

class RunRecordings : public testing::Test {
 protected:
  fs::path run_into(const std::string& name, Recorded what, evolution::Mode mode = {}) {
    experiment_.record.what = what;
    experiment_.evolution.mode = mode;
    experiment_.evolution.population = 5;
    experiment_.evolution.generations = 2;
    (void)run(experiment_, {.out = scratch_.path() / name, .threads = 1, .quiet = true}, terminal_,
              {});
    return scratch_.path() / name;
  }
  [[nodiscard]] Champion champion_of(const fs::path& run, std::uint64_t generation) const {
    const fs::path file = champion_path(run, generation);
    return parse_champion(read_file(file), file.string(),
                          evolution::Heredity(*experiment_.ecosystem));
  }

  Scratch scratch_;
  Terminal terminal_{stderr};
  experiment::Experiment experiment_ = test::toy_experiment();
};

TEST_F(RunRecordings, NobodyIsRecordedUnasked) {
  EXPECT_FALSE(fs::exists(run_into("a", {}) / "recordings"));
}

TEST_F(RunRecordings, NeverChangeResults) {
  const fs::path without = run_into("a", Recorded::none), with = run_into("b", Recorded::all);
  for (const char* name : {"generations.csv", "individuals.csv", "champions/gen-0000.json",
                           "champions/gen-0001.json", "summary.json"})
    EXPECT_EQ(read_file(with / name), read_file(without / name)) << name;
}

TEST_F(RunRecordings, AChampionsRecordingIsItsLife) {
  experiment_.record.every = 3;
  const fs::path run = run_into("a", Recorded::champions);
  EXPECT_THAT(Scratch::names_in(run / "recordings"), ElementsAre("gen-0000.h5", "gen-0001.h5"));
  for (std::uint64_t generation = 0; generation < 2; ++generation) {
    const Champion champion = champion_of(run, generation);
    const Recording recorded = recording::read(recording_path(run, generation));
    EXPECT_EQ(recorded.header.provenance.individual, champion.individual.id);
    EXPECT_EQ(recorded.header.provenance.generation, generation);
    EXPECT_EQ(recorded.header.provenance.fitness, champion.individual.fitness);
    EXPECT_EQ(recorded.header.provenance.controller_genes, champion.individual.genome.controller);
    EXPECT_EQ(recorded.header.provenance.resolved_yaml, experiment_.resolved_yaml);
    EXPECT_EQ(recorded.header.provenance.run, "a");
    EXPECT_EQ(recorded.header.seed, champion.seed);
    EXPECT_EQ(recorded.header.every, 3u);
    EXPECT_EQ(recorded.header.fields_every, 3u);
    EXPECT_EQ(recorded.ending.outcomes[0].survival, champion.life.outcome.survival);
    EXPECT_EQ(recorded.ending.outcomes[0].divisions, champion.life.outcome.divisions);
    EXPECT_EQ(recorded.ending.score, champion.life.score);
    ASSERT_EQ(recorded.summaries.size(), champion.life.hashes.size());
    for (std::size_t step = 0; step < recorded.summaries.size(); ++step)
      for (std::size_t state = 0; state < champion.life.census.size(); ++state)
        EXPECT_EQ(recorded.summaries[step].population[state], champion.life.census[state][step]);
  }
}

TEST_F(RunRecordings, AllAreRecordedEachInAFile) {
  const fs::path run = run_into("a", Recorded::all);
  EXPECT_THAT(Scratch::names_in(run / "recordings"),
              SizeIs(2 * (1 + experiment_.evolution.population)));
  std::set<std::vector<std::uint8_t>> genomes;
  for (std::uint64_t id = 0; id < experiment_.evolution.population; ++id) {
    const auto header = recording::read_header(individual_recording_path(run, 0, 1, id));
    EXPECT_EQ(header.provenance.individual, id);
    genomes.insert(header.provenance.controller_genes);
  }
  EXPECT_GT(genomes.size(), 1u);
}

TEST_F(RunRecordings, BothPopulationsHaveTheirChampions) {
  const fs::path run = run_into("a", Recorded::champions, evolution::Mode::coevolution);
  EXPECT_THAT(Scratch::names_in(run / "recordings"),
              ElementsAre("gen-0000-2.h5", "gen-0000.h5", "gen-0001-2.h5", "gen-0001.h5"));
  const auto header = recording::read_header(recording_path(run, 1, 2));
  EXPECT_EQ(header.provenance.population, 2u);
  EXPECT_GT(header.organisms.size(), 1u);
}

TEST_F(RunRecordings, AStopLeavesNoFile) {
  const fs::path run = run_into("a", Recorded::none);
  experiment_.record.what = Recorded::champions;
  const evolution::Heredity heredity(*experiment_.ecosystem);
  Recordings recordings(experiment_, heredity, run);
  const std::atomic<bool> stop = true;
  EXPECT_EQ(recordings.champion(champion_of(run, 1), evaluation::StopToken(stop)), std::nullopt);
  EXPECT_FALSE(fs::exists(run / "recordings"));
}

}  // namespace
}  // namespace somas::run
