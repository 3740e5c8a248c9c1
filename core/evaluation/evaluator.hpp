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
  double predicted_cost = 0;  ///< in any unit; costlier ones begin first. Never reaches results
};

/// What became of one organism of a task.
struct Row {
  Outcome outcome;
  double score = 0;  ///< finite
};

/// A short simulation of random genes, and the hash of all its steps.
struct Reference {
  std::uint32_t canary = 0;  ///< which one
  std::string hash;
  bool operator==(const Reference&) const = default;
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

/// How often a task is tried whose plugins fail, before it is set aside.
inline constexpr std::uint32_t most_attempts = 3;

/// The work cannot go on, and no plugin is known to be at fault: evaluators were killed, memory ran
/// out, a simulation made no progress, a machine is lost. Nothing is decided about any genome; what
/// was finished stays finished.
class EvaluatorsLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The same, for all who share the evaluators: none is left, or a machine is lost.
class PoolLost final : public EvaluatorsLost {
 public:
  using EvaluatorsLost::EvaluatorsLost;
};

/// No simulation can be done: the experiment's plugins throw or crash in every reference
/// simulation.
class ExperimentFails : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Called by the thread that called `evaluate`, once per finished task, in the order of finishing.
/// What it throws ends the evaluation and is thrown on.
using ResultCallback = std::function<void(std::size_t task, const Result& result)>;

class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// A result per task, in the order of the tasks; nothing if `stop` ended the work early. A task
  /// whose plugins fail `most_attempts` times gets a result that says so. Throws EvaluatorsLost,
  /// ExperimentFails.
  /// May be called by several threads at a time.
  [[nodiscard]] virtual std::optional<std::vector<Result>> evaluate(
      std::span<const Task> tasks, StopToken stop, const ResultCallback& finished) = 0;

  /// What the reference simulation gave here; nothing while that is not known. Two evaluators of an
  /// experiment with the same reference compute the same bits.
  [[nodiscard]] virtual std::optional<Reference> reference() = 0;
  /// What the reference simulation has to give, since it gave it before. To be called before
  /// `evaluate`, by which EvaluatorsLost is thrown at the latest if nobody here reproduces it.
  virtual void expect(const Reference& reference) = 0;
};

}  // namespace somas::evaluation
