// Genomes in, results out. Where the work is done (threads, processes, other machines) is the
// business of the implementation and never reaches the results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/evaluation/stop.hpp"
#include "core/model/ecosystem.hpp"

namespace somas::evaluation {

/// An organism of a task: its genome, its key (which names its random streams; unique within the
/// task) and the place of its founder. The genome must outlive the evaluation.
struct Organism {
  const model::Genome* genome = nullptr;
  std::uint64_t key = 1;
  double x = 0, y = 0;
};

/// One simulation.
struct Task {
  std::vector<Organism> roster;
  std::uint64_t seed = 0;
};

/// What became of one organism of a task.
struct Row {
  Outcome outcome;
  double score = 0;  ///< finite
};

/// Why a task was set aside: a plugin failed in it, time and again.
struct Failure {
  std::uint32_t attempts = 0;
  std::string cause;                  ///< "std::runtime_error: ...", "SIGSEGV"
  std::string plugin;                 ///< instance and call; empty: not known
  std::optional<std::uint64_t> step;  ///< of the simulation; none: before its first
};

/// A row per organism, in the order of the roster; of a task that was set aside, default ones.
struct Result {
  std::vector<Row> rows;
  std::optional<Failure> failure{};
};

/// A task that could not be evaluated.
class EvaluationError : public std::runtime_error {
 public:
  /// `of_plugin`: a plugin failed; otherwise the fault is the host's own.
  EvaluationError(std::size_t task, bool of_plugin, const std::string& what)
      : std::runtime_error(what), task_(task), of_plugin_(of_plugin) {}
  [[nodiscard]] std::size_t task() const { return task_; }
  [[nodiscard]] bool of_plugin() const { return of_plugin_; }

 private:
  std::size_t task_;
  bool of_plugin_;
};

/// Called by the thread that called `evaluate`, once per finished task, in the order of finishing.
/// What it throws ends the evaluation and is thrown on.
using ResultCallback = std::function<void(std::size_t task, const Result& result)>;

class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// A result per task, in the order of the tasks; nothing if `stop` ended the work early. Throws
  /// the EvaluationError of the first task (in their order) that failed. May be called by several
  /// threads at a time.
  [[nodiscard]] virtual std::optional<std::vector<Result>> evaluate(
      std::span<const Task> tasks, StopToken stop, const ResultCallback& finished) = 0;
};

}  // namespace somas::evaluation
