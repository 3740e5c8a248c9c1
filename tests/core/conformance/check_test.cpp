// `somas-host check`: sound plugins pass, and each fixture that breaks one rule fails in that rule,
// with its message and its remedy, and in no other.
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/docs/generated_part.hpp"

namespace somas::conformance {
namespace {

using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const std::string bad = SOMAS_BINARY_DIR "/tests/fixtures/bad/";
const std::string faulty = bad + "faulty/faulty.somas.so";

/// What `somas-host check` said.
struct Checked {
  int exit_code = 0;
  std::string out, err;

  /// Lines of a verdict without it, each with the remedy that follows.
  [[nodiscard]] std::vector<std::string> lines(const std::string& verdict) const {
    std::vector<std::string> found;
    std::istringstream in(out);
    bool open = false;
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("        remedy: ")) {
        if (open) found.back() += line.substr(7);
        continue;
      }
      open = line.starts_with("  " + verdict + "  ");
      if (open) found.push_back(line.substr(8));
    }
    return found;
  }
};

Checked check(const std::string& file, std::vector<std::string> more = {}) {
  const Scratch scratch;
  std::vector<std::string> words = {"check", file};
  words.insert(words.end(), more.begin(), more.end());
  HostProcess process(scratch.path(), words);
  Checked checked;
  checked.exit_code = process.wait();
  checked.out = process.out();
  checked.err = process.err();
  return checked;
}

// ---- rules, one by one -------------------------------------------------------------------------

/// A fixture's fault, and the line that it must be found in: law, message, remedy.
struct Broken {
  std::string plugin, fault, law, text, remedy;
};

void PrintTo(const Broken& broken, std::ostream* out) {
  *out << broken.plugin << " " << broken.fault;
}

const std::string construct = "construct from all that `describe` allows";
const std::string narrow =
    "narrow the range in `describe`, or throw ParameterError for what hangs on several parameters";
const std::string debug =
    "run it in a test of your own (somas/sdk/testing.hpp) in a debugger, or built with "
    "-fsanitize=address";
const std::string leak =
    "see what grows from call to call; for a plugin that needs so much: --memory";
const std::string loop =
    "see which of its loops has no end; for a call that takes longer: --seconds";
const std::string no_exit = "throw an exception; never call exit";
const std::string declare_once =
    "declare from the parameters and Declare::world() alone, each name once; what is thrown ends "
    "the loading of an experiment";
const std::string declare_alike =
    "declare from the parameters and Declare::world() alone, each name once";
const std::string write_finite =
    "write finite numbers, what you declared, in the phases that world.hpp names; what an "
    "environment throws ends a run";
const std::string no_statics =
    "take chance from World::rng alone; no statics, no clock, no addresses";
const std::string in_the_world =
    "keep what changes in grids, tables, scalars and cell values of the World, and no mutable "
    "members, statics or thread_locals";
const std::string threads =
    "begin and act are called from several threads at once: write to the World only";
const std::string any_order =
    "cells are stored in any order: tell them apart by (organism, id), and sum over them in that "
    "order";
const std::string grow_right =
    "emit the root first, parents before children, names and keys once, every number in the range "
    "of specialization.hpp, from the parameters and genes alone";
const std::string fitting = "random and mutate must give genes that check() takes for the layout";
const std::string stream =
    "draw from the Rng that is handed in; no statics, no clock, no addresses, nothing kept from "
    "call to call";
const std::string from_parents =
    "every gene of a child comes from a parent: of equal parents the child is their equal";
const std::string metric = "return 0 for equal genes, and the same number >= 0 both ways";
const std::string exact =
    "write every gene to the last bit (JsonWriter keeps doubles exactly), and read it back";
const std::string leave_fitting = "leave genes alone that fit the layout already";
const std::string refuse =
    "refuse, with std::runtime_error, whatever no operator makes: look at lengths, counts and "
    "ranges before you use them";
const std::string outputs =
    "write every output of every lane, never NaN, and nothing beyond Batch::count lanes and the "
    "rows that there are";
const std::string declare_fitness =
    "declare from the parameters alone; a fitness has no phases and no sensors";
const std::string finite_score =
    "compute a finite number from the Outcome alone, also for an organism that lived no step";
