// Threads that share the steps of a world: the team itself, and that worlds do not notice it.
#include "core/model/team.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

// ---- the team -----------------------------------------------------------------------------------

TEST(Team, RunsEveryPartOnce) {
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    Team team(threads, 1);
    for (unsigned parts = 1; parts <= threads; ++parts) {
      for (int again = 0; again < 50; ++again) {
        std::array<std::atomic<int>, 8> runs{};
        const auto work = [&](unsigned part) { ++runs[part]; };
        team.run(parts, work);
        for (unsigned part = 0; part < runs.size(); ++part)
          ASSERT_EQ(runs[part], part < parts ? 1 : 0) << threads << " threads, part " << part;
      }
    }
  }
}

TEST(Team, RunsPartsAtOnceAndTheFirstByTheCaller) {
  Team team(3, 1);
  std::atomic<unsigned> there = 0;
  std::array<std::thread::id, 3> who;
  const auto meet = [&](unsigned part) {
    who[part] = std::this_thread::get_id();
    ++there;
    while (there < 3) std::this_thread::yield();
  };
  team.run(3, meet);
  EXPECT_EQ(who[0], std::this_thread::get_id());
  EXPECT_EQ(std::set(who.begin(), who.end()).size(), 3u);
}

TEST(Team, RunsEveryPartOnceOfWorksThatFollowEachOtherClosely) {
  // Work so short that the others are still looking for more of the one before.
  for (unsigned threads = 2; threads <= 4; ++threads) {
    Team team(threads, 1);
    std::vector<std::atomic<unsigned>> runs(threads);
    for (unsigned n = 0; n < 60000; ++n) {
      const unsigned parts = 2 + n * 7 % (threads - 1);
      const auto work = [&](unsigned part) { runs[part].fetch_add(1, std::memory_order_relaxed); };
      team.run(parts, work);
      for (unsigned part = 0; part < threads; ++part)
        ASSERT_EQ(runs[part].exchange(0), part < parts ? 1u : 0u) << n << ' ' << part;
    }
  }
}

TEST(Team, EndsRightAfterWork) {
  for (int n = 0; n < 2000; ++n) {
    Team team(2, 1);
    std::atomic<int> runs = 0;
    const auto work = [&](unsigned) { ++runs; };
    for (int k = 0; k <= n % 3; ++k) team.run(2, work);
    ASSERT_EQ(runs, 2 * (1 + n % 3));
  }
}

TEST(Team, GoesOnAfterALongPause) {
  Team team(2, 1);
  std::atomic<int> runs = 0;
  const auto work = [&](unsigned) { ++runs; };
  for (int again = 0; again < 5; ++again) {
    team.run(2, work);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the others fall asleep
  }
  EXPECT_EQ(runs, 10);
}

TEST(Team, TakesPartsThatNobodyHasBegun) {
  Team team(3, 1);
  // Another thread is held up by its part until the caller has done all else.
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> begun = 0;
  const auto work = [&](unsigned) {
    ++begun;
    while (std::this_thread::get_id() != caller && begun < 3) std::this_thread::yield();
  };
  for (int again = 0; again < 20; ++again) {
    begun = 0;
    team.run(3, work);
    EXPECT_EQ(begun, 3);
  }
}

TEST(Team, WaitsForPartsThatTakeLong) {
  Team team(2, 1);
  bool done = false;
  const auto work = [&](unsigned part) {
    if (part == 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    done = true;
  };
  team.run(2, work);
  EXPECT_TRUE(done);
}

TEST(Team, ThrowsWhatTheLowestPartThrewWhenAllHaveEnded) {
  Team team(4, 1);
  for (const unsigned first : {0u, 1u, 2u, 3u}) {
    std::atomic<unsigned> ended = 0;
    const auto work = [&](unsigned part) {
      // The higher parts fail before.
      std::this_thread::sleep_for(std::chrono::milliseconds(4 - part));
      ++ended;
      if (part >= first) throw std::runtime_error("part " + std::to_string(part));
    };
    try {
      team.run(4, work);
      ADD_FAILURE() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "part " + std::to_string(first));
      EXPECT_EQ(ended, 4u);
    }
  }
  std::atomic<unsigned> runs = 0;
  const auto count = [&](unsigned) { ++runs; };
  team.run(4, count);
  EXPECT_EQ(runs, 4u) << "and can be used on";
}

