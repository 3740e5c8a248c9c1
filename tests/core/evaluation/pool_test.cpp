#include "core/evaluation/pool.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evaluation/evaluator_process.hpp"
#include "core/evaluation/thread_evaluator.hpp"
#include "tests/core/evaluation/faulty_experiment.hpp"

namespace somas::evaluation {
namespace {

using test::faulty_experiment;
using test::faulty_plugins;
using test::TemporaryFile;
using test::Work;
using testing::AllOf;
using testing::AnyOf;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

PoolOptions options(unsigned workers) {
  PoolOptions options;
  options.workers = workers;
  options.program = SOMAS_BINARY_DIR "/bin/somas-host";
  return options;
}

bool same(const Result& a, const Result& b) {
  if (a.rows.size() != b.rows.size() || a.failure || b.failure) return false;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    const Row &x = a.rows[i], &y = b.rows[i];
    if (x.score != y.score || x.outcome.survival != y.outcome.survival ||
        x.outcome.divisions != y.outcome.divisions ||
        x.outcome.peak_cells != y.outcome.peak_cells ||
        x.outcome.biomass_share != y.outcome.biomass_share ||
        x.outcome.cell_steps != y.outcome.cell_steps)
      return false;
  }
  return true;
}

std::vector<Result> by_threads(const experiment::Experiment& experiment, const Work& work) {
  ThreadEvaluator evaluator(*experiment.ecosystem, 1);
  return evaluator.evaluate(work.tasks(), {}, {}).value();
}

std::vector<Result> by_pool(const experiment::Experiment& experiment, const Work& work,
                            const PoolOptions& with) {
  Pool pool(with);
  return pool.evaluator(experiment)->evaluate(work.tasks(), {}, {}).value();
}

/// Evaluator processes that are children of this one.
std::set<pid_t> evaluators() {
  std::set<pid_t> found;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream in(thread.path() / "children");
    for (pid_t child = 0; in >> child;) {
      std::ifstream words("/proc/" + std::to_string(child) + "/cmdline");
      const std::string line(std::istreambuf_iterator<char>(words), {});
      if (line.find(evaluator_command) != std::string::npos) found.insert(child);
    }
  }
  return found;
}

