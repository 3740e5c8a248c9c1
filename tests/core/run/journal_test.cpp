#include "core/run/journal.hpp"

#include <atomic>
#include <set>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evaluation/thread_evaluator.hpp"
#include "core/run/store.hpp"
#include "core/run/store_export.hpp"
#include "tests/core/run/scratch.hpp"
#include "tests/core/run/toy_experiment.hpp"

namespace somas::run {
namespace {

using evaluation::Result;
using evaluation::ResultCallback;
using evaluation::StopToken;
using evaluation::Task;
using testing::SizeIs;

/// Counts what it is asked for; may set tasks aside, stop, or break down after some of them.
class Counting final : public evaluation::Evaluator {
 public:
  explicit Counting(const model::Ecosystem& ecosystem) : inner_(ecosystem, 1) {}

  std::optional<std::vector<Result>> evaluate(std::span<const Task> tasks, StopToken stop,
                                              const ResultCallback& finished) override {
    std::vector<Result> results;
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      if (asked == stop_after) return std::nullopt;
      if (asked == fail_after) throw std::runtime_error("worn out");
      ++asked;
      Result result = inner_.evaluate(tasks.subspan(t, 1), stop, {}).value().front();
      if (set_aside) {
        result.rows.assign(tasks[t].roster.size(), {});
        result.failure = evaluation::Failure{3, "SIGSEGV", "controller: step", 17};
      }
      finished(t, result);
      results.push_back(std::move(result));
    }
    return results;
  }

  std::optional<evaluation::Reference> reference() override { return inner_.reference(); }
  void expect(const evaluation::Reference& reference) override { inner_.expect(reference); }

  std::size_t asked = 0;
  std::size_t stop_after = SIZE_MAX, fail_after = SIZE_MAX;
  bool set_aside = false;

 private:
  evaluation::ThreadEvaluator inner_;
};

class Journals : public testing::Test {
 protected:
  Journals() {
    Store::create(file_, {"", ""});
    for (std::uint64_t i = 0; i < 6; ++i) genomes_.push_back(test::toy_genome(*ecosystem_, i));
    for (const model::Genome& genome : genomes_) tasks_.push_back({{{&genome}}, 7});
  }

  std::optional<Journal::Evaluated> evaluate(Counting& counting) {
    Store store(file_, Database::Access::write);
    Journal journal(store.database(), key_);
    return journal.evaluate(tasks_, 0, counting, {}, {});
  }
  std::string dump_text() const {
    const Store store(file_, Database::Access::read);
    std::string text;
    dump(store.database(), [&](std::string_view piece) { text += piece; });
    return text;
  }

