// Work that plugins share with the threads of a world.
#include "somas/sdk/workers.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/model/team.hpp"
#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

using Part = std::pair<std::uint32_t, std::uint32_t>;

/// A world of one cell in which `act` acts once, with so many threads (0: no team at all).
void act_once(unsigned threads, std::uint32_t least_cells, std::function<void(World&)> act) {
  Bench bench;
  bench.environments = {acting("toy", Phase::stress, std::move(act))};
  std::optional<Team> team;
  if (threads > 0) team.emplace(threads, least_cells);
  bench.start().use(team ? &*team : nullptr);
  bench.steps(1);
}

/// The parts that work of so many items is cut into, in order.
std::vector<Part> parts_of(unsigned threads, std::uint32_t least_cells, std::uint32_t count,
                           std::uint32_t least) {
  std::mutex mutex;
  std::set<Part> parts;
  act_once(threads, least_cells, [&](World& world) {
    share_work(world, count, least, [&](std::uint32_t begin, std::uint32_t end) {
      const std::scoped_lock lock(mutex);
      EXPECT_TRUE(parts.emplace(begin, end).second) << "once";
    });
  });
  return {parts.begin(), parts.end()};
}

TEST(Workers, DoEveryItemOnce) {
  for (const unsigned threads : {0u, 1u, 2u, 3u, 7u}) {
    for (const std::uint32_t count : {0u, 1u, 2u, 100u}) {
      std::uint32_t done = 0;
      for (const auto& [begin, end] : parts_of(threads, 1, count, 1)) {
        EXPECT_EQ(begin, done);
        EXPECT_LT(begin, end) << "no part is empty";
        done = end;
      }
      EXPECT_EQ(done, count);
    }
  }
}

TEST(Workers, GetAsManyItemsAsAreWorthAThread) {
  using Parts = std::vector<Part>;
  constexpr std::uint32_t shipped = cells_worth_a_thread;
  EXPECT_EQ(parts_of(2, shipped, 100, 50), (Parts{{0, 50}, {50, 100}}));
  EXPECT_EQ(parts_of(2, shipped, 99, 50), (Parts{{0, 99}}));
  EXPECT_EQ(parts_of(2, shipped, 199, 50), (Parts{{0, 99}, {99, 199}}));
  EXPECT_EQ(parts_of(2, shipped, 200, 50).size(), 4u) << "so that a slower one takes fewer";
  EXPECT_EQ(parts_of(2, shipped, 299, 50).size(), 4u) << "as many for each";
  EXPECT_EQ(parts_of(2, shipped, 100'000, 50).size(), Team(2).most_pieces());
  EXPECT_EQ(parts_of(4, shipped, 170, 50).size(), 3u);
  EXPECT_EQ(parts_of(4, shipped, 10, 0).size(), 8u) << "none at all counts as one";
  EXPECT_EQ(parts_of(0, shipped, 1000, 1), (Parts{{0, 1000}}));
  EXPECT_EQ(parts_of(2, shipped, 3'000'000'000u, 1'000'000'000u),
            (Parts{{0, 1'500'000'000u}, {1'500'000'000u, 3'000'000'000u}}));
}

TEST(Workers, AreAsManyAsTheWorldHasThreads) {
  for (const unsigned threads : {0u, 1u, 2u, 5u}) {
    std::uint32_t told = 99;
    act_once(threads, 1, [&](World& world) { told = threads_of(world); });
    EXPECT_EQ(told, std::max(threads, 1u));
  }
}

TEST(Workers, WorkAtOnce) {
  // Two parts that each wait for the other.
  std::mutex mutex;
  std::condition_variable both;
  std::set<std::thread::id> threads;
  act_once(2, 1, [&](World& world) {
    share_work(world, 2, 1, [&](std::uint32_t, std::uint32_t) {
      std::unique_lock lock(mutex);
      threads.insert(std::this_thread::get_id());
      both.notify_all();
      EXPECT_TRUE(
          both.wait_for(lock, std::chrono::minutes(1), [&] { return threads.size() == 2; }));
    });
  });
  EXPECT_EQ(threads.size(), 2u);
}

TEST(Workers, ThrowWhatTheLowestPartThrew) {
  for (const unsigned threads : {0u, 1u, 3u}) {
    try {
      act_once(threads, 1, [](World& world) {
        share_work(world, 30, 1, [](std::uint32_t begin, std::uint32_t) {
          throw std::runtime_error("from item " + std::to_string(begin));
        });
      });
      FAIL() << "nothing thrown";
    } catch (const PluginFailure& failure) {
      EXPECT_STREQ(failure.what(), "toy: act(stress) at step 0: from item 0");
    }
  }
}

TEST(Workers, AreNotThereWhereAHostKnowsNone) {
  // Of a host older than they are: everything is done by the thread of the call.
  class Old final : public Extensible {
  } old;
  EXPECT_EQ(extension_of<Workers>(old), nullptr);
  std::optional<std::string> wrong;
  act_once(1, 1, [&](World& world) {
    if (world.extension("somas.workers/2") != nullptr) wrong = "another version";
    if (world.extension("") != nullptr) wrong = "no name";
  });
  EXPECT_EQ(wrong, std::nullopt);
}

}  // namespace
}  // namespace somas::model::test