/// Asks until it is so; false after a minute.
template <class Condition>
bool eventually(const Condition& condition) {
  for (int i = 0; i < 6000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

// ---- results -----------------------------------------------------------------------------------

TEST(Pool, GivesTheResultsOfThreadsForAnyNumberOfWorkers) {
  const experiment::Experiment experiment = faulty_experiment();
  Work work(experiment, 60);
  for (std::size_t i = 0; i < 60; ++i) work.tasks()[i].predicted_cost = static_cast<double>(i % 7);
  const std::vector<Result> expected = by_threads(experiment, work);
  for (const unsigned workers : {1u, 2u, 4u}) {
    const std::vector<Result> results = by_pool(experiment, work, options(workers));
    ASSERT_EQ(results.size(), expected.size());
    for (std::size_t i = 0; i < results.size(); ++i)
      EXPECT_TRUE(same(results[i], expected[i])) << i << " by " << workers;
  }
}

TEST(Pool, HandsOnEachResultOnceByTheCallingThread) {
  const experiment::Experiment experiment = faulty_experiment();
  const Work work(experiment, 40);
  Pool pool(options(2));
  const std::thread::id caller = std::this_thread::get_id();
  std::set<std::size_t> seen;
  const auto results =
      pool.evaluator(experiment)
          ->evaluate(work.tasks(), {}, [&](std::size_t task, const Result& result) {
            EXPECT_EQ(std::this_thread::get_id(), caller);
            EXPECT_THAT(result.rows, SizeIs(1));
            EXPECT_TRUE(seen.insert(task).second) << task;
          });
  EXPECT_TRUE(results);
  EXPECT_THAT(seen, SizeIs(40));
}

TEST(Pool, IsSharedByThreadsEachWithAnExperimentOfItsOwn) {
  const experiment::Experiment one = faulty_experiment(),
                               other = faulty_experiment("fault: none, pause: 0.1");
  const Work work_one(one, 30, 1), work_other(other, 30, 2);
  Pool pool(options(2));
  std::vector<Result> results_one, results_other;
  {
    std::jthread first(
        [&] { results_one = pool.evaluator(one)->evaluate(work_one.tasks(), {}, {}).value(); });
    std::jthread second([&] {
      results_other = pool.evaluator(other)->evaluate(work_other.tasks(), {}, {}).value();
    });
  }
  const std::vector<Result> expected_one = by_threads(one, work_one),
                            expected_other = by_threads(other, work_other);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_TRUE(same(results_one.at(i), expected_one[i])) << i;
    EXPECT_TRUE(same(results_other.at(i), expected_other[i])) << i;
  }
}

TEST(Pool, NoTasksGiveNoResults) {
  const experiment::Experiment experiment = faulty_experiment();
  EXPECT_THAT(by_pool(experiment, Work(experiment, 0), options(1)), IsEmpty());
}

TEST(Pool, AStopRequestEndsItThoughASimulationNeverDoes) {
  const experiment::Experiment experiment = faulty_experiment("fault: loop, cells: 2");
  const Work work(experiment, 20);
  std::atomic<bool> stop{false};
  Pool pool(options(2));
  std::jthread stopper([&] {
    eventually([] { return evaluators().size() == 2; });
    stop = true;
  });
  EXPECT_EQ(pool.evaluator(experiment)->evaluate(work.tasks(), StopToken(stop), {}), std::nullopt);
}

TEST(Pool, WhatTheCallbackThrowsEndsTheWork) {
  const experiment::Experiment experiment = faulty_experiment();
  const Work work(experiment, 20);
  Pool pool(options(2));
  const auto evaluator = pool.evaluator(experiment);
  EXPECT_THROW(
      static_cast<void>(evaluator->evaluate(
          work.tasks(), {}, [](std::size_t, const Result&) { throw std::length_error("full"); })),
      std::length_error);
  // It is as good as new.
  EXPECT_THAT(evaluator->evaluate(work.tasks(), {}, {}).value(), SizeIs(20));
}

// ---- plugins that fail -------------------------------------------------------------------------

struct Fault {
  const char* kind;
  const char* cause;
};

class PluginFault : public testing::TestWithParam<Fault> {};

// The fault comes with the second cell: some genomes divide in time, others never do.
TEST_P(PluginFault, SetsAsideThoseItMeetsAndNoOthers) {
  const experiment::Experiment sound = faulty_experiment();
  const experiment::Experiment experiment =
      faulty_experiment("cells: 2, step: 3, fault: " + std::string(GetParam().kind));
  const Work work(experiment, 16);
  const std::vector<Result> expected = by_threads(sound, Work(sound, 16));
  const std::vector<Result> results = by_pool(experiment, work, options(2));
  std::size_t failed = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].failure.has_value(), expected[i].rows[0].outcome.peak_cells > 1) << i;
    if (!results[i].failure) {
      EXPECT_TRUE(same(results[i], expected[i])) << i;
      continue;
    }
    ++failed;
    EXPECT_EQ(results[i].failure->attempts, 3u);
    EXPECT_EQ(results[i].failure->cause, GetParam().cause);
    EXPECT_EQ(results[i].failure->plugin, "field: act(fields)");
    EXPECT_GE(results[i].failure->step.value(), 3u);
    ASSERT_THAT(results[i].rows, SizeIs(1));
    EXPECT_EQ(results[i].rows[0].outcome.survival, 0u);
  }
  EXPECT_GT(failed, 0u);
  EXPECT_LT(failed, 16u);
}

INSTANTIATE_TEST_SUITE_P(Each, PluginFault,
                         testing::Values(Fault{"throw", "as was asked for"},
                                         Fault{"segfault", "SIGSEGV"}, Fault{"abort", "SIGABRT"},
                                         Fault{"fpe", "SIGFPE"}, Fault{"ill", "SIGILL"},
                                         Fault{"bus", "SIGBUS"}, Fault{"exit", "exit with code 0"},
                                         Fault{"overflow", "SIGSEGV"}),
                         [](const auto& fault) { return std::string(fault.param.kind); });

TEST(Pool, ATaskThatFailsOnceIsTriedAgainInAFreshProcess) {
  for (const char* kind : {"throw", "segfault"}) {
    const TemporaryFile marker;
    std::filesystem::remove(marker.path());
    const experiment::Experiment experiment = faulty_experiment(
        "cells: 2, fault: " + std::string(kind) + ", marker: " + marker.path().string());
    const experiment::Experiment sound = faulty_experiment();
    const std::vector<Result> expected = by_threads(sound, Work(sound, 16));
    const std::vector<Result> results = by_pool(experiment, Work(experiment, 16), options(2));
    EXPECT_TRUE(std::filesystem::exists(marker.path())) << "no fault came";
    for (std::size_t i = 0; i < results.size(); ++i)
      EXPECT_TRUE(same(results[i], expected[i])) << kind << i;
  }
}