const std::string only_look =
    "look at the world and leave it as it is; remember nothing from call to call";

const std::string lanes_differ = "(layout 0): outputs or memory of a cell differ";
const std::string sensor_differs = "sensor 'faulty_environment' differs in step ";

const std::vector<Broken> environments = {
    {"faulty_environment", "throw_constructor", "constructor", "asked to fail", construct},
    {"faulty_environment", "throw_int_constructor", "constructor",
     "an exception that is no std::exception", construct},
    {"faulty_environment", "segfault_constructor", "constructor",
     "crashes (SIGSEGV) in constructor", debug},
    {"faulty_environment", "throw_limit", "constructor at the limits", "level = 1: asked to fail",
     narrow},
    {"faulty_environment", "segfault_limit", "constructor at the limits",
     "crashes (SIGSEGV) in constructor, with level = 1", debug},
    {"faulty_environment", "throw_declare", "declare and connect", "declare: asked to fail",
     declare_once},
    {"faulty_environment", "sensor_twice", "declare and connect",
     "declare: faulty_environment declares a sensor 'faulty_environment', which is declared "
     "already",
     declare_once},
    {"faulty_environment", "throw_connect", "declare and connect", "connect: asked to fail",
     declare_once},
    {"faulty_environment", "other_declaration", "declare",
     "a second instance declares 'scalar faulty_environment odd 0', not 'grid other_instance grid "
     "2 2 1 0 0 0'",
     declare_alike},
    {"faulty_environment", "throw_begin", "a first simulation", "begin: asked to fail",
     write_finite},
    {"faulty_environment", "throw_fields", "a first simulation",
     "step 0: act(fields): asked to fail", write_finite},
    {"faulty_environment", "throw_int_fields", "a first simulation",
     "step 0: act(fields): an exception that is no std::exception", write_finite},
    {"faulty_environment", "segfault_fields", "a first simulation",
     "crashes (SIGSEGV) in act(fields) at step 0", debug},
    {"faulty_environment", "exit_fields", "a first simulation",
     "ends the process (exit code 7) in act(fields) at step 0", no_exit},
    {"faulty_environment", "endless_fields", "a first simulation",
     "no end within 1 s in act(fields) at step 0", loop},
    {"faulty_environment", "nan_sensor", "a first simulation",
     "step 0: the sensor 'faulty_environment' is no finite number", write_finite},
    {"faulty_environment", "nan_force", "a first simulation",
     "step 0: a force is not a finite number", write_finite},
    {"faulty_environment", "infinite_force", "a first simulation",
     "step 0: a force is not a finite number", write_finite},
    {"faulty_environment", "nan_grid", "a first simulation",
     "after begin the grid 'food' holds nan", write_finite},
    {"faulty_environment", "negative_grid", "a first simulation",
     "after begin the grid 'food' holds -1, yet cells take up from it", write_finite},
    {"faulty_environment", "wrong_phase", "a first simulation",
     "step 0: act(fields): strike belongs in act(stress)", write_finite},
    {"faulty_environment", "foreign_sensor", "a first simulation",
     "step 0: act(sense): no such sensor", write_finite},
    {"faulty_environment", "few_hits", "a first simulation",
     "step 0: act(stress): first_hit: too few places for hits", write_finite},
    {"faulty_environment", "strike_nobody", "a first simulation",
     "step 0: act(stress): strike: no such cell", write_finite},
    {"faulty_environment", "static_counter", "a second instance, the same seed",
     sensor_differs + "0", no_statics},
    {"faulty_environment", "member_counter", "a second simulation of one instance",
     sensor_differs + "0", in_the_world},
    {"faulty_environment", "thread_local_counter", "two instances in turns", sensor_differs + "1",
     in_the_world},
    {"faulty_environment", "member_since_begin", "one instance serving two worlds in turns",
     sensor_differs + "1", in_the_world},
    {"faulty_environment", "other_thread", "one instance on several threads", sensor_differs + "0",
     threads},
    {"faulty_environment", "member_by_world", "saved in mid-life",
     "saved before step 10, restored to a new instance: " + sensor_differs + "10", in_the_world},
    {"faulty_environment", "storage_order", "another storage order of the cells",
     sensor_differs + "0", any_order},
    {"faulty_environment", "sets_forces", "act(forces)",
     "step 0: forces that are in place already are not added to",
     "add to force_x and force_y (+=): others push, too"},
    {"faulty_environment", "throw_step_100", "the host: lives",
     "faulty_environment: act(fields) at step 100: asked to fail",
     "see the call that is named; what it throws ends a run"},
    {"faulty_environment", "late_static_counter", "the host: the same seed twice",
     "the world differs after step 51",
     "see what the checks above say; what changes belongs in the World"},
};

