// A step allocates nothing once everything has been as large before: worlds live through some
// steps, go back to where they were, and live through the same steps again, while operator new
// counts.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <execinfo.h>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/model/simulation.hpp"
#include "core/run/champion.hpp"
#include "core/run/files.hpp"

namespace {

constexpr int deepest = 24;
std::atomic<bool> counting{false};
std::atomic<std::uint64_t> allocations{0};
void* first_caller[deepest];
std::atomic<int> first_depth{0};

void* allocate(std::size_t size, std::size_t alignment) {
  if (counting.load(std::memory_order_relaxed) && allocations.fetch_add(1) == 0)
    first_depth = ::backtrace(first_caller, deepest);
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, whole == 0 ? alignment : whole);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// The other forms call these. Were they inlined, the compiler would miss the malloc of the free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return allocate(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace somas::model {
namespace {

experiment::Experiment shipped(const std::string& name) {
  return experiment::load(
      std::string(SOMAS_SOURCE_DIR "/experiments/") + name,
      {.overrides = {"world.max_steps=1200"}, .plugin_directories = {SOMAS_BINARY_DIR "/plugins"}});
}

/// What `steps` more steps of the simulation allocate, and where the first time.
struct Count {
  std::uint64_t allocations = 0;
  std::string first;
};

Count count(Simulation& life, int steps) {
  allocations = 0;
  counting = true;
  for (int s = 0; s < steps; ++s) life.step();
  counting = false;
  Count result{allocations, {}};
  if (result.allocations == 0) return result;
  char** names = ::backtrace_symbols(first_caller, first_depth);
  for (int n = 0; names != nullptr && n < first_depth; ++n)
    result.first += std::string(names[n]) + "\n";
  std::free(static_cast<void*>(names));
  return result;
}

/// Lives from here three times; the third must not allocate. (Buffers that change places at every
/// reorganisation are both as large as they need be after two.)
void expect_no_allocation(Simulation& life, int steps) {
  void* loaded[1];
  ::backtrace(loaded, 1);  // what it needs it allocates at the first call
  const WorldState start = life.state();
  for (int s = 0; s < steps; ++s) ASSERT_TRUE(life.step());
  const std::uint64_t once = life.hash();
  life.mutable_state() = start;
  for (int s = 0; s < steps; ++s) life.step();
  life.mutable_state() = start;
  const Count again = count(life, steps);
  EXPECT_EQ(again.allocations, 0u) << "the first one from\n" << again.first;
  EXPECT_EQ(life.hash(), once) << "these were not the same steps";
}

/// Of some random genomes the first whose founder lives and divides.
Genome survivor(const Ecosystem& ecosystem, std::uint64_t steps) {
  const evolution::Heredity heredity(ecosystem);
  for (std::uint64_t number = 0; number < 1000; ++number) {
    Rng rng(7, 0, 0, stable_key("test"), number);
    Genome genome = heredity.random(rng);
    const Phenotype phenotype = ecosystem.express(genome);
    const RosterEntry founder{&phenotype, 1, 0, 0};
    Simulation life(ecosystem, {&founder, 1}, 5);
    while (life.steps_done() < steps && life.step()) continue;
    if (!life.finished() && life.outcomes()[0].divisions > 0) return genome;
  }
  throw std::runtime_error("no genome lives so long");
}

TEST(Allocations, AreCountedWhereACellIsBornForTheFirstTime) {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const Phenotype phenotype = exp1.ecosystem->express(survivor(*exp1.ecosystem, 60));
  const RosterEntry founder{&phenotype, 1, 0, 0};
  Simulation life(*exp1.ecosystem, {&founder, 1}, 5);
  EXPECT_GT(count(life, 60).allocations, 0u);
}

TEST(Allocations, OfTheChampionsStepsAreNoneOnceWarm) {
  const experiment::Experiment exp1 = shipped("exp1.yaml");
  const evolution::Heredity heredity(*exp1.ecosystem);
  const run::Champion champion = run::parse_champion(
      run::read_file(SOMAS_SOURCE_DIR "/bench/data/champion_exp1.json"), "champion", heredity);
  const Phenotype phenotype = exp1.ecosystem->express(champion.individual.genome);
  const RosterEntry founder{&phenotype, 1, 0, 0};
  Simulation life(*exp1.ecosystem, {&founder, 1}, champion.seed);
  while (life.steps_done() < 400) ASSERT_TRUE(life.step());
  const std::uint64_t divisions = life.outcomes()[0].divisions;
  expect_no_allocation(life, 300);
  // Births, deaths and specializations were among them.
  EXPECT_GT(life.outcomes()[0].divisions, divisions + 100);
  EXPECT_GT(life.outcomes()[0].specializations, 0u);
  EXPECT_GT(life.outcomes()[0].divisions - life.outcomes()[0].peak_cells, 100u);
}

TEST(Allocations, OfEveryOtherWorldsStepsAreNoneOnceWarm) {
  for (const char* name :
       {"exp2.yaml", "exp1_ctrnn.yaml", "exp1_evolved_tree.yaml", "walls.yaml",
        "toxin_gradient.yaml", "two_nutrients.yaml", "seasons.yaml", "sorting.yaml"}) {
    SCOPED_TRACE(name);
    const experiment::Experiment world = shipped(name);
    const Phenotype phenotype = world.ecosystem->express(survivor(*world.ecosystem, 70));
    const RosterEntry founder{&phenotype, 1, 0, 0};
    Simulation life(*world.ecosystem, {&founder, 1}, 5);
    ASSERT_TRUE(life.step());
    expect_no_allocation(life, 60);
  }
}

TEST(Allocations, OfTwoOrganismsStepsAreNoneOnceWarm) {
  const experiment::Experiment world = shipped("competition.yaml");
  const Phenotype phenotype = world.ecosystem->express(survivor(*world.ecosystem, 70));
  const RosterEntry founders[] = {{&phenotype, 1, -2, 0}, {&phenotype, 2, 2, 0}};
  Simulation life(*world.ecosystem, founders, 5);
  ASSERT_TRUE(life.step());
  expect_no_allocation(life, 60);
}

}  // namespace
}  // namespace somas::model
