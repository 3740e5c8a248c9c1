// Plugins that fail while an experiment is loaded or run: each ends it with a message that names
// the part of the experiment, the call and the fault; nothing crashes.
#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/docs/generated_part.hpp"

namespace somas {
namespace {

using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string experiment_text =
    "somas: 1\n"
    "name: bad\n"
    "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " SOMAS_BINARY_DIR
    "/tests/fixtures/bad/faulty]\n"
    "world: {max_steps: 30, max_cells: 20, morphogens: {size: 9}}\n"
    "evolution: {population: 6, generations: 2}\n"
    "environments:\n"
    "  weather: {plugin: faulty_environment}\n"
    "specialization: {plugin: faulty_tree}\n"
    "controller: {plugin: faulty_controller}\n"
    "fitness: {plugin: faulty_fitness}\n";

struct Fault {
  std::string block, fault;
  int exit_code;
  std::string message;  // part of it
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.block << " " << fault.fault; }

class Running : public testing::Test {
 protected:
  Running() { run::write_file(scratch_.path() / "bad.yaml", experiment_text); }
  int run(const std::string& setting) {
    HostProcess process(scratch_.path(), {"bad.yaml", "--out", "run", "--quiet", "--threads", "1",
                                          "--set", setting});
    const int code = process.wait();
    err_ = process.err();
    return code;
  }
  Scratch scratch_;
  std::string err_;
};

class BadPlugin : public Running, public testing::WithParamInterface<Fault> {};

TEST_P(BadPlugin, EndsTheRunWithItsPartCallAndFault) {
  const Fault& fault = GetParam();
  EXPECT_EQ(run(fault.block + ".fault=" + fault.fault), fault.exit_code) << err_;
  EXPECT_THAT(err_, AllOf(StartsWith("somas-host: "), HasSubstr(fault.message)));
}

// While the experiment is loaded: the message begins with file, line and column of the block.
const std::string environment = "environments.weather", loading = ": environments.weather: ";

const std::vector<Fault> faults_while_loading = {
    Fault{environment, "throw_constructor", 2,
          "bad.yaml:7:3" + loading +
              "the plugin 'faulty_environment' cannot be created: asked to fail"},
    Fault{environment, "throw_int_constructor", 2,
          "bad.yaml:7:3" + loading +
              "the plugin 'faulty_environment' cannot be created: it threw something that is no "
              "std::exception"},
    Fault{environment, "throw_declare", 2,
          "bad.yaml:7:3" + loading + "weather: declare: asked to fail"},
    Fault{environment, "throw_int_declare", 2,
          "weather: declare: an exception that is no std::exception"},
    Fault{environment, "throw_connect", 2, loading + "weather: connect: asked to fail"},
    Fault{environment, "sensor_twice", 2,
          loading +
              "weather: declare: weather declares a sensor 'weather', which is declared already"},
    Fault{environment, "vary_nothing", 2,
          loading + "weather: connect: no environment has a variable parameter 'nobody.nothing'"},
    Fault{
        "specialization", "throw_constructor", 2,
        "bad.yaml:8:1: specialization: the plugin 'faulty_tree' cannot be created: asked to fail"},
    Fault{"specialization", "throw_declare", 2, "specialization: declare: asked to fail"},
    Fault{"specialization", "throw_grow", 2, "specialization: grow: asked to fail"},
    Fault{"specialization", "no_states", 2, "specialization: grow: the tree has no states"},
    Fault{"specialization", "few_skills", 2,
          "specialization: grow: state 'root': one value is needed for every skill"},
    Fault{"specialization", "nan_skill", 2,
          "specialization: grow: state 'root': a skill is out of its range"},
    Fault{"specialization", "nan_mass", 2,
          "specialization: grow: state 'root': mass and radius must be positive"},
    Fault{"specialization", "orphan", 2,
          "specialization: grow: state 'child': its parent must come before it"},
    Fault{"controller", "throw_constructor", 2,
          "controller: the plugin 'faulty_controller' cannot be created: asked to fail"},
    Fault{"fitness", "throw_constructor", 2,
          "fitness: the plugin 'faulty_fitness' cannot be created: asked to fail"},
    Fault{"fitness", "throw_declare", 2, "fitness: declare: asked to fail"},
    Fault{"fitness", "phase", 2,
          "fitness: declare: a fitness observes: it has no phases and no sensors"}};

INSTANTIATE_TEST_SUITE_P(WhileLoading, BadPlugin, testing::ValuesIn(faults_while_loading),
                         [](const auto& one) {
                           return (one.param.block == environment ? "environment"
                                                                  : one.param.block) +
                                  "_" + one.param.fault;
                         });

const std::vector<Fault> faults_while_running = {
    Fault{environment, "throw_begin", 3, "weather: begin at step 0: asked to fail"},
    Fault{environment, "throw_fields", 3, "weather: act(fields) at step 0: asked to fail"},
    Fault{environment, "throw_int_fields", 3,
          "weather: act(fields) at step 0: an exception that is no std::exception"},
    Fault{environment, "throw_parameters", 3, "weather: act(parameters) at step 0: asked to fail"},
    Fault{environment, "throw_sense", 3, "weather: act(sense) at step 0: asked to fail"},
    Fault{environment, "throw_forces", 3, "weather: act(forces) at step 0: asked to fail"},
    Fault{environment, "throw_stress", 3, "weather: act(stress) at step 0: asked to fail"},
    Fault{environment, "nan_sensor", 3,
          "weather: act(sense) at step 0: the sensor 'weather' of cell 0 is NaN, not a finite "
          "number"},
    Fault{environment, "nan_force", 3,
          "weather: act(forces) at step 0: the force on cell 0 is NaN, not a finite number"},
    Fault{environment, "infinite_force", 3,
          "weather: act(forces) at step 0: the force on cell 0 is infinity, not a finite "
          "number"},
    Fault{environment, "nan_grid", 3,
          "weather: step 2: the content of 'weather' is not a number >= 0"},
    Fault{environment, "negative_grid", 3,
          "weather: step 2: the content of 'weather' is not a number >= 0"},
    Fault{environment, "wrong_phase", 3,
          "weather: act(fields) at step 0: strike belongs in act(stress)"},
    Fault{environment, "foreign_sensor", 3, "weather: act(sense) at step 0: no such sensor"},
    Fault{environment, "few_hits", 3,
          "weather: act(stress) at step 0: first_hit: too few places for hits"},
    Fault{environment, "strike_nobody", 3, "weather: act(stress) at step 0: strike: no such cell"},
    Fault{"controller", "throw_random", 3, "controller: random: asked to fail"},
    Fault{"controller", "throw_mutate", 3, "controller: mutate: asked to fail"},
    Fault{"controller", "throw_cross", 3, "controller: cross: asked to fail"},
    Fault{"controller", "throw_int_cross", 3,
          "controller: cross: an exception that is no std::exception"},
    Fault{"controller", "throw_express", 3, "controller: express: asked to fail"},
    Fault{"controller", "no_program", 3, "controller: express: it returned no program"},
    Fault{"controller", "much_memory", 3,
          "controller: express: its program wants 4000000000 numbers of memory per cell; at "
          "most 100000 are allowed"},
    Fault{"controller", "throw_start", 3, "controller: step at step 0: asked to fail"},
    Fault{"controller", "throw_step", 3, "controller: step at step 0: asked to fail"},
    Fault{"controller", "throw_to_json", 3, "plugin 'faulty_controller': to_json: asked to fail"},
    Fault{"controller", "nan_json", 3,
          "plugin 'faulty_controller': to_json: JSON writer: bad is not finite"},
    Fault{"fitness", "throw_observe", 3, "fitness: observe at step 0: asked to fail"},
    Fault{"fitness", "throw_score", 3, "fitness: score: asked to fail"},
    Fault{"fitness", "nan_score", 3, "fitness: score: \"faults\" is not a number"}};

INSTANTIATE_TEST_SUITE_P(WhileRunning, BadPlugin, testing::ValuesIn(faults_while_running),
                         [](const auto& one) {
                           return (one.param.block == environment ? "environment"
                                                                  : one.param.block) +
                                  "_" + one.param.fault;
                         });

// ---- with a genome that was saved
// ----------------------------------------------------------------

class BadReader : public Running {
 protected:
  BadReader() { EXPECT_EQ(run("seed=1"), 0) << err_; }
  int run_on(const std::string& fault) {
    HostProcess process(scratch_.path(),
                        {"bad.yaml", "--out", fault, "--quiet", "--threads", "1", "--genome",
                         "run/champions/gen-0001.json", "--set", "controller.fault=" + fault});
    const int code = process.wait();
    err_ = process.err();
    return code;
  }
};

TEST_F(BadReader, IsNamedWithFilePartAndCall) {
  EXPECT_EQ(run_on("none"), 0) << err_;
  EXPECT_EQ(run_on("throw_from_json"), 2);
  EXPECT_THAT(err_, HasSubstr("run/champions/gen-0001.json.genome.controller.genes: controller: "
                              "from_json: asked to fail"));
  EXPECT_EQ(run_on("throw_int_from_json"), 2);
  EXPECT_THAT(err_, HasSubstr("controller: from_json: an exception that is no std::exception"));
  EXPECT_EQ(run_on("throw_conform"), 3);
  EXPECT_THAT(err_, HasSubstr("controller: conform: asked to fail"));
}

// ---- what ends a process
// -------------------------------------------------------------------------

TEST_F(Running, NamesAPluginThatCrashesWhileItIsLoaded) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers report crashes themselves";
#endif
  EXPECT_EQ(run("environments.weather.fault=segfault_constructor"), 3);
  EXPECT_THAT(err_, HasSubstr("SIGSEGV in weather: constructor: the plugin crashed"));
  EXPECT_EQ(run("specialization.fault=segfault_grow"), 3);
  EXPECT_THAT(err_, HasSubstr("SIGSEGV in specialization: grow: the plugin crashed"));
}

/// A run by evaluator processes, in which the fault comes with a cell's first division.
class BadRun : public testing::Test {
 protected:
  int run(const std::string& fault, std::vector<std::string> options) {
    run::write_file(scratch_.path() / "e.yaml",
                    "somas: 1\nname: e\nseed: 5\n"
                    "plugins: [" SOMAS_BINARY_DIR "/tests/fixtures/plugins, " SOMAS_BINARY_DIR
                    "/tests/fixtures/faulty]\n"
                    "world: {max_steps: 100, max_cells: 20, morphogens: {size: 9}}\n"
                    "evolution: {population: 8, generations: 2}\n"
                    "environments: {weather: {plugin: faulty_environment, cells: 2, fault: " +
                        fault +
                        "}}\nspecialization: {plugin: toy_tree}\n"
                        "controller: {plugin: toy_controller}\nfitness: {plugin: toy_fitness}\n");
    options.insert(options.begin(), {"e.yaml", "--out", "run", "--quiet", "--workers", "1"});
    HostProcess process(scratch_.path(), options);
    const int code = process.wait();
    err_ = process.err();
    return code;
  }
  Scratch scratch_;
  std::string err_;
};

TEST_F(BadRun, OfAStepThatNeverEndsStopsAndCanBeResumed) {
  EXPECT_EQ(run("loop", {"--watchdog", "1"}), 6);
  EXPECT_THAT(err_, AllOf(HasSubstr("no step of the simulation in 1 s in weather: act(fields) at "
                                    "step"),
                          HasSubstr("can be resumed")));
}

TEST_F(BadRun, OfMemoryWithoutBoundStopsAndCanBeResumed) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory without a limit";
#endif
  EXPECT_EQ(run("memory", {"--evaluator-memory", "256"}), 6);
  EXPECT_THAT(err_, AllOf(HasSubstr("out of memory in weather: act(fields) at step"),
                          HasSubstr("can be resumed")));
}