TEST(Team, NotesCallsWhereTheCallerDoes) {
  CallSite site{};
  watched_site = &site;
  Team team(3, 1);
  std::array<CallSite*, 3> seen{};
  const auto look = [&](unsigned part) { seen[part] = watched_site; };
  team.run(3, look);
  watched_site = nullptr;
  for (const CallSite* one : seen) EXPECT_EQ(one, &site);
}

TEST(Team, CutsWorkByWhatIsWorthAThread) {
  const Team team(4, 100);
  EXPECT_EQ(team.parts(0), 1u);
  EXPECT_EQ(team.parts(199), 1u);
  EXPECT_EQ(team.parts(200), 2u);
  EXPECT_EQ(team.parts(399), 3u);
  EXPECT_EQ(team.parts(1'000'000), 4u);
  EXPECT_EQ(Team(0).threads(), 1u);
  EXPECT_EQ(Team(0).parts(1'000'000), 1u);
}

TEST(Team, CutsMuchWorkIntoSeveralPiecesForEachThread) {
  const Team team(3, 100);
  for (const std::uint64_t cells : {0u, 199u, 200u, 300u, 599u})
    EXPECT_EQ(team.pieces(cells), team.parts(cells)) << cells;
  EXPECT_EQ(team.pieces(600), 6u);
  EXPECT_EQ(team.pieces(899), 6u) << "as many for each";
  EXPECT_EQ(team.pieces(100 * team.most_pieces()), team.most_pieces());
  EXPECT_EQ(team.pieces(1'000'000), team.most_pieces());
  EXPECT_GT(team.most_pieces(), 3u);
  EXPECT_EQ(Team(1).pieces(1'000'000), 1u) << "one thread does all in one go";
}

TEST(Team, RunsMorePiecesThanItHasThreadsAndThrowsWhatTheLowestThrew) {
  for (const unsigned threads : {2u, 4u}) {
    Team team(threads, 1);
    std::vector<std::atomic<int>> calls(team.most_pieces());
    const auto fail = [&](unsigned part) {
      ++calls[part];
      if (part >= 2) throw std::runtime_error(std::to_string(part));
    };
    try {
      team.run(team.most_pieces(), fail);
      ADD_FAILURE() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "2");
    }
    for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 1);
  }
}

