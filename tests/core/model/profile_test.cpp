// Where the time of a simulation goes, and that measuring it changes nothing.
#include "core/model/profile.hpp"

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

using std::chrono::nanoseconds;

TEST(Profile, AddsUpPhasesAndCalls) {
  Profile one, all;
  one.add_phase(StepPhase::mechanics, nanoseconds(5));
  one.add_phase(StepPhase::mechanics, nanoseconds(2));
  one.add_phase(StepPhase::sense, nanoseconds(1));
  one.add_call("food", "act(sense)", nanoseconds(1));
  one.add_life(nanoseconds(10), 3, 12);
  all.add_call("food", "act(fields)", nanoseconds(4));
  all.add(one);
  all.add(one);
  EXPECT_EQ(all.phase(StepPhase::mechanics), nanoseconds(14));
  EXPECT_EQ(all.phase(StepPhase::sense), nanoseconds(2));
  EXPECT_EQ(all.phase(StepPhase::stress), nanoseconds(0));
  EXPECT_EQ(all.total(), nanoseconds(20));
  EXPECT_EQ(all.lives(), 2u);
  EXPECT_EQ(all.steps(), 6u);
  EXPECT_EQ(all.cell_steps(), 24);
  ASSERT_EQ(all.calls().size(), 2u);
  EXPECT_EQ(all.calls()[0].call, "act(fields)");
  EXPECT_EQ(all.calls()[1].plugin, "food");
  EXPECT_EQ(all.calls()[1].time, nanoseconds(2));
  EXPECT_EQ(all.calls()[1].calls, 2u);
}

TEST(Profile, NamesEveryPhase) {
  for (std::size_t p = 0; p < step_phases; ++p)
    EXPECT_FALSE(name_of(static_cast<StepPhase>(p)).empty());
  EXPECT_EQ(name_of(StepPhase::fields), "fields");
  EXPECT_EQ(name_of(StepPhase::observe), "observe");
}

TEST(Stopwatch, OfNoProfileRecordsNothing) {
  int records = 0;
  {
    const Stopwatch watch(nullptr, [&](Profile&, Profile::Duration) { ++records; });
  }
  EXPECT_EQ(records, 0);
  Profile profile;
  {
    const Stopwatch watch(&profile, [&](Profile&, Profile::Duration) { ++records; });
  }
  EXPECT_EQ(records, 1);
}

}  // namespace
}  // namespace somas::model::test