const std::vector<Broken> trees = {
    {"faulty_tree", "throw_constructor", "constructor", "asked to fail", construct},
    {"faulty_tree", "throw_declare", "declare", "asked to fail",
     "copy what you need of the skills; what declare throws ends a run"},
    {"faulty_tree", "throw_grow", "grow", "asked to fail", grow_right},
    {"faulty_tree", "segfault_grow", "grow", "crashes (SIGSEGV) in grow", debug},
    {"faulty_tree", "no_states", "grow", "the tree has no states", grow_right},
    {"faulty_tree", "few_skills", "grow", "state 'root': one value is needed for every skill",
     grow_right},
    {"faulty_tree", "nan_skill", "grow", "state 'root': the skill 'capacity' is out of its range",
     grow_right},
    {"faulty_tree", "nan_mass", "grow", "state 'root': the mass must be positive", grow_right},
    {"faulty_tree", "orphan", "grow", "state 'child': its parent must come before it", grow_right},
    {"faulty_tree", "static_tree", "grow", "equal genes give another tree the second time",
     grow_right},
    {"faulty_chain", "seven_states", "grow after mutations",
     "mutation 26: grow: the parameter 'states': seven are too many",
     "mutate and cross must leave genes that give a tree: undo, or do not do, what would not"},
};

