#include "core/evaluation/thread_evaluator.hpp"

#include <atomic>
#include <chrono>
#include <map>
#include <set>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/simulate.hpp"
#include "tests/core/evaluation/toy_ecosystem.hpp"

namespace somas::evaluation {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Evaluation : public testing::Test {
 protected:
  Evaluation() { make(60); }

  void make(std::size_t count) {
    genomes_.clear();
    tasks_.clear();
    for (std::size_t i = 0; i < count; ++i) genomes_.push_back(test::toy_genome(*ecosystem_, i));
    for (const model::Genome& genome : genomes_)
      tasks_.push_back({.roster = {{.genome = &genome}}, .seed = 5});
  }

  std::vector<Result> evaluate(unsigned threads) {
    ThreadEvaluator evaluator(*ecosystem_, threads);
    return evaluator.evaluate(tasks_, {}, {}).value();
  }

  std::shared_ptr<const model::Ecosystem> ecosystem_ = test::toy_ecosystem();
  std::vector<model::Genome> genomes_;
  std::vector<Task> tasks_;
};

bool same(const Result& a, const Result& b) {
  if (a.rows.size() != b.rows.size()) return false;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    const Row &x = a.rows[i], &y = b.rows[i];
    if (x.score != y.score || x.outcome.survival != y.outcome.survival ||
        x.outcome.divisions != y.outcome.divisions ||
        x.outcome.peak_cells != y.outcome.peak_cells ||
        x.outcome.cell_steps != y.outcome.cell_steps)
      return false;
  }
  return true;
}

TEST_F(Evaluation, ReferenceSimulationsThatFailAreNotTriedAgain) {
  const auto failing = test::toy_ecosystem({.failing_step = 0});
  ThreadEvaluator evaluator(*failing, 1);
  const int before = test::Reaper::failures;
  EXPECT_EQ(evaluator.reference(), std::nullopt);
  EXPECT_EQ(test::Reaper::failures - before, 8);
  EXPECT_EQ(evaluator.reference(), std::nullopt);
  EXPECT_EQ(test::Reaper::failures - before, 8);
}

TEST_F(Evaluation, ResultsDoNotDependOnTheNumberOfThreads) {
  const std::vector<Result> one = evaluate(1);
  ASSERT_THAT(one, SizeIs(60));
  for (const unsigned threads : {2u, 5u}) {
    const std::vector<Result> many = evaluate(threads);
    ASSERT_EQ(one.size(), many.size());
    for (std::size_t i = 0; i < one.size(); ++i) EXPECT_TRUE(same(one[i], many[i])) << i;
  }
}

TEST_F(Evaluation, OfSeveralExperimentsSharesTheThreadsOfOneBackend) {
  experiment::Experiment experiment;
  experiment.ecosystem = ecosystem_;
  const auto backend = thread_backend(1);
  const auto begun = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> runs;
    for (int i = 0; i < 4; ++i)
      runs.emplace_back([&] {
        const auto evaluator = backend->evaluator(experiment);
        EXPECT_TRUE(evaluator->evaluate(tasks_, {}, {}).has_value());
      });
  }
  // One at a time: together they were at work no longer than the clock ran.
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
  EXPECT_GT(backend->busy_seconds(), 0);
  EXPECT_LE(backend->busy_seconds(), seconds.count());
}

TEST_F(Evaluation, TellsGenomesAndSeedsApart) {
  std::set<double> by_genome, by_seed;
  for (const Result& result : evaluate(2)) by_genome.insert(result.rows.front().score);
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    tasks_[i].seed = i;
    tasks_[i].roster.front().genome = &genomes_.front();
  }
  for (const Result& result : evaluate(2)) by_seed.insert(result.rows.front().score);
  EXPECT_GT(by_genome.size(), 3u);
  EXPECT_GT(by_seed.size(), 3u);
}

TEST_F(Evaluation, ARosterGivesARowEachInItsOrder) {
  tasks_.resize(1);
  tasks_[0].roster = {{.genome = &genomes_[0], .key = 2, .x = -20},
                      {.genome = &genomes_[1], .key = 1, .x = 20}};
  const std::vector<Result> both = evaluate(1);
  ASSERT_THAT(both[0].rows, SizeIs(2));
  std::swap(tasks_[0].roster[0], tasks_[0].roster[1]);
  const std::vector<Result> swapped = evaluate(1);
  EXPECT_EQ(both[0].rows[0].score, swapped[0].rows[1].score);
  EXPECT_EQ(both[0].rows[1].score, swapped[0].rows[0].score);
}

TEST_F(Evaluation, NoTasksGiveNoResults) {
  tasks_.clear();
  EXPECT_THAT(evaluate(4), IsEmpty());
}

TEST_F(Evaluation, HandsOnEachResultOnceByTheCallingThread) {
  const std::thread::id caller = std::this_thread::get_id();
  std::map<std::size_t, double> seen;
  ThreadEvaluator evaluator(*ecosystem_, 2);
  const auto results = evaluator.evaluate(tasks_, {}, [&](std::size_t task, const Result& result) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_TRUE(seen.emplace(task, result.rows.at(0).score).second) << task;
  });
  ASSERT_EQ(seen.size(), tasks_.size());
  for (const auto& [task, score] : seen) EXPECT_EQ(results->at(task).rows[0].score, score);
}