TEST(Stretches, MakeUpTheWhole) {
  for (const std::uint32_t count : {0u, 1u, 5u, 64u, 4'000'000'000u}) {
    for (const unsigned parts : {1u, 2u, 3u, 7u, 256u}) {
      std::uint32_t next = 0;
      for (unsigned part = 0; part < parts; ++part) {
        const Stretch own = stretch(count, part, parts);
        ASSERT_EQ(own.begin, next);
        ASSERT_LE(own.end - own.begin, count / parts + 1);
        next = own.end;
      }
      ASSERT_EQ(next, count);
    }
  }
}

TEST(Share, StaysWithTheCallerWithoutATeamOrForLittle) {
  Team team(4, 100);
  for (Team* some : {static_cast<Team*>(nullptr), &team}) {
    int calls = 0;
    share(some, 150, [&](std::uint32_t begin, std::uint32_t end) {
      EXPECT_EQ(begin, 0u);
      EXPECT_EQ(end, 150u);
      EXPECT_EQ(++calls, 1);
    });
  }
}

// ---- worlds -------------------------------------------------------------------------------------

/// What happens in a world is told by the hash after every step.
struct Life {
  std::vector<std::uint64_t> hashes;
  std::vector<Outcome> outcomes;
};

Life life_of(const std::function<void(Bench&)>& set_up, unsigned threads, int steps) {
  Bench bench;
  set_up(bench);
  std::optional<Team> team;
  if (threads > 0) team.emplace(threads, 1);  // every cell is worth a thread
  bench.start().use(team ? &*team : nullptr);
  Life life{{bench.simulation().hash()}, {}};
  for (int i = 0; i < steps; ++i) {
    bench.steps(1);
    life.hashes.push_back(bench.simulation().hash());
  }
  life.outcomes = bench.simulation().outcomes();
  return life;
}

void expect_the_same(const std::function<void(Bench&)>& set_up, int steps) {
  const Life alone = life_of(set_up, 0, steps);
  EXPECT_GT(alone.outcomes.front().peak_cells, 20u) << "there is something to share";
  EXPECT_GT(alone.outcomes.front().divisions, 20u);
  EXPECT_GT(alone.outcomes.front().specializations, 5u);
  for (const unsigned threads : {1u, 2u, 3u, 4u, 7u})
    EXPECT_EQ(life_of(set_up, threads, steps).hashes, alone.hashes) << threads << " threads";
}

TEST(WorldThreads, GiveTheSameHashAfterEveryStep) {
  expect_the_same([](Bench& bench) { Busy().set_up(bench); }, 250);
}

TEST(WorldThreads, GiveTheSameOfSeveralOrganisms) {
  expect_the_same(
      [](Bench& bench) {
        Busy().set_up(bench);
        bench.founders = {
            {.key = 5, .x = -2}, {.key = 3, .x = 2}, {.key = 9, .y = 3}, {.key = 4, .y = -2}};
      },
      200);
}

TEST(WorldThreads, GiveTheSameOfStrangersThatAdhereAndFeed) {
  expect_the_same(
      [](Bench& bench) {
        Busy().set_up(bench);
        bench.config.strangers = {.adhere = true, .feed = true};
        bench.founders = {{.key = 5, .x = -1}, {.key = 3, .x = 1}, {.key = 9, .y = 2}};
      },
      200);
}

TEST(WorldThreads, GiveTheSameOfMotileCellsThatShareTheirDeposits) {
  expect_the_same(
      [](Bench& bench) {
        Busy().set_up(bench);
        bench.config.morphogens.deposit = Deposit::share;
        bench.states[0].motility = 0.5;
        bench.states[1].motility = -0.7;
        bench.states[1].motility_signal = 2;
      },
      200);
}

TEST(WorldThreads, GiveTheSameOfTwoResourcesOnScarceSquares) {
  expect_the_same(
      [](Bench& bench) {
        Busy().set_up(bench);
        bench.environments.push_back(resource_grid("sweets", 0.4, 0.05, 3, 20, "tooth"));
        bench.states[0].skills["tooth"] = 2;
        const Script before = bench.script;
        bench.script = [before](const Lane& lane) {
          before(lane);
          lane.out("uptake.sweets", noise(lane.id, lane.step, 7));
        };
      },
      200);
}

/// Notes the threads that step it, and throws for cells of great age.
class Nosy final : public Program {
 public:
  struct Notes {
    std::mutex mutex;
    std::set<std::thread::id> threads;
    std::vector<std::uint32_t> batches;
  };
  Nosy(std::shared_ptr<Notes> notes, float oldest) : notes_(std::move(notes)), oldest_(oldest) {}
  [[nodiscard]] std::uint32_t memory_per_cell() const override { return 2; }
  void start(const Batch& batch) const override { batch.memory.channel(1)[0] = 1; }
  void step(const Batch& batch) const override {
    {
      const std::scoped_lock lock(notes_->mutex);
      notes_->threads.insert(std::this_thread::get_id());
      notes_->batches.push_back(batch.count);
    }
    for (std::uint32_t c = 0; c < batch.out.channels; ++c)
      for (float& value : batch.out.channel(c)) value = 0.25f;
    for (std::uint32_t lane = 0; lane < batch.count; ++lane) {
      float& age = batch.memory.channel(0)[lane];
      age += 1;
      if (age >= oldest_) throw std::runtime_error("the memory is " + std::to_string(age));
    }
  }

 private:
  std::shared_ptr<Notes> notes_;
  float oldest_;
};

class NosyController final : public Controller {
 public:
  NosyController(std::shared_ptr<Nosy::Notes> notes, float oldest)
      : notes_(std::move(notes)), oldest_(oldest) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView, const Layout&) const override {
    return std::make_unique<Nosy>(notes_, oldest_);
  }

 private:
  std::shared_ptr<Nosy::Notes> notes_;
  float oldest_;
  NoGenes genes_;
};

