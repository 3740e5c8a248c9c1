// Evaluation by threads of this process.
#pragma once

#include <atomic>
#include <memory>
#include <semaphore>

#include "core/evaluation/evaluator.hpp"
#include "core/model/profile.hpp"
#include "core/model/team.hpp"

namespace somas::evaluation {

/// Indices of tasks by descending predicted cost, equal ones in their order.
[[nodiscard]] std::vector<std::size_t> longest_first(std::span<const Task> tasks);

/// Workers take tasks, costliest first, and write each result to its own place, so the number of
/// threads never reaches the results. The calling thread only waits and hands on what is finished.
class ThreadEvaluator final : public Evaluator {
 public:
  /// Lets so many simulate at a time, of all evaluators that share it.
  struct Turnstile {
    explicit Turnstile(unsigned workers) : places(workers) {}
    std::counting_semaphore<> places;
    std::atomic<double> busy_seconds = 0;  ///< of all who have passed
  };

  /// `ecosystem` must outlive this. threads = 0: one per processor. `profile`, `world`: as of
  /// thread_backend.
  ThreadEvaluator(const model::Ecosystem& ecosystem, unsigned threads,
                  std::shared_ptr<Turnstile> turnstile = nullptr, model::Profile* profile = nullptr,
                  model::WorldThreads world = {});

  [[nodiscard]] std::optional<std::vector<Result>> evaluate(
      std::span<const Task> tasks, StopToken stop, const ResultCallback& finished) override;

  [[nodiscard]] std::optional<Reference> reference() override;
  void expect(const Reference& reference) override;

  [[nodiscard]] unsigned threads() const { return threads_; }

 private:
  const model::Ecosystem& ecosystem_;
  std::optional<Reference> reference_{};
  std::uint32_t next_canary_ = 0;  ///< those before it have failed, and would again
  unsigned threads_;
  std::shared_ptr<Turnstile> turnstile_;  ///< null: all threads at a time
  model::Profile* profile_;
  model::WorldThreads world_;
};

}  // namespace somas::evaluation
