// somas-host run --profile: what it writes, and that results do not change.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/json.hpp"
#include "tests/core/host/toy_runs.hpp"

namespace somas {
namespace {

using run::Json;
using testing::HasSubstr;
using testing::Not;

class HostProfile : public test::ToyRuns {};

TEST_F(HostProfile, TellsWhereTheTimeOfAllSimulationsWent) {
  ASSERT_EQ(host({"toy.yaml", "--out", "p", "--profile", "--threads", "2"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr(" simulations, "));
  EXPECT_THAT(out_, HasSubstr("\nphases of the step:\n  fields "));
  EXPECT_THAT(out_, HasSubstr("  controller, step "));

  const Json profile = run::parse_json(text("p/profile.json"), "profile.json");
  EXPECT_EQ(profile["format"], "somas-profile/1");
  // What was evaluated before is not simulated again.
  EXPECT_GE(profile["simulations"], 12);
  EXPECT_LE(profile["simulations"], 3 * 12);
  EXPECT_GT(profile["steps"], profile["simulations"]);
  EXPECT_GT(profile["cell_steps"], 0);
  EXPECT_GT(profile["cell_steps_per_second"], 0);
  EXPECT_GT(profile["peak_memory"], 1 << 20);

  // Every part lies within the whole, and what plugins take within the phases.
  const double total = profile["seconds"];
  double phases = 0, plugins = 0;
  std::vector<std::string> names;
  for (const Json& part : profile["phases"]) {
    names.push_back(part["phase"]);
    phases += part["seconds"].get<double>();
    EXPECT_NEAR(part["share"].get<double>() * total, part["seconds"].get<double>(), 1e-9);
  }
  EXPECT_THAT(names,
              testing::ElementsAre("fields", "sense", "control", "decide", "metabolism", "cycle",
                                   "deposit", "mechanics", "stress", "deaths", "observe"));
  std::map<std::string, std::uint64_t> calls;
  for (const Json& part : profile["plugins"]) {
    plugins += part["seconds"].get<double>();
    calls[part["plugin"].get<std::string>() + " " + part["call"].get<std::string>()] =
        part["calls"];
  }
  EXPECT_GT(phases, 0);
  EXPECT_LE(phases, total);
  EXPECT_LE(plugins, phases);
  EXPECT_EQ(calls["fitness observe"], profile["steps"]);
  EXPECT_GE(calls["controller step"], profile["steps"]);
  EXPECT_EQ(calls["field act(stress)"], profile["steps"]);
}

TEST_F(HostProfile, ChangesNoResult) {
  ASSERT_EQ(host({"toy.yaml", "--out", "plain", "--threads", "1"}), 0) << err_;
  ASSERT_EQ(host({"toy.yaml", "--out", "profiled", "--profile", "--quiet"}), 0) << err_;
  EXPECT_THAT(out_, Not(HasSubstr("phases")));
  std::filesystem::remove(path("profiled/profile.json"));
  expect_same("plain", "profiled");
}

TEST_F(HostProfile, IsNotThereUnlessAskedFor) {
  ASSERT_EQ(host({"toy.yaml", "--out", "plain"}), 0) << err_;
  EXPECT_FALSE(std::filesystem::exists(path("plain/profile.json")));
}

TEST_F(HostProfile, LooksAtOneRunOnly) {
  EXPECT_EQ(host({"toy.yaml", "--replicates", "2", "--profile", "--out", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("--profile looks at one run, not at a campaign"));
  EXPECT_FALSE(std::filesystem::exists(path("a")));
}

TEST_F(HostProfile, CannotLookIntoOtherProcesses) {
  EXPECT_EQ(host({"toy.yaml", "--out", "p", "--profile", "--backend", "processes"}), 2);
  EXPECT_THAT(err_, HasSubstr("--backend"));
  EXPECT_FALSE(std::filesystem::exists(path("p")));
}

}  // namespace
}  // namespace somas
