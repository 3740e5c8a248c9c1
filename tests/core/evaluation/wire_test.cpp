#include "core/evaluation/wire.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace somas::evaluation {
namespace {

TEST(Wire, ATaskArrivesWithItsGenomes) {
  const model::Genome first{{1, 2, 255}, {7}}, second{{}, {}};
  const Task task{.roster = {{.genome = &first, .key = 3, .x = 0.1, .y = -2},
                             {.genome = &second, .key = 9, .x = 1e300, .y = 0}},
                  .seed = ~std::uint64_t{0}};
  Writer out;
  encode(out, task);
  const std::string bytes = out.take();
  Reader in(bytes);
  const OwnedTask arrived = decode_task(in);
  EXPECT_TRUE(in.done());
  EXPECT_EQ(arrived.task.seed, task.seed);
  ASSERT_EQ(arrived.task.roster.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Organism &a = arrived.task.roster[i], &b = task.roster[i];
    EXPECT_TRUE(*a.genome == *b.genome);
    EXPECT_EQ(a.key, b.key);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
  }
}

TEST(Wire, AResultArrivesToTheLastBit) {
  Result result;
  Row row;
  row.score = std::nextafter(0.1, 1);
  row.outcome.survival = 77;
  row.outcome.cell_steps = -0.0;
  row.outcome.biomass_share = std::numeric_limits<double>::denorm_min();
  result.rows = {row, {}};
  result.failure = {.attempts = 2, .cause = "why", .plugin = "field: act", .step = 5};
  Writer out;
  encode(out, result);
  const std::string bytes = out.take();
  Reader in(bytes);
  const Result arrived = decode_result(in);
  ASSERT_EQ(arrived.rows.size(), 2u);
  EXPECT_EQ(arrived.rows[0].score, row.score);
  EXPECT_EQ(arrived.rows[0].outcome.survival, 77u);
  EXPECT_TRUE(std::signbit(arrived.rows[0].outcome.cell_steps));
  EXPECT_EQ(arrived.rows[0].outcome.biomass_share, row.outcome.biomass_share);
  EXPECT_EQ(arrived.failure->attempts, 2u);
  EXPECT_EQ(arrived.failure->cause, "why");
  EXPECT_EQ(arrived.failure->plugin, "field: act");
  EXPECT_EQ(arrived.failure->step, 5u);
}

TEST(Wire, FramesAreTakenWholeHoweverTheyArrive) {
  const std::string sent = framed("first") + framed("") + framed("third");
  std::string arrived, message;
  std::vector<std::string> messages;
  for (const char byte : sent) {
    arrived += byte;
    while (take_frame(arrived, message)) messages.push_back(message);
  }
  EXPECT_EQ(messages, (std::vector<std::string>{"first", "", "third"}));
  EXPECT_TRUE(arrived.empty());
}

TEST(Wire, DamageIsNoticed) {
  Writer out;
  encode(out, Result{});
  const std::string bytes = out.take();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Reader in(std::string_view(bytes).substr(0, size));
    EXPECT_THROW(static_cast<void>(decode_result(in)), WireError) << size;
  }
  std::string huge(8, '\xff'), message;
  EXPECT_THROW(static_cast<void>(take_frame(huge, message)), WireError);
}

}  // namespace
}  // namespace somas::evaluation