  test::Scratch scratch_;
  std::filesystem::path file_ = scratch_.path() / store_name;
  std::shared_ptr<const model::Ecosystem> ecosystem_ = test::toy_ecosystem();
  TaskKey key_ = key_of(test::toy_experiment());
  std::vector<model::Genome> genomes_;
  std::vector<Task> tasks_;
};

TEST_F(Journals, WhatIsOnRecordIsNotEvaluatedAgain) {
  Counting first(*ecosystem_), second(*ecosystem_);
  const auto fresh = evaluate(first);
  const auto recorded = evaluate(second);
  EXPECT_EQ(first.asked, 6u);
  EXPECT_EQ(second.asked, 0u);
  for (std::size_t t = 0; t < tasks_.size(); ++t) {
    const evaluation::Row &a = fresh->results[t].rows[0], &b = recorded->results[t].rows[0];
    EXPECT_EQ(a.score, b.score);
    EXPECT_EQ(a.outcome.survival, b.outcome.survival);
    EXPECT_EQ(a.outcome.censored, b.outcome.censored);
    EXPECT_EQ(a.outcome.divisions, b.outcome.divisions);
    EXPECT_EQ(a.outcome.specializations, b.outcome.specializations);
    EXPECT_EQ(a.outcome.refused_divisions, b.outcome.refused_divisions);
    EXPECT_EQ(a.outcome.final_cells, b.outcome.final_cells);
    EXPECT_EQ(a.outcome.peak_cells, b.outcome.peak_cells);
    EXPECT_EQ(a.outcome.cell_steps, b.outcome.cell_steps);
    EXPECT_EQ(a.outcome.biomass_share, b.outcome.biomass_share);
  }
}

TEST_F(Journals, EqualTasksOfOneGenerationAreEvaluatedOnce) {
  tasks_.push_back(tasks_[2]);
  tasks_.push_back(tasks_[2]);
  Counting counting(*ecosystem_);
  Store store(file_, Database::Access::write);
  Journal journal(store.database(), key_);
  std::vector<std::size_t> done;
  const auto evaluated =
      journal.evaluate(tasks_, 0, counting, {}, [&](std::size_t count) { done.push_back(count); });
  EXPECT_EQ(counting.asked, 6u);
  ASSERT_THAT(evaluated->results, SizeIs(8));
  EXPECT_EQ(evaluated->results[7].rows[0].score, evaluated->results[2].rows[0].score);
  EXPECT_THAT(done, testing::ElementsAre(0, 1, 2, 5, 6, 7, 8));
}

TEST_F(Journals, WhateverDecidesAResultMakesAKey) {
  std::set<TaskKey> keys;
  const auto add = [&](const TaskKey& experiment, const Task& task) {
    EXPECT_TRUE(keys.insert(key_of(experiment, task)).second);
  };
  const Task& task = tasks_[0];
  add(key_, task);
  Task other = task;
  other.seed = 8;
  add(key_, other);
  for (double evaluation::Organism::*place : {&evaluation::Organism::x, &evaluation::Organism::y}) {
    other = task;
    other.roster[0].*place = 1;
    add(key_, other);
  }
  other = task;
  other.roster[0].key = 2;
  add(key_, other);
  other = task;
  other.roster[0].genome = &genomes_[1];
  add(key_, other);
  other = task;
  other.roster.push_back(task.roster[0]);
  add(key_, other);
  model::Genome moved = genomes_[0];
  moved.tree.swap(moved.controller);
  other = task;
  other.roster[0].genome = &moved;
  add(key_, other);
  experiment::Experiment experiment = test::toy_experiment();
  experiment.simulation_yaml = "world: {radius: 3}";
  add(key_of(experiment), task);
  experiment = test::toy_experiment();
  experiment.libraries.push_back({file_, "p", "1", "", {}});
  add(key_of(experiment), task);
  // The number of generations is none of it: a run can be extended.
  experiment = test::toy_experiment();
  experiment.evolution.generations = 999;
  experiment.resolved_yaml = "other";
  EXPECT_EQ(key_of(experiment), key_);
}

TEST_F(Journals, AfterAStopOnlyTheRestIsEvaluated) {
  Counting stopped(*ecosystem_), rest(*ecosystem_), whole(*ecosystem_);
  stopped.stop_after = 4;
  EXPECT_FALSE(evaluate(stopped));
  EXPECT_TRUE(evaluate(rest));
  EXPECT_EQ(rest.asked, 2u);
}

TEST_F(Journals, AfterAnExceptionOnlyTheRestIsEvaluated) {
  Counting counting(*ecosystem_), rest(*ecosystem_);
  tasks_.insert(tasks_.begin() + 1, tasks_[0]);
  counting.fail_after = 3;
  EXPECT_THROW(evaluate(counting), std::runtime_error);
  EXPECT_TRUE(evaluate(rest));
  EXPECT_EQ(rest.asked, 3u);
}

TEST_F(Journals, ATaskThatWasSetAsideIsOnRecordWithItsReason) {
  Counting counting(*ecosystem_), again(*ecosystem_);
  counting.set_aside = true;
  evaluate(counting);
  const auto evaluated = evaluate(again);
  EXPECT_EQ(again.asked, 0u);
  const Result& result = evaluated->results[3];
  ASSERT_TRUE(result.failure);
  EXPECT_EQ(result.failure->attempts, 3u);
  EXPECT_EQ(result.failure->cause, "SIGSEGV");
  EXPECT_EQ(result.failure->plugin, "controller: step");
  EXPECT_EQ(result.failure->step, 17u);
  EXPECT_THAT(result.rows, SizeIs(1));
  EXPECT_THAT(dump_text(), testing::HasSubstr(",3,SIGSEGV,controller: step,17,"));
}

TEST_F(Journals, TheRosterOfATaskThatWasSetAsideIsOnRecordWithItsGenes) {
  tasks_[3].roster.push_back({.genome = &genomes_[1], .key = 9, .x = -0.0, .y = 2.5});
  Counting counting(*ecosystem_);
  counting.set_aside = true;
  evaluate(counting);
  const Store store(file_, Database::Access::write);  // and its checksums hold
  Statement rows(store.database(),
                 "SELECT seat, key, x, y, controller, tree FROM failed_organisms "
                 "JOIN failures USING (task) WHERE task = ? ORDER BY seat");
  rows.with(Bytes(key_of(key_, tasks_[3])));
  for (const evaluation::Organism& organism : tasks_[3].roster) {
    ASSERT_TRUE(rows.step());
    EXPECT_EQ(rows.natural(1), organism.key);
    EXPECT_EQ(rows.real(2), organism.x);
    EXPECT_EQ(rows.real(3), organism.y);
    EXPECT_THAT(rows.bytes(4), testing::ElementsAreArray(organism.genome->controller));
    EXPECT_THAT(rows.bytes(5), testing::ElementsAreArray(organism.genome->tree));
  }
  EXPECT_FALSE(rows.step());
}

TEST_F(Journals, AFailedGenomeThatWasTamperedWithIsNoticed) {
  Counting counting(*ecosystem_);
  counting.set_aside = true;
  evaluate(counting);
  const Database database(file_, Database::Access::write);
  database.execute("UPDATE failed_organisms SET controller = x'00'");
  EXPECT_THROW(Store(file_, Database::Access::write), DamagedStore);
}

TEST_F(Journals, TheDumpDoesNotDependOnTheOrderOfEvaluation) {
  Counting forth(*ecosystem_);
  evaluate(forth);
  const std::string before = dump_text();
  std::filesystem::remove(file_);
  Store::create(file_, {"", ""});
  std::reverse(tasks_.begin(), tasks_.end());
  Counting back(*ecosystem_);
  evaluate(back);
  EXPECT_EQ(dump_text(), before);
}

TEST_F(Journals, AnEvaluationThatWasTamperedWithIsNoticed) {
  Counting counting(*ecosystem_);
  evaluate(counting);
  const Database database(file_, Database::Access::write);
  database.execute(
      "UPDATE evaluations SET score = score + 1 WHERE task = (SELECT min(task) FROM "
      "evaluations)");
  EXPECT_THROW(Store(file_, Database::Access::write), DamagedStore);
}

}  // namespace
}  // namespace somas::run
