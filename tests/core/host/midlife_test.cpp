// Replays that begin in mid-life, from the command line.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/json.hpp"
#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// A run of toys in a/, whose last champion lives some tens of steps.
class MidLife : public testing::Test {
 protected:
  MidLife() {
    write_file(path("toy.yaml"),
               "somas: 1\nname: toy\nseed: 5\n"
               "plugins: [" SOMAS_BINARY_DIR
               "/tests/fixtures/plugins]\n"
               "world: {max_steps: 200, max_cells: 20, morphogens: {size: 9}}\n"
               "evolution: {population: 12, generations: 3}\n"
               "environments:\n"
               "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
               "specialization: {plugin: toy_tree}\n"
               "controller: {plugin: toy_controller}\n"
               "fitness: {plugin: toy_fitness}\n");
    EXPECT_EQ(host({"toy.yaml", "-q", "--out", "a"}), 0) << err_;
    steps_ =
        run::parse_json(read_file(path("a/champions/gen-0002.json")), "champion")["steps"]["count"]
            .get<std::uint64_t>();
    EXPECT_GT(steps_, 15u);
  }
  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  int host(std::vector<std::string> arguments, rlim_t limit = 0) {
    HostProcess process(scratch_.path(), std::move(arguments), limit);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  int replay(std::vector<std::string> arguments, rlim_t limit = 0) {
    arguments.insert(arguments.begin(), {"replay", "a"});
    return host(std::move(arguments), limit);
  }
  std::string rest_text(std::uint64_t step) const {
    return "reproduced: survival and all " + std::to_string(steps_ - step) +
           " step hashes from step " + std::to_string(step) + " equal\n";
  }

  Scratch scratch_;
  std::uint64_t steps_ = 0;
  std::string out_, err_;
};

TEST_F(MidLife, IsReproducedFromAnyStep) {
  for (const std::uint64_t step : {std::uint64_t{0}, std::uint64_t{7}, steps_ - 1}) {
    EXPECT_EQ(replay({"--from-step", std::to_string(step), "--csv", "c.csv"}), 0) << err_;
    EXPECT_THAT(out_, HasSubstr(rest_text(step)));
    EXPECT_THAT(read_file(path("c.csv")),
                StartsWith("step,feeder,shield,cells,hash\n" + std::to_string(step) + ","));
  }
  EXPECT_EQ(replay({"--from-step", std::to_string(steps_)}), 2);
  EXPECT_THAT(
      err_, HasSubstr("is beyond the recorded life, of steps 0 to " + std::to_string(steps_ - 1)));
}

TEST_F(MidLife, GoesOnFromASavedState) {
  EXPECT_EQ(replay({"--save-state", "--at-step", "7"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("state before step 7: a/states/gen-0002-step-000007.state\n"));
  EXPECT_EQ(replay({"--from-step", "9"}), 0) << err_;
  EXPECT_THAT(
      out_, AllOf(HasSubstr("from step 9, with the state of a/states/"), HasSubstr(rest_text(9))));
  EXPECT_EQ(replay({"--from-step", "5"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("from step 5\n"), HasSubstr(rest_text(5))));
  // A state saved by a replay that began in mid-life is the same file.
  EXPECT_EQ(replay({"--from-step", "5", "--save-state", "x.state", "--at-step", "7"}), 0) << err_;
  EXPECT_EQ(read_file(path("x.state")), read_file(path("a/states/gen-0002-step-000007.state")));
  EXPECT_EQ(replay({"--from-state", "x.state"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr(rest_text(7)));
}

TEST_F(MidLife, RefusesAStateOfAnotherLifeOrADamagedOne) {
  ASSERT_EQ(replay({"--save-state", "x.state", "--at-step", "7"}), 0) << err_;
  EXPECT_EQ(replay({"--generation", "1", "--from-state", "x.state"}), 2);
  EXPECT_THAT(err_, HasSubstr("x.state: the state is of another life: generation 2, not 1"));
  std::string bytes = read_file(path("x.state"));
  write_file(path("cut.state"), bytes.substr(0, bytes.size() - 9));
  EXPECT_EQ(replay({"--from-state", "cut.state"}), 2);
  EXPECT_THAT(err_, HasSubstr("cut.state: the saved state is damaged: its checksum is wrong"));
  const std::size_t at = bytes.find("\"step\":7");
  bytes.replace(at, 8, "\"step\":6");
  write_file(path("other.state"), bytes);
  EXPECT_EQ(replay({"--from-state", "other.state"}), 2);
  EXPECT_THAT(err_, HasSubstr("the state is of another life: world before step 6 "));
  write_file(path("text"), "text");
  EXPECT_EQ(replay({"--from-state", "text"}), 2);
  EXPECT_THAT(err_, HasSubstr("text: this is no state file"));
  EXPECT_EQ(replay({"--from-state", "none"}), 2);
}

TEST_F(MidLife, ChangesHoldFromTheStepOn) {
  EXPECT_EQ(replay({"--from-step", "7", "--set", "environments.field.hazard=0"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("from step 7\nrecorded: "), HasSubstr("\nwhat if:  "),
                          HasSubstr("\n  step 7: "), Not(HasSubstr("reproduced"))));
  EXPECT_EQ(replay({"--from-step", "7", "--set", "world.morphogens.size=11"}), 2);
  EXPECT_THAT(err_, HasSubstr("--set: cannot be changed in mid-life: the saved state is of another "
                              "experiment: morphogens: "));
  EXPECT_EQ(replay({"--from-step", "7", "--set", "world.morphogens.kinds=[]"}), 2);
  EXPECT_THAT(err_, HasSubstr("the genome would not fit"));
  EXPECT_EQ(replay({"--from-step", "7", "--set", "world.max_steps=6"}), 2);
  EXPECT_THAT(err_, HasSubstr("before step 7, but the world ends after 6 steps"));
}

TEST_F(MidLife, AWoundIsAWhatIf) {
  EXPECT_EQ(replay({"--from-step", "7", "--wound", "500,0,1"}), 0) << err_;
  EXPECT_THAT(out_,
              AllOf(HasSubstr("from step 7; wound: 0 cells removed\n"), HasSubstr("what if")));
  EXPECT_EQ(replay({"--from-step", "7", "--wound", "0,0,1000"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("what if:  survival 7, "));
  EXPECT_EQ(replay({"--wound", "0,0,1"}), 2);
  EXPECT_THAT(err_, HasSubstr("--wound needs --from-step or --from-state"));
  for (const char* wound : {"1,2", "1,2,0", "1,2,-3", "1,2,x", "1,2,3,4", "nan,0,1", ""}) {
    EXPECT_EQ(replay({"--from-step", "7", "--wound", wound}), 2) << wound;
    if (*wound != '\0') {
      EXPECT_THAT(err_, HasSubstr("is not X,Y,RADIUS"));
    }
  }
}

TEST_F(MidLife, OptionsThatDoNotGoTogetherSaySo) {
  const auto refused = [&](const std::vector<std::string>& arguments, const char* why) {
    EXPECT_EQ(replay(arguments), 2);
    EXPECT_THAT(err_, HasSubstr(why));
  };
  refused({"--from-step", "1", "--from-state", "x"}, "give one of them");
  refused({"--save-state"}, "--save-state needs --at-step");
  refused({"--at-step", "3"}, "--at-step belongs to --save-state");
  refused({"--save-state", "--at-step", "3", "--set", "world.max_steps=9"}, "without --set");
  refused({"--save-state", "--at-step", "9999"}, "has states before steps 1 to ");
  refused({"--from-step", "7", "--save-state", "--at-step", "7"}, "is not after step 7");
  refused({"--save-state", "a/summary.json", "--at-step", "7"}, "belongs to the run");
  refused({"--save-state", "x", "--at-step", "7", "--csv", "./x"},
          "--save-state name the same file: ");
}

TEST_F(MidLife, OfAnotherLifeThanTheRecordIsReplayedWhole) {
  run::Json champion = run::parse_json(read_file(path("a/champions/gen-0002.json")), "champion");
  champion["steps"]["world_hash"][6] = "0000000000000000";
  write_file(path("a/champions/gen-0002.json"), run::to_text(champion));
  EXPECT_EQ(replay({"--from-step", "7"}), 4);
  EXPECT_THAT(out_, HasSubstr("first differing step 6: recorded hash 0000000000000000"));
  EXPECT_THAT(err_, HasSubstr("the life up to the step asked for is not the recorded one"));
  EXPECT_EQ(replay({"--save-state", "--at-step", "7"}), 4);
  EXPECT_THAT(err_, HasSubstr("no state is saved"));
  EXPECT_FALSE(fs::exists(path("a/states")));
}

TEST_F(MidLife, AStateThatCannotBeWrittenLeavesNoHalfFile) {
  EXPECT_EQ(replay({"--save-state", "none/x.state", "--at-step", "7"}), 5);
  EXPECT_THAT(err_, HasSubstr("cannot write none/x.state"));
  EXPECT_THAT(out_, IsEmpty());
  // Room for the report, but not for the state.
  EXPECT_EQ(replay({"--save-state", "--at-step", "7"}, 2500), 5);
  EXPECT_THAT(err_, HasSubstr("cannot write "));
  EXPECT_THAT(Scratch::names_in(path("a/states")), IsEmpty());
  write_file(path("x.state"), "before");
  EXPECT_EQ(replay({"--save-state", "x.state", "--at-step", "7"}, 2500), 5);
  EXPECT_EQ(read_file(path("x.state")), "before");
}

}  // namespace
}  // namespace somas