const std::vector<Broken> controllers = {
    {"faulty_controller", "throw_constructor", "constructor", "asked to fail", construct},
    {"faulty_controller", "throw_random", "random and mutate", "(layout 0): random: asked to fail",
     fitting},
    {"faulty_controller", "many_genes", "random and mutate",
     "(layout 0): random genes do not fit: not a byte an output", fitting},
    {"faulty_controller", "throw_mutate", "random and mutate", "(layout 0): mutate: asked to fail",
     fitting},
    {"faulty_controller", "segfault_mutate", "random and mutate", "crashes (SIGSEGV) in mutate",
     debug},
    {"faulty_controller", "keeps_old_genes", "random",
     "(layout 0): old content of the genes makes a difference",
     "clear the genes before you draw new ones"},
    {"faulty_controller", "throw_cross", "cross", "(layout 0): cross: asked to fail", from_parents},
    {"faulty_controller", "child_of_nobody", "cross",
     "(layout 0): the child of a parent with itself is not that parent", from_parents},
    {"faulty_controller", "throw_distance", "distance", "(layout 0): distance: asked to fail",
     metric},
    {"faulty_controller", "far_from_itself", "distance",
     "(layout 0): of genes to themselves is 1, not 0", metric},
    {"faulty_controller", "negative_distance", "distance", "(layout 0): -734 is no distance",
     metric},
    {"faulty_controller", "throw_to_json", "JSON", "(layout 0): to_json: asked to fail", exact},
    {"faulty_controller", "nan_json", "JSON",
     "(layout 0): to_json: JSON: the number 'bad' is not finite", exact},
    {"faulty_controller", "throw_from_json", "JSON", "(layout 0): from_json: asked to fail", exact},
    {"faulty_controller", "loses_a_bit", "JSON",
     "(layout 0): genes read back differ from those written", exact},
    {"faulty_controller", "throw_conform", "conform", "(layout 0): conform: asked to fail",
     leave_fitting},
    {"faulty_controller", "changes_what_fits", "conform",
     "(layout 0): genes that fit already are changed", leave_fitting},
    {"faulty_controller", "static_mutation", "chance from the stream alone",
     "(layout 0): equal streams give other genes the second time", stream},
    {"faulty_controller", "trailing_bytes", "check of damaged genes",
     "(layout 0): two lists of bytes that mean the same genes are both let pass", refuse},
    {"faulty_controller", "logic_error", "check of damaged genes", "(layout 0): lost my place",
     refuse},
    {"faulty_controller", "forgets_ports", "conform to other ports",
     "conform to layout 1 (layout 0): genes that were given more ports and lost them again are "
     "changed",
     "match ports by key, drop those that are gone, draw those that are new from the Rng"},
    {"faulty_controller", "crosses_own_ports", "cross with other ports",
     "cross with layout 0 (layout 1): a parent and itself with fewer ports have another child than "
     "that parent",
     "match ports by key: what only one parent has comes from that one, whole"},
    {"faulty_controller", "throw_express", "step", "(layout 0): express: asked to fail", outputs},
    {"faulty_controller", "no_program", "step", "(layout 0): express returns nothing", outputs},
    {"faulty_controller", "much_memory", "step",
     "(layout 0): the program wants 4000000000 numbers of memory per cell; the host allows 100000",
     outputs},
    {"faulty_controller", "throw_start", "step", "(layout 0): start: asked to fail", outputs},
    {"faulty_controller", "throw_step", "step", "(layout 0): step: asked to fail", outputs},
    {"faulty_controller", "endless_step", "step", "no end within 1 s in step", loop},
    {"faulty_controller", "unwritten_output", "step",
     "(layout 0): the output 'quiescence' is left unwritten", outputs},
    {"faulty_controller", "nan_outputs", "step", "(layout 0): the output 'quiescence' becomes NaN",
     outputs},
    {"faulty_controller", "writes_beyond", "step",
     "(layout 0): writes outside the rows and lanes of its batch", outputs},
    {"faulty_controller", "static_step", "a second run of one program", lanes_differ,
     "keep what changes in Batch::memory: no mutable members, statics or thread_locals"},
    {"faulty_controller", "place_of_lane", "cells in other lanes", lanes_differ,
     "no lane may depend on its place in the batch"},
    {"faulty_controller", "size_of_batch", "a batch split into smaller ones", lanes_differ,
     "no lane may depend on others, nor on how many there are; vector loops need the same "
     "arithmetic for the lanes that are left over"},
    {"faulty_controller", "last_batch", "smaller batches in reverse", lanes_differ,
     "no batch may depend on those before it: carry nothing from call to call"},
    {"faulty_controller", "other_thread", "smaller batches on several threads", lanes_differ,
     "step is called from several threads at once: write to the batch only"},
    {"faulty_controller", "reads_beyond", "other values beyond the lanes", lanes_differ,
     "read Batch::count lanes of a row, and no more"},
    {"faulty_controller", "reads_outputs", "other values in the outputs before a step",
     lanes_differ, "outputs hold anything before a step: write them before you read them"},
    {"faulty_controller", "counts_programs", "express by a second instance", lanes_differ,
     "a program hangs on genes, layout and parameters alone: keep nothing from one express to the "
     "next"},
};

const std::vector<Broken> fitnesses = {
    {"faulty_fitness", "throw_constructor", "constructor", "asked to fail", construct},
    {"faulty_fitness", "throw_declare", "declare", "asked to fail", declare_fitness},
    {"faulty_fitness", "phase", "declare", "a fitness observes: it has no phases and no sensors",
     declare_fitness},
    {"faulty_fitness", "no_objective", "objective", "has no name",
     "return the same name, not empty, every time"},
    {"faulty_fitness", "throw_score", "score", "asked to fail", finite_score},
    {"faulty_fitness", "nan_score", "score", "nan for an organism that lived 0 steps is not finite",
     finite_score},
    {"faulty_fitness", "static_score", "score", "equal outcomes score differently", finite_score},
    {"faulty_fitness", "throw_observe", "observe", "asked to fail", only_look},
    {"faulty_fitness", "meddles", "observe", "changes the world", only_look},
    {"faulty_fitness", "remembers", "observe", "stops another time in an equal world", only_look},
};

