#include "core/evaluation/thread_evaluator.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "core/evaluation/simulate.hpp"

namespace somas::evaluation {
namespace {

/// What the workers of one call share.
struct Batch {
  Batch(const model::Ecosystem& the_ecosystem, std::span<const Task> the_tasks, StopToken the_stop)
      : ecosystem(the_ecosystem),
        tasks(the_tasks),
        stop(the_stop),
        results(the_tasks.size()),
        errors(the_tasks.size()),
        first_failure(the_tasks.size()) {}

  const model::Ecosystem& ecosystem;
  std::span<const Task> tasks;
  StopToken stop;
  std::vector<Result> results;
  std::vector<std::exception_ptr> errors;
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> first_failure;  ///< lowest index that failed so far
  std::atomic<bool> stopped{false};
  std::atomic<bool> abandoned{false};  ///< nobody waits for the rest

  std::mutex mutex;
  std::condition_variable news;
  std::vector<std::size_t> finished;  ///< and not handed on yet
  unsigned running = 0;
};

void lower(std::atomic<std::size_t>& value, std::size_t to) {
  std::size_t seen = value.load();
  while (to < seen && !value.compare_exchange_weak(seen, to)) {
  }
}

void evaluate_one(Batch& batch, std::size_t index) {
  try {
    std::optional<Result> result = simulate(batch.ecosystem, batch.tasks[index], batch.stop);
    if (!result) {
      batch.stopped = true;
      return;
    }
    batch.results[index] = std::move(*result);
    const std::scoped_lock lock(batch.mutex);
    batch.finished.push_back(index);
    batch.news.notify_one();
  } catch (...) {
    batch.errors[index] = std::current_exception();
    lower(batch.first_failure, index);
  }
}

void work(Batch& batch) {
  // Tasks are handed out in ascending order and taken ones are finished: whatever the number of
  // threads, the lowest task that fails is among the finished.
  while (!batch.stop.stop_requested() && !batch.abandoned) {
    const std::size_t index = batch.next++;
    if (index >= batch.tasks.size() || index > batch.first_failure.load()) break;
    evaluate_one(batch, index);
  }
  if (batch.stop.stop_requested()) batch.stopped = true;
  const std::scoped_lock lock(batch.mutex);
  if (--batch.running == 0) batch.news.notify_one();
}

void hand_on(const Batch& batch, const std::vector<std::size_t>& finished,
             const ResultCallback& callback) {
  if (!callback) return;
  for (const std::size_t index : finished) callback(index, batch.results[index]);
}

void wait(Batch& batch, const ResultCallback& callback) {
  bool over = false;
  while (!over) {
    std::vector<std::size_t> finished;
    {
      std::unique_lock lock(batch.mutex);
      batch.news.wait(lock, [&] { return batch.running == 0 || !batch.finished.empty(); });
      finished.swap(batch.finished);
      over = batch.running == 0;
    }
    try {
      hand_on(batch, finished, callback);
    } catch (...) {
      batch.abandoned = true;
      throw;
    }
  }
}

[[noreturn]] void rethrow(const std::exception_ptr& error, std::size_t task) {
  try {
    std::rethrow_exception(error);
  } catch (const model::PluginFailure& failure) {
    throw EvaluationError(task, true, failure.what());
  } catch (const ParameterError& failure) {
    // A tree that evolved into one that cannot be.
    throw EvaluationError(task, true, failure.what());
  } catch (const std::exception& failure) {
    throw EvaluationError(task, false, failure.what());
  } catch (...) {
    throw EvaluationError(task, false, "an exception that is no std::exception");
  }
}

}  // namespace

ThreadEvaluator::ThreadEvaluator(const model::Ecosystem& ecosystem, unsigned threads)
    : ecosystem_(ecosystem),
      threads_(threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency())) {}

std::optional<std::vector<Result>> ThreadEvaluator::evaluate(std::span<const Task> tasks,
                                                             StopToken stop,
                                                             const ResultCallback& finished) {
  Batch batch(ecosystem_, tasks, stop);
  {
    std::vector<std::jthread> workers;
    const auto wanted = static_cast<unsigned>(std::min<std::size_t>(threads_, tasks.size()));
    batch.running = wanted;
    workers.reserve(wanted);
    for (unsigned i = 0; i < wanted; ++i) workers.emplace_back([&batch] { work(batch); });
    wait(batch, finished);
  }

  // A failure that is known is told, even when a stop came after it.
  if (const std::size_t failed = batch.first_failure; failed < tasks.size())
    rethrow(batch.errors[failed], failed);
  if (batch.stopped) return std::nullopt;
  return std::move(batch.results);
}

}  // namespace somas::evaluation
