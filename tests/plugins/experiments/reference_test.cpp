// The engine lives as the plain reference does (tests/core/model/reference/), to the last bit: in
// every shipped experiment, and in random worlds out of all bundled plugins.
//
// SOMAS_REFERENCE_SEEDS=1000 makes the number of random worlds a thousand, and =5000-6000 makes
// them those of the seeds 5000 to 5999; at the end the test tells how much was compared.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <regex>

#include <gtest/gtest.h>

#include "tests/core/model/reference/compare.hpp"
#include "tests/core/model/reference/seeds.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/plugins/experiments/random_world.hpp"
#include "tests/plugins/experiments/reference_lives.hpp"

namespace somas::reference {
namespace {

using test::Cast;

// ---- the shipped experiments --------------------------------------------------------------------

TEST(Reference, LivesAsTheEngineDoesWithTheChampionOfExperiment1) {
  const experiment::Experiment exp1 = test::shipped("exp1.yaml");
  const run::Champion champion = test::champion_of_experiment1();
  Cast cast(*exp1.ecosystem);
  cast.add(champion.individual.genome);
  Events events;
  const auto difference =
      compare_lives(*exp1.ecosystem, cast.on_a_ring(0), champion.seed, 5000, &events);
  ASSERT_FALSE(difference) << difference->text();
  EXPECT_GT(events.births, 900u);
}

std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(SOMAS_SOURCE_DIR "/experiments"))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

class ShippedExperiment : public testing::TestWithParam<std::string> {};

TEST_P(ShippedExperiment, LivesInTheEngineAsInTheReference) {
  const experiment::Experiment experiment = test::shipped(GetParam());
  const model::Ecosystem& ecosystem = *experiment.ecosystem;
  Events events;
  const auto compare = [&](Cast& cast, std::uint64_t steps) {
    const auto difference = compare_lives(ecosystem, cast.on_a_ring(1.5), 3, steps, &events);
    EXPECT_FALSE(difference) << difference->text();
  };

  // Random genomes alone and together; the champion where its genes have a meaning.
  const model::Genome random = test::liveliest(ecosystem, 11, 200, 60);
  Cast alone(ecosystem), company(ecosystem);
  alone.add(random);
  compare(alone, 150);
  company.add(random);
  company.add(test::liveliest(ecosystem, 12, 50, 60));
  if (experiment.controller.id == "grn" && ecosystem.fixed_tree() != nullptr) {
    const evolution::Heredity heredity(ecosystem);
    model::Genome champion = test::champion_of_experiment1().individual.genome;
    Rng rng(1, 0, 0, stable_key("test"), 0);
    heredity.conform(champion, rng);
    company.add(champion);
  }
  compare(company, 200);
  std::uint64_t deaths = 0;
  for (const auto& [cause, count] : events.deaths) deaths += count;
  EXPECT_GT(events.births, 0u);
  EXPECT_GT(events.specializations, 0u);
  EXPECT_GT(deaths, 0u);
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param.substr(0, info.param.find('.'));
  std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return name;
}
INSTANTIATE_TEST_SUITE_P(Reference, ShippedExperiment, testing::ValuesIn(shipped_names()),
                         test_name);

// ---- random worlds ------------------------------------------------------------------------------

constexpr std::uint64_t usual_seeds = 80;

/// One to four organisms side by side in the world of a seed; later their cells are replaced,
/// twice.
std::optional<Difference> compare_in(const model::Ecosystem& ecosystem, std::uint64_t seed,
                                     Events& events) {
  Cast cast(ecosystem);
  for (std::uint64_t organism = 0; organism < 1 + seed % 4; ++organism)
    cast.add(test::liveliest(ecosystem, 100 * seed + organism, 12, 30));
  Twins twins(ecosystem, cast.on_a_ring(1.3), seed);
  std::optional<Difference> difference = twins.run(45);
  for (int heaps = 0; heaps < 2 && !difference && !twins.engine().finished(); ++heaps) {
    test::Heap(twins.engine(), seed);
    twins.adopt();
    difference = twins.run(12);
  }
  events.add(twins.reference().events);
  return difference;
}

void expect_that_all_happened(const Events& events) {
  EXPECT_GT(events.births, 500u);
  EXPECT_GT(events.specializations, 200u);
  EXPECT_GT(events.refused_divisions, 100u);
  EXPECT_GT(events.gifts, 1000u);
  EXPECT_GT(events.gifts_to_strangers, 1000u);
  EXPECT_GT(events.shrunk_gifts, 100u);
  EXPECT_GT(events.legacies, 100u);
  EXPECT_GT(events.scarce_demands, 1000u);
  EXPECT_GT(events.crowded_rooms, 100u);
  EXPECT_GT(events.coincident_pairs, 100u);
  EXPECT_GT(events.stranger_touches, events.stranger_contacts);
  EXPECT_GT(events.stranger_contacts, 1000u);
  EXPECT_GT(events.crawls, 1000u);
  EXPECT_GT(events.forces_from_outside, 1000u);
  EXPECT_GT(events.hits, 100u);
  EXPECT_GT(events.random_axes, 10u);
  for (const char* cause :
       {"starvation", "apoptosis", "outside", "particle_aggression", "toxin_gradient"})
    EXPECT_GT(events.deaths.contains(cause) ? events.deaths.at(cause) : 0, 10u) << cause;
}

TEST(Reference, LivesAsTheEngineDoesInRandomWorlds) {
  const Seeds seeds = seeds_asked_for(usual_seeds);
  const test::Scratch scratch;
  const std::filesystem::path file = scratch.path() / "world.yaml";
  Events events;
  for (std::uint64_t seed = seeds.first; seed < seeds.end; ++seed) {
    const test::RandomWorld world(seed);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + world.text());
    run::write_file(file, world.text());
    const experiment::Experiment experiment = test::load_with_plugins(file);
    const auto difference = compare_in(*experiment.ecosystem, seed, events);
    ASSERT_FALSE(difference) << difference->text();
  }
  std::printf("compared %llu steps, %llu cells\n", static_cast<unsigned long long>(events.steps),
              static_cast<unsigned long long>(events.cell_steps));
  if (seeds.count() >= usual_seeds) expect_that_all_happened(events);
}

TEST(Reference, MeetsEveryBundledPluginInItsRandomWorlds) {
  std::string all;
  for (std::uint64_t seed = 0; seed < usual_seeds; ++seed) all += test::RandomWorld(seed).text();
  for (const auto& entry : std::filesystem::directory_iterator(SOMAS_BINARY_DIR "/plugins")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".somas.so")) continue;
    const std::regex word("[ ]" + name.substr(0, name.find('.')) + "[:},\\s]");
    EXPECT_TRUE(std::regex_search(all, word)) << name;
  }
}

// ---- it can fail --------------------------------------------------------------------------------

TEST(Reference, IsFoundToDifferWithoutTheDamperOfPairs) {
  const experiment::Experiment exp1 = test::shipped("exp1.yaml");
  Cast cast(*exp1.ecosystem);
  cast.add(test::champion_of_experiment1().individual.genome);
  Twins twins(*exp1.ecosystem, cast.on_a_ring(0), 1);
  twins.reference().mistake = Mistake::no_damper;
  const auto difference = twins.run(100);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->what, "cell 0 of organism 0: vx") << difference->text();
}

}  // namespace
}  // namespace somas::reference
