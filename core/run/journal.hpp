// The journal of evaluations: what was evaluated once is never evaluated again, in this run or
// after a resume.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/run/sqlite.hpp"
#include "core/run/task_key.hpp"

namespace somas::run {

class Journal {
 public:
  /// `database`: a store that is open for writing; must outlive this. `experiment`: its key.
  Journal(const Database& database, const TaskKey& experiment);

  struct Evaluated {
    std::vector<evaluation::Result> results;  ///< by task
    std::vector<TaskKey> keys;                ///< by task
  };
  /// As Evaluator::evaluate, for the tasks that are new; each result is noted as it comes, and one
  /// that is on record is taken from there. `done`: how many tasks have their results. What came
  /// before a stop or an exception stays on record.
  [[nodiscard]] std::optional<Evaluated> evaluate(std::span<const evaluation::Task> tasks,
                                                  std::uint64_t generation,
                                                  evaluation::Evaluator& evaluator,
                                                  evaluation::StopToken stop,
                                                  const std::function<void(std::size_t)>& done);

  /// The result on record of a task with so many organisms.
  [[nodiscard]] std::optional<evaluation::Result> find(const TaskKey& key, std::size_t organisms);

 private:
  struct Plan;
  [[nodiscard]] Plan plan(std::span<const evaluation::Task> tasks);
  void record(const TaskKey& key, const evaluation::Task& task, std::uint64_t generation,
              const evaluation::Result& result);
  void record_failure(const TaskKey& key, const evaluation::Task& task, std::uint64_t generation,
                      const evaluation::Failure& failure);
  void commit_now_and_then();
  void commit();

  const Database& database_;
  TaskKey experiment_;
  Statement find_, find_failure_, insert_, insert_failure_, insert_organism_;
  std::chrono::steady_clock::time_point committed_{};
};

/// Throws DamagedStore unless every evaluation and failure on record has its checksum.
void verify_journal(const Database& database);

}  // namespace somas::run