TEST_F(Running, WarnsOfAGridThatDoesNotCoverTheWorld) {
  EXPECT_EQ(run("environments.weather.fault=small_grid"), 0);
  EXPECT_THAT(err_, HasSubstr("environments.weather: its grid 'food' does not cover the world"));
}

// ---- what is no fault
// ----------------------------------------------------------------------------

class SoundPlugin : public BadPlugin {};

// What a controller writes out of range is clamped, NaN counts as nothing: the contract of Batch.
TEST_P(SoundPlugin, Runs) {
  EXPECT_EQ(run(GetParam().block + ".fault=" + GetParam().fault), 0) << err_;
}

INSTANTIATE_TEST_SUITE_P(Each, SoundPlugin,
                         testing::Values(Fault{"fitness", "none", 0, ""},
                                         Fault{"controller", "nan_outputs", 0, ""},
                                         Fault{"controller", "huge_outputs", 0, ""}),
                         [](const auto& one) { return one.param.fault; });

// ---- the page
// ------------------------------------------------------------------------------------

std::string rows_of(const std::vector<Fault>& faults) {
  std::string rows;
  for (const Fault& fault : faults) {
    std::string what = fault.fault;
    std::replace(what.begin(), what.end(), '_', ' ');
    std::string_view message = fault.message;
    while (message.starts_with(':') || message.starts_with(' ')) message.remove_prefix(1);
    const std::string kind = fault.block == environment ? "environment" : fault.block;
    rows += "| " + kind + ": " + what + " | " + std::to_string(fault.exit_code) + " | " +
            std::string(message) + " |\n";
  }
  return rows;
}

TEST(Generated, TableOfFaultsInRunsIsUpToDate) {
  test::expect_part(SOMAS_SOURCE_DIR "/docs/checking-plugins.md", "faults in runs",
                    "| the fault | exit code | the message says |\n|---|---|---|\n" +
                        rows_of(faults_while_loading) + rows_of(faults_while_running));
}

}  // namespace
}  // namespace somas