std::vector<Placed> crowd(std::uint64_t count) {
  std::vector<Placed> cells;
  for (std::uint64_t id = 0; id < count; ++id)
    cells.push_back(
        {.id = id, .x = static_cast<double>(id % 10), .y = static_cast<double>(id / 10)});
  return cells;
}

TEST(WorldThreads, CutABatchOfTheController) {
  const auto notes = std::make_shared<Nosy::Notes>();
  Bench bench;
  bench.controller = std::make_shared<NosyController>(notes, 1000.0f);
  Team team(3, 10);
  bench.start_with(crowd(40)).use(&team);
  bench.steps(1);
  std::sort(notes->batches.begin(), notes->batches.end());
  EXPECT_EQ(notes->batches, (std::vector<std::uint32_t>{13, 13, 14}));

  // Too few of them.
  notes->threads.clear();
  notes->batches.clear();
  bench.replace(crowd(19));
  bench.steps(1);
  EXPECT_EQ(notes->threads, std::set{std::this_thread::get_id()});
  EXPECT_EQ(notes->batches, std::vector<std::uint32_t>{19});
}

TEST(WorldThreads, TellTheControllersFailureThatComesFirstInTheOrderOfCells) {
  const auto failure_with = [](unsigned threads) -> std::string {
    Bench bench;
    bench.controller = std::make_shared<NosyController>(std::make_shared<Nosy::Notes>(), 40.0f);
    bench.start_with(crowd(40));
    // The later a cell stands, the more it has in its memory.
    for (std::uint32_t i = 12; i < 40; ++i)
      bench.cells().memory.row(0)[i] = 100.0f + static_cast<float>(i);
    Team team(threads, 1);
    bench.simulation().use(&team);
    try {
      bench.steps(1);
    } catch (const PluginFailure& failure) {
      return failure.what();
    }
    return "no failure";
  };
  const std::string alone = failure_with(1);
  EXPECT_NE(alone.find("controller: step at step 0: the memory is 1"), std::string::npos) << alone;
  for (const unsigned threads : {2u, 3u, 4u, 7u}) EXPECT_EQ(failure_with(threads), alone);
}

TEST(WorldThreads, TellOfABadContentAsOneThreadDoes) {
  const auto failure_with = [](unsigned threads) -> std::string {
    Bench bench;
    auto handles = std::make_shared<Handles>();
    bench.environments = {resource_grid("bread", 1),
                          resource_grid("wine", 1, 0, 2, 64, "thirst", handles)};
    bench.states[0].skills = {{"capacity", 10}, {"production", 1}, {"thirst", 1}};
    bench.script = [](const Lane& lane) {
      lane.out("uptake.bread", 1);
      lane.out("uptake.wine", 1);
    };
    bench.start_with(crowd(40));
    for (double& content : bench.world().grids[handles->grid]) content = -1;
    Team team(threads, 1);
    bench.simulation().use(&team);
    try {
      bench.steps(1);
    } catch (const PluginFailure& failure) {
      return failure.what();
    }
    return "no failure";
  };
  const std::string alone = failure_with(1);
  EXPECT_NE(alone.find("the content of 'wine' is not a number"), std::string::npos) << alone;
  for (const unsigned threads : {2u, 4u}) EXPECT_EQ(failure_with(threads), alone);
}

}  // namespace
}  // namespace somas::model::test