/// Those that eat all memory that they can get, which sanitizers cannot be kept from.
const std::vector<Broken> gluttons = {
    {"faulty_environment", "memory_limit", "constructor at the limits",
     "needs more than 256 MiB of memory in constructor, with level = 1", leak},
    {"faulty_environment", "memory_fields", "a first simulation",
     "needs more than 256 MiB of memory in act(fields) at step 0", leak},
};

class Rule : public testing::TestWithParam<Broken> {
 protected:
  static void expect_found() {
    const Broken& broken = GetParam();
    const Checked checked = check(faulty, {"--seconds", "1", "--memory", "256", "--set",
                                           broken.plugin + ".fault=" + broken.fault});
    EXPECT_EQ(checked.exit_code, 3) << checked.out << checked.err;
    EXPECT_THAT(checked.lines("FAIL"),
                ElementsAre(broken.law + ": " + broken.text + " remedy: " + broken.remedy));
    EXPECT_THAT(checked.lines("warn"), IsEmpty());
  }
};

TEST_P(Rule, BrokenAloneIsTheOneThatFails) { expect_found(); }

std::string name_of_test(const testing::TestParamInfo<Broken>& info) {
  return info.param.plugin.substr(7) + "_" + info.param.fault;
}

INSTANTIATE_TEST_SUITE_P(Of, Rule, testing::ValuesIn(environments), name_of_test);
INSTANTIATE_TEST_SUITE_P(OfTrees, Rule, testing::ValuesIn(trees), name_of_test);
INSTANTIATE_TEST_SUITE_P(OfControllers, Rule, testing::ValuesIn(controllers), name_of_test);
INSTANTIATE_TEST_SUITE_P(OfFitness, Rule, testing::ValuesIn(fitnesses), name_of_test);

class Memory : public Rule {};

TEST_P(Memory, WithoutBoundIsTheRuleThatFails) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory without a limit";
#endif
  expect_found();
}

INSTANTIATE_TEST_SUITE_P(Of, Memory, testing::ValuesIn(gluttons), name_of_test);

// ---- files and warnings ------------------------------------------------------------------------

TEST(Check, PassesWhatIsSound) {
  for (const char* file : {"bad/faulty/faulty", "plugins/toy_environment", "plugins/toy_tree",
                           "plugins/toy_fitness", "plugins/toy_controller"}) {
    const Checked checked =
        check(SOMAS_BINARY_DIR "/tests/fixtures/" + std::string(file) + ".somas.so");
    EXPECT_EQ(checked.exit_code, 0) << checked.out << checked.err;
    EXPECT_THAT(checked.lines("FAIL"), IsEmpty());
    EXPECT_THAT(checked.lines("warn"), IsEmpty());
    EXPECT_THAT(checked.lines("skip"), IsEmpty());
  }
}

TEST(Check, LooksAtEveryRuleOfAnEnvironment) {
  const Checked checked =
      check(SOMAS_BINARY_DIR "/tests/fixtures/plugins/toy_environment.somas.so");
  EXPECT_THAT(
      checked.lines("pass"),
      ElementsAre("file", "mathematics", "clock and chance", "loads: somas.test.environment 1.0",
                  "docs: 5 parameters", "constructor", StartsWith("constructor at the limits: "),
                  "declare and connect", "declare", "a first simulation",
                  "a second instance, the same seed", "a second simulation of one instance",
                  "two instances in turns", "one instance serving two worlds in turns",
                  "one instance on several threads", "saved in mid-life",
                  "another storage order of the cells", "act(forces)", "the host: lives",
                  "the host: the same seed twice", "the host: two worlds in turns",
                  "the host: saved and restored", "grids cover the world"));
  EXPECT_THAT(checked.lines("info"), ElementsAre(HasSubstr(" ns a cell and step")));
}

TEST(Check, GoesOnWithTheOtherClassesAfterACrash) {
  const Checked checked = check(faulty, {"--set", "faulty_tree.fault=segfault_constructor"});
  EXPECT_THAT(checked.lines("FAIL"), ElementsAre(HasSubstr("crashes (SIGSEGV) in constructor")));
  EXPECT_THAT(checked.out,
              AllOf(HasSubstr("\nfaulty_environment ("), HasSubstr("\nfaulty_chain ("),
                    HasSubstr("\nfaulty_controller ("), HasSubstr("\nfaulty_fitness ("),
                    HasSubstr("  skip  everything else: needs 'constructor'\n")));
}