TEST_F(Evaluation, WhatTheCallbackThrowsEndsTheWork) {
  std::size_t calls = 0;
  ThreadEvaluator evaluator(*ecosystem_, 2);
  const auto refuse = [&](std::size_t, const Result&) {
    ++calls;
    throw std::length_error("the disk is full");
  };
  EXPECT_THROW(static_cast<void>(evaluator.evaluate(tasks_, {}, refuse)), std::length_error);
  EXPECT_EQ(calls, 1u);
}

TEST_F(Evaluation, SeveralThreadsMayEvaluateAtATime) {
  const std::vector<Result> alone = evaluate(1);
  ThreadEvaluator evaluator(*ecosystem_, 2);
  std::vector<std::vector<Result>> together(3);
  {
    std::vector<std::jthread> callers;
    for (std::vector<Result>& results : together)
      callers.emplace_back([&] { results = evaluator.evaluate(tasks_, {}, {}).value(); });
  }
  for (const std::vector<Result>& results : together) {
    ASSERT_EQ(results.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_TRUE(same(results[i], alone[i])) << i;
  }
}

TEST_F(Evaluation, TasksThatFailAreSetAsideAndAllOthersEvaluated) {
  const std::vector<Result> before = evaluate(1);
  const std::set<std::size_t> bad = {17, 23, 41};
  for (const std::size_t i : bad) {
    genomes_[i].controller[0] = 255;
    genomes_[i].controller[1] = static_cast<std::uint8_t>(i);
  }
  for (const unsigned threads : {1u, 2u, 5u}) {
    const std::vector<Result> results = evaluate(threads);
    for (std::size_t i = 0; i < results.size(); ++i) {
      ASSERT_EQ(results[i].failure.has_value(), bad.contains(i)) << i;
      if (!bad.contains(i)) {
        EXPECT_TRUE(same(results[i], before[i])) << i;
        continue;
      }
      ASSERT_THAT(results[i].rows, SizeIs(1));
      EXPECT_EQ(results[i].failure->attempts, 3u);
      EXPECT_EQ(results[i].failure->plugin, "controller: express");
      EXPECT_EQ(results[i].failure->cause, "poison in gene " + std::to_string(i));
      EXPECT_EQ(results[i].failure->step, std::nullopt);
    }
  }
}

TEST_F(Evaluation, AFailureWithinASimulationTellsItsStep) {
  ecosystem_ = test::toy_ecosystem({.failing_step = 4});
  make(1);
  const Failure failure = evaluate(1).at(0).failure.value();
  EXPECT_EQ(failure.plugin, "reaper: act(stress)");
  EXPECT_EQ(failure.cause, "the scythe is blunt");
  EXPECT_EQ(failure.step, 4u);
}

TEST_F(Evaluation, AScoreThatIsNoNumberNamesTheFitness) {
  ecosystem_ = test::toy_ecosystem({.broken_fitness = true});
  make(1);
  const Failure failure = evaluate(1).at(0).failure.value();
  EXPECT_EQ(failure.plugin, "fitness: score");
  EXPECT_THAT(failure.cause, HasSubstr("\"longevity\" is not a number"));
}

TEST_F(Evaluation, CostliestTasksBeginFirst) {
  make(4);
  const double costs[] = {2, 7, 2, 9};
  for (std::size_t i = 0; i < 4; ++i) tasks_[i].predicted_cost = costs[i];
  EXPECT_THAT(longest_first(tasks_), ElementsAre(3, 1, 0, 2));
  std::vector<std::size_t> begun;
  ThreadEvaluator evaluator(*ecosystem_, 1);
  const auto results = evaluator.evaluate(
      tasks_, {}, [&](std::size_t task, const Result&) { begun.push_back(task); });
  EXPECT_THAT(begun, ElementsAre(3, 1, 0, 2));
  for (Task& task : tasks_) task.predicted_cost = 0;
  const std::vector<Result> unordered = evaluate(1);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(same(results->at(i), unordered[i])) << i;
}

TEST_F(Evaluation, AStopRequestEndsWithoutResults) {
  const std::atomic<bool> stop{true};
  ThreadEvaluator evaluator(*ecosystem_, 2);
  EXPECT_EQ(evaluator.evaluate(tasks_, StopToken(stop), {}), std::nullopt);
}

TEST_F(Evaluation, AStopRequestIsHeardWithinASimulation) {
  std::atomic<bool> stop{false};
  std::uint64_t steps = 0;
  const auto result =
      simulate(*ecosystem_, tasks_[0], StopToken(stop), [&](const model::Simulation&) {
        if (++steps == 3) stop = true;
      });
  EXPECT_EQ(result, std::nullopt);
  EXPECT_EQ(steps, 3u);
}

TEST_F(Evaluation, TheObserverSeesEveryStepOnce) {
  std::uint64_t steps = 0;
  const auto result = simulate(
      *ecosystem_, tasks_[0], {},
      [&](const model::Simulation& simulation) { EXPECT_EQ(simulation.steps_done(), ++steps); });
  ASSERT_TRUE(result);
  EXPECT_GE(steps, result->rows.front().outcome.survival);
}

}  // namespace
}  // namespace somas::evaluation