TEST(Pool, CrashesInOneExperimentHurtNoOther) {
  for (const char* kind : {"throw", "segfault"}) {
    const experiment::Experiment sound = faulty_experiment(),
                                 faulty =
                                     faulty_experiment("cells: 2, fault: " + std::string(kind));
    const Work good(sound, 40), bad(faulty, 40);
    PoolOptions with = options(1);
    with.warn = [](const std::string& text) { ADD_FAILURE() << text; };
    Pool pool(with);
    std::vector<Result> results, others;
    {
      std::jthread other(
          [&] { others = pool.evaluator(faulty)->evaluate(bad.tasks(), {}, {}).value(); });
      results = pool.evaluator(sound)->evaluate(good.tasks(), {}, {}).value();
    }
    const std::vector<Result> expected = by_threads(sound, good);
    for (std::size_t i = 0; i < results.size(); ++i)
      EXPECT_TRUE(same(results[i], expected[i])) << i;
    EXPECT_TRUE(std::any_of(others.begin(), others.end(),
                            [](const Result& result) { return result.failure.has_value(); }));
  }
}

TEST(Pool, APluginThatAlwaysCrashesIsNamed) {
  const experiment::Experiment experiment = faulty_experiment("fault: segfault, step: 0");
  try {
    by_pool(experiment, Work(experiment, 4), options(2));
    FAIL() << "no exception";
  } catch (const ExperimentFails& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no evaluator can simulate this experiment"),
                                    HasSubstr("field: act(fields): SIGSEGV")));
  }
}

// ---- evaluators that are lost ------------------------------------------------------------------

TEST(Pool, AnEvaluatorThatIsKilledDecidesNothing) {
  const experiment::Experiment experiment = faulty_experiment("fault: none, pause: 1");
  const Work work(experiment, 40);
  const std::vector<Result> expected = by_threads(experiment, work);
  Pool pool(options(2));
  std::atomic<bool> done{false};
  std::atomic<int> kills{0};
  std::jthread killer([&] {
    std::set<pid_t> killed;
    while (!done && kills < 5) {
      for (const pid_t evaluator : evaluators())
        if (killed.insert(evaluator).second && ::kill(evaluator, SIGKILL) == 0) ++kills;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  const auto results = pool.evaluator(experiment)->evaluate(work.tasks(), {}, {});
  done = true;
  killer.join();
  EXPECT_GT(kills, 0);
  ASSERT_TRUE(results);
  for (std::size_t i = 0; i < results->size(); ++i)
    EXPECT_TRUE(same(results->at(i), expected[i])) << i;
}

TEST(Pool, ASimulationThatMakesNoProgressEndsTheEvaluationNotAFitness) {
  const experiment::Experiment experiment = faulty_experiment("fault: loop, cells: 2");
  PoolOptions with = options(2);
  with.watchdog_seconds = 0.2;
  try {
    by_pool(experiment, Work(experiment, 16), with);
    FAIL() << "no exception";
  } catch (const EvaluatorsLost& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("no step of the simulation in 0.2 s in field: act(fields) at step"),
                      HasSubstr("can be resumed")));
  }
}

TEST(Pool, MemoryThatRunsOutEndsTheEvaluationNotAFitness) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory without a limit";
#endif
  const experiment::Experiment experiment = faulty_experiment("fault: memory, cells: 2");
  PoolOptions with = options(1);
  with.memory_mib = 256;
  try {
    by_pool(experiment, Work(experiment, 16), with);
    FAIL() << "no exception";
  } catch (const EvaluatorsLost& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("out of memory"), HasSubstr("can be resumed")));
  }
}

TEST(Pool, AProgramThatIsNoHostIsReported) {
  const experiment::Experiment experiment = faulty_experiment();
  PoolOptions with = options(1);
  with.program = "/bin/false";
  EXPECT_THROW(by_pool(experiment, Work(experiment, 2), with), ExperimentFails);
  with.program = "/nonexistent";
  EXPECT_THROW(by_pool(experiment, Work(experiment, 2), with), EvaluatorsLost);
}

TEST(Pool, AnEvaluatorThatDoesNotReproduceTheReferenceIsRefused) {
  // Each process computes something of its own.
  const experiment::Experiment experiment = faulty_experiment("fault: pid, step: 0, pause: 1");
  PoolOptions with = options(2);
  std::vector<std::string> warnings;
  std::mutex mutex;
  with.warn = [&](const std::string& text) {
    const std::scoped_lock lock(mutex);
    warnings.push_back(text);
  };
  const std::vector<Result> results = by_pool(experiment, Work(experiment, 20), with);
  EXPECT_THAT(results, SizeIs(20));
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("is refused: the reference simulation gives"),
                                 HasSubstr("instead of"), HasSubstr("build")));
}

