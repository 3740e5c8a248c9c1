// Evaluation by threads of this process.
#pragma once

#include "core/evaluation/evaluator.hpp"
#include "core/model/profile.hpp"

namespace somas::evaluation {

/// Indices of tasks by descending predicted cost, equal ones in their order.
[[nodiscard]] std::vector<std::size_t> longest_first(std::span<const Task> tasks);

/// Workers take tasks, costliest first, and write each result to its own place, so the number of
/// threads never reaches the results. The calling thread only waits and hands on what is finished.
class ThreadEvaluator final : public Evaluator {
 public:
  /// `ecosystem` must outlive this. threads = 0: one per processor. `profile`: as of
  /// thread_backend.
  ThreadEvaluator(const model::Ecosystem& ecosystem, unsigned threads,
                  model::Profile* profile = nullptr);

  [[nodiscard]] std::optional<std::vector<Result>> evaluate(
      std::span<const Task> tasks, StopToken stop, const ResultCallback& finished) override;

  [[nodiscard]] unsigned threads() const { return threads_; }

 private:
  const model::Ecosystem& ecosystem_;
  unsigned threads_;
  model::Profile* profile_;
};

}  // namespace somas::evaluation
