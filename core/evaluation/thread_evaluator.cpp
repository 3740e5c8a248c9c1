#include "core/evaluation/thread_evaluator.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "core/evaluation/simulate.hpp"

namespace somas::evaluation {
namespace {

constexpr std::chrono::milliseconds report_interval{100};

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
  std::atomic<std::size_t> done{0};
  std::atomic<std::size_t> first_failure;  ///< lowest index that failed so far
  std::atomic<bool> stopped{false};

  std::mutex mutex;
  std::condition_variable finished;
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
    if (result)
      batch.results[index] = std::move(*result);
    else
      batch.stopped = true;
  } catch (...) {
    batch.errors[index] = std::current_exception();
    lower(batch.first_failure, index);
  }
  ++batch.done;
}

void work(Batch& batch) {
  // Tasks are handed out in ascending order and taken ones are finished: whatever the number of
  // threads, the lowest task that fails is among the finished.
  while (!batch.stop.stop_requested()) {
    const std::size_t index = batch.next++;
    if (index >= batch.tasks.size() || index > batch.first_failure.load()) break;
    evaluate_one(batch, index);
  }
  if (batch.stop.stop_requested()) batch.stopped = true;
  const std::scoped_lock lock(batch.mutex);
  if (--batch.running == 0) batch.finished.notify_one();
}

void wait(Batch& batch, const ProgressCallback& progress) {
  std::unique_lock lock(batch.mutex);
  while (!batch.finished.wait_for(lock, report_interval, [&] { return batch.running == 0; })) {
    if (!progress) continue;
    lock.unlock();
    progress(batch.done.load());
    lock.lock();
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
                                                             const ProgressCallback& progress) {
  Batch batch(ecosystem_, tasks, stop);
  {
    std::vector<std::jthread> workers;
    const auto wanted = static_cast<unsigned>(std::min<std::size_t>(threads_, tasks.size()));
    batch.running = wanted;
    workers.reserve(wanted);
    for (unsigned i = 0; i < wanted; ++i) workers.emplace_back([&batch] { work(batch); });
    wait(batch, progress);
  }

  // A failure that is known is told, even when a stop came after it.
  if (const std::size_t failed = batch.first_failure; failed < tasks.size())
    rethrow(batch.errors[failed], failed);
  if (batch.stopped) return std::nullopt;
  if (progress) progress(tasks.size());
  return std::move(batch.results);
}

}  // namespace somas::evaluation