TEST(Check, WarnsOfAGridThatDoesNotCoverTheWorld) {
  const Checked checked = check(faulty, {"--set", "faulty_environment.fault=small_grid"});
  EXPECT_EQ(checked.exit_code, 0);
  EXPECT_THAT(checked.lines("warn"),
              ElementsAre("grids cover the world: do not cover a world of radius 60: food remedy: "
                          "cells beyond a grid sense and find nothing there: make it cover "
                          "Declare::world().radius, or say in the doc that this is meant"));
}

TEST(Check, FindsWhatIsUndocumentedAndWarnsOfImportsThatDifferBetweenMachines) {
  const Checked checked = check(bad + "undocumented/undocumented.somas.so");
  EXPECT_EQ(checked.exit_code, 3);
  EXPECT_THAT(checked.lines("FAIL"),
              ElementsAre("docs: no doc: the class itself, rate remedy: say in `about` and "
                          "`describe` what it is for: it is printed and documented"));
  EXPECT_THAT(
      checked.lines("warn"),
      ElementsAre("mathematics: takes from the C library: exp remedy: use somas::math, which gives "
                  "the same bits on every CPU; sqrt, floor and the like are exact",
                  "clock and chance: may call: std::chrono::_V2::system_clock::now() remedy: take "
                  "chance from World::rng or the Rng handed in, and nothing from clocks or the "
                  "process"));
}

TEST(Check, SaysWhyAFileIsRefused) {
  const auto failure_of = [](const std::string& name) {
    const Checked checked = check(bad + name + "/" + name + ".somas.so");
    EXPECT_EQ(checked.exit_code, 3) << name;
    return checked.lines("FAIL");
  };
  EXPECT_THAT(failure_of("text"), ElementsAre("file: not a shared library (it has no ELF header); "
                                              "build it with somas_add_plugin"));
  EXPECT_THAT(failure_of("older_abi"),
              ElementsAre("file: built for interface revision 0, this host needs 1: rebuild it "
                          "with the SDK of this host"));
  EXPECT_THAT(failure_of("fast_math"),
              ElementsAre("loads: changes the floating-point mode of the whole process when loaded "
                          "(built with -ffast-math or -Ofast?); rebuild it without"));
}

TEST(Check, RefusesWhatCannotBeSet) {
  EXPECT_EQ(check("none.somas.so").exit_code, 2);
  const Checked unknown = check(faulty, {"--set", "faulty_tre.fault=none"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("faulty_tre: no class of this file; allowed: "
                                     "faulty_environment, faulty_tree, faulty_chain, "
                                     "faulty_controller, faulty_fitness; did you mean "
                                     "'faulty_tree'?"));
  const Checked range = check(faulty, {"--set", "faulty_tree.level=2"});
  EXPECT_EQ(range.exit_code, 2);
  EXPECT_THAT(range.err, HasSubstr("allowed: 0 to 1"));
}

// ---- the page ----------------------------------------------------------------------------------

std::string words_of(std::string fault) {
  std::replace(fault.begin(), fault.end(), '_', ' ');
  return fault;
}

std::string rows_of(const std::vector<Broken>& broken) {
  std::string rows;
  for (const Broken& one : broken)
    rows += "| " + words_of(one.fault) + " | " + one.law + ": " + one.text + " | " + one.remedy +
            " |\n";
  return rows;
}

std::string table() {
  const std::string head = "\n| the fixture | what the check says | remedy |\n|---|---|---|\n";
  std::vector<Broken> all_environments = environments;
  all_environments.insert(all_environments.end(), gluttons.begin(), gluttons.end());
  return "Environments:\n" + head + rows_of(all_environments) + "\nTrees:\n" + head +
         rows_of(trees) + "\nControllers:\n" + head + rows_of(controllers) + "\nFitness:\n" + head +
         rows_of(fitnesses);
}

TEST(Generated, TableOfBrokenRulesIsUpToDate) {
  test::expect_part(SOMAS_SOURCE_DIR "/docs/checking-plugins.md", "broken rules", table());
}

}  // namespace
}  // namespace somas::conformance