TEST(Pool, WhoCannotLoadAnExperimentAnyMoreGoesOnWithOthers) {
  namespace fs = std::filesystem;
  const fs::path copy = fs::temp_directory_path() / ("somas-copy-" + std::to_string(::getpid()));
  fs::copy(faulty_plugins, copy);
  const experiment::Experiment vanishing = faulty_experiment({}, copy.string()),
                               lasting = faulty_experiment();
  Pool pool(options(1));
  const auto one = pool.evaluator(vanishing), other = pool.evaluator(lasting);
  EXPECT_TRUE(one->evaluate(Work(vanishing, 2).tasks(), {}, {}));
  fs::remove_all(copy);
  for (const pid_t evaluator : evaluators()) ::kill(evaluator, SIGKILL);
  for (int attempt = 0; attempt < 2; ++attempt) try {
      static_cast<void>(one->evaluate(Work(vanishing, 2).tasks(), {}, {}));
      FAIL() << "no exception";
    } catch (const EvaluatorsLost& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("is refused"), HasSubstr("no such directory"),
                                      HasSubstr("no evaluator is left")));
    }
  EXPECT_TRUE(other->evaluate(Work(lasting, 2).tasks(), {}, {}));
}

TEST(Pool, WhoDoesNotReproduceWhatIsExpectedIsRefused) {
  const experiment::Experiment experiment = faulty_experiment();
  const Work work(experiment, 8);
  Reference reference;
  {
    Pool pool(options(1));
    const auto evaluator = pool.evaluator(experiment);
    EXPECT_EQ(evaluator->reference(), std::nullopt);
    EXPECT_TRUE(evaluator->evaluate(work.tasks(), {}, {}));
    reference = evaluator->reference().value();
  }
  ThreadEvaluator threads(*experiment.ecosystem, 1);
  EXPECT_EQ(threads.reference(), reference);
  threads.expect(reference);

  Pool pool(options(2));
  const auto evaluator = pool.evaluator(experiment), other = pool.evaluator(experiment);
  evaluator->expect(reference);
  EXPECT_TRUE(evaluator->evaluate(work.tasks(), {}, {}));
  reference.hash = "0123456789abcdef";
  other->expect(reference);
  try {
    static_cast<void>(other->evaluate(work.tasks(), {}, {}));
    FAIL() << "no exception";
  } catch (const EvaluatorsLost& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("instead of 0123456789abcdef"), HasSubstr("no evaluator is left")));
  }
  EXPECT_THROW(threads.expect(reference), EvaluatorsLost);
}

// ---- processes ---------------------------------------------------------------------------------

TEST(Pool, ItsProcessesEndWithIt) {
  const experiment::Experiment experiment = faulty_experiment();
  {
    Pool pool(options(3));
    static_cast<void>(pool.evaluator(experiment)->evaluate(Work(experiment, 30).tasks(), {}, {}));
    EXPECT_THAT(evaluators(), SizeIs(3));
  }
  EXPECT_THAT(evaluators(), IsEmpty());
}

TEST(Pool, EvaluatorsSeeAScrubbedEnvironmentAndNoFilesOfOurs) {
  ::setenv("SOMAS_TEST_SECRET", "1", 1);
  std::FILE* ours = std::fopen("/proc/self/status", "r");
  const experiment::Experiment experiment = faulty_experiment();
  Pool pool(options(1));
  static_cast<void>(pool.evaluator(experiment)->evaluate(Work(experiment, 2).tasks(), {}, {}));
  ASSERT_THAT(evaluators(), SizeIs(1));
  const std::string process = "/proc/" + std::to_string(*evaluators().begin());
  std::ifstream in(process + "/environ");
  const std::string environment(std::istreambuf_iterator<char>(in), {});
  EXPECT_THAT(environment, HasSubstr("LC_ALL=C"));
  EXPECT_THAT(environment, testing::Not(HasSubstr("SOMAS_TEST_SECRET")));
  std::set<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(process + "/fd"))
    files.insert(file.path().filename());
  EXPECT_THAT(files, Each(AnyOf("0", "1", "2", "3", "4")));
  std::fclose(ours);
}

double cpu_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(Pool, WaitingBurnsNoProcessor) {
  // Simulations that sleep: whoever is busy meanwhile waits the wrong way.
  const experiment::Experiment experiment = faulty_experiment("fault: none, pause: 10");
  Pool pool(options(2));
  const auto evaluator = pool.evaluator(experiment);
  const Work work(experiment, 4);
  const auto begun = std::chrono::steady_clock::now();
  const double cpu = cpu_seconds();
  static_cast<void>(evaluator->evaluate(work.tasks(), {}, {}));
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begun;
  EXPECT_LT(cpu_seconds() - cpu, 0.2 * passed.count());
}

}  // namespace
}  // namespace somas::evaluation
