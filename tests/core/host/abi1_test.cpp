// A plugin that was built when the interface was frozen at revision 1, and is never built again:
// the host still loads it, runs it to the same results, and finds it sound.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "somas/sdk/types.hpp"

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string folder = SOMAS_SOURCE_DIR "/tests/fixtures/abi1";
const std::string experiment =
    "somas: 1\nname: abi1\nseed: 7\nplugins: [" + folder +
    "]\n"
    "world: {max_steps: 150, max_cells: 40, morphogens: {size: 17}}\n"
    "evolution: {population: 40, generations: 3}\n"
    "environments:\n"
    "  garden: {plugin: abi1_environment, area: {side: 5, content: 6}, stones: 1, start: 10}\n"
    "specialization: {plugin: abi1_tree}\n"
    "controller: {plugin: abi1_controller, squared: true}\n"
    "fitness: {plugin: abi1_fitness}\n";

class Revision1 : public testing::Test {
 protected:
  int host(std::vector<std::string> arguments) {
    HostProcess process(scratch_.path(), std::move(arguments));
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  Scratch scratch_;
  std::string out_, err_;
};

#if defined(__x86_64__)

TEST_F(Revision1, PluginRunsToTheSameResultsAsEver) {
  run::write_file(scratch_.path() / "abi1.yaml", experiment);
  ASSERT_EQ(host({"abi1.yaml", "--out", "run", "--quiet", "--threads", "1"}), 0) << err_;
  ASSERT_EQ(host({"replay", "run", "--csv", "steps.csv"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("reproduced: survival and all 150 step hashes equal"));
  // Every individual's fitness, and the world of every step of a champion that came to 16 cells.
  EXPECT_EQ(stable_key(run::read_file(scratch_.path() / "run/individuals.csv")),
            12943818707418274355u);
  EXPECT_EQ(stable_key(run::read_file(scratch_.path() / "steps.csv")), 12860164725111202996u);
}

TEST_F(Revision1, PluginIsFoundSound) {
  EXPECT_EQ(host({"check", folder + "/abi1.somas.so"}), 0) << out_ << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("abi1_environment ("), HasSubstr("abi1_tree ("),
                          HasSubstr("abi1_controller ("), HasSubstr("abi1_fitness ("),
                          Not(HasSubstr("  warn  ")), HasSubstr(" 0 failed\n")));
}

#else

// The file is for x86-64: elsewhere it can only be refused, and the promise is not tested.
TEST_F(Revision1, PluginIsRefusedOnOtherMachinesThanItsOwn) {
  EXPECT_EQ(host({"check", folder + "/abi1.somas.so"}), 3);
  EXPECT_THAT(out_, HasSubstr("built for another architecture (x86-64)"));
}

#endif

}  // namespace
}  // namespace somas
