#include "core/evaluation/thread_evaluator.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <numeric>
#include <thread>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/canary.hpp"
#include "core/evaluation/crash_report.hpp"
#include "core/evaluation/simulate.hpp"

namespace somas::evaluation {
namespace {

/// What the workers of one call share.
struct Batch {
  Batch(const model::Ecosystem& the_ecosystem, std::span<const Task> the_tasks, StopToken the_stop,
        ThreadEvaluator::Turnstile* the_turnstile, model::Profile* the_profile,
        model::WorldThreads the_world)
      : ecosystem(the_ecosystem),
        tasks(the_tasks),
        stop(the_stop),
        turnstile(the_turnstile),
        profile(the_profile),
        world(the_world),
        order(longest_first(the_tasks)),
        results(the_tasks.size()) {}

  const model::Ecosystem& ecosystem;
  std::span<const Task> tasks;
  StopToken stop;
  ThreadEvaluator::Turnstile* turnstile;  ///< may be null
  model::Profile* profile;                ///< may be null
  model::WorldThreads world;
  std::vector<std::size_t> order;
  std::vector<Result> results;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stopped{false};
  std::atomic<bool> abandoned{false};  ///< nobody waits for the rest

  std::mutex mutex;
  std::condition_variable news;
  std::vector<std::size_t> finished;  ///< and not handed on yet
  unsigned running = 0;
  std::exception_ptr error;  ///< the first that came
};

// A task that fails is tried again, as everywhere; here in the same process, for want of another.
std::optional<Result> evaluate_patiently(const Batch& batch, const Task& task,
                                         model::Profile* profile, model::Team& team) {
  std::optional<Result> result;
  for (std::uint32_t attempts = 1; attempts <= most_attempts; ++attempts) {
    result = attempt(batch.ecosystem, task, batch.stop, profile, &team);
    if (!result || !result->failure) break;
    result->failure->attempts = attempts;
  }
  return result;
}

/// A place among those who may simulate, until it is given back.
class Turn {
 public:
  explicit Turn(ThreadEvaluator::Turnstile* turnstile) : turnstile_(turnstile) {
    if (turnstile_ == nullptr) return;
    turnstile_->places.acquire();
    begun_ = Clock::now();
  }
  ~Turn() {
    if (turnstile_ == nullptr) return;
    turnstile_->busy_seconds += std::chrono::duration<double>(Clock::now() - begun_).count();
    turnstile_->places.release();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  ThreadEvaluator::Turnstile* turnstile_;
  Clock::time_point begun_;
};

void evaluate_one(Batch& batch, std::size_t index, model::Profile* profile, model::Team& team) {
  try {
    std::optional<Result> result = evaluate_patiently(batch, batch.tasks[index], profile, team);
    if (!result) {
      batch.stopped = true;
      return;
    }
    batch.results[index] = std::move(*result);
    const std::scoped_lock lock(batch.mutex);
    batch.finished.push_back(index);
    batch.news.notify_one();
  } catch (...) {
    batch.abandoned = true;
    const std::scoped_lock lock(batch.mutex);
    if (!batch.error) batch.error = std::current_exception();
  }
}

void work(Batch& batch) {
  const WatchedThread watched;
  model::Profile own;
  model::Team team(batch.world);
  while (!batch.stop.stop_requested() && !batch.abandoned) {
    const Turn turn(batch.turnstile);
    if (batch.stop.stop_requested()) break;
    const std::size_t index = batch.next++;
    if (index >= batch.order.size()) break;
    evaluate_one(batch, batch.order[index], batch.profile != nullptr ? &own : nullptr, team);
  }
  if (batch.stop.stop_requested()) batch.stopped = true;
  if (batch.profile != nullptr) {
    static std::mutex merging;  // several calls may share a profile
    const std::scoped_lock lock(merging);
    batch.profile->add(own);
  }
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

[[noreturn]] void rethrow(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    throw EvaluatorsLost(
        "a simulation ran out of memory; finished work is saved, and the run can be resumed");
  }
}

}  // namespace

std::vector<std::size_t> longest_first(std::span<const Task> tasks) {
  std::vector<std::size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tasks[a].predicted_cost > tasks[b].predicted_cost;
  });
  return order;
}

ThreadEvaluator::ThreadEvaluator(const model::Ecosystem& ecosystem, unsigned threads,
                                 std::shared_ptr<Turnstile> turnstile, model::Profile* profile,
                                 model::WorldThreads world)
    : ecosystem_(ecosystem),
      threads_(threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency())),
      turnstile_(std::move(turnstile)),
      profile_(profile),
      world_(world) {}

std::optional<std::vector<Result>> ThreadEvaluator::evaluate(std::span<const Task> tasks,
                                                             StopToken stop,
                                                             const ResultCallback& finished) {
  Batch batch(ecosystem_, tasks, stop, turnstile_.get(), profile_, world_);
  {
    std::vector<std::jthread> workers;
    const auto wanted = static_cast<unsigned>(std::min<std::size_t>(threads_, tasks.size()));
    batch.running = wanted;
    workers.reserve(wanted);
    for (unsigned i = 0; i < wanted; ++i) workers.emplace_back([&batch] { work(batch); });
    wait(batch, finished);
  }

  if (batch.error) rethrow(batch.error);
  if (batch.stopped) return std::nullopt;
  return std::move(batch.results);
}

std::optional<Reference> ThreadEvaluator::reference() {
  for (; !reference_ && next_canary_ < most_canaries; ++next_canary_) {
    try {
      reference_ = Reference{next_canary_, canary_hash(ecosystem_, next_canary_)};
    } catch (const model::PluginFailure&) {
      // Another organism may do.
    }
  }
  return reference_;
}

void ThreadEvaluator::expect(const Reference& reference) {
  const std::string hash = canary_hash(ecosystem_, reference.canary);
  if (hash != reference.hash)
    throw EvaluatorsLost("the reference simulation gives " + hash + " on this machine instead of " +
                         reference.hash + "; the run can be resumed where it gives that");
  reference_ = reference;
}

namespace {

class ThreadBackend final : public Backend {
 public:
  ThreadBackend(unsigned workers, model::Profile* profile, model::WorldThreads world)
      : workers_(workers != 0 ? workers
                              : std::max(1u, std::thread::hardware_concurrency() / world.threads)),
        turnstile_(std::make_shared<ThreadEvaluator::Turnstile>(workers_)),
        profile_(profile),
        world_(world) {}
  [[nodiscard]] std::unique_ptr<Evaluator> evaluator(
      const experiment::Experiment& experiment) override {
    return std::make_unique<ThreadEvaluator>(*experiment.ecosystem, workers_, turnstile_, profile_,
                                             world_);
  }
  [[nodiscard]] unsigned workers() const override { return workers_; }
  [[nodiscard]] double busy_seconds() const override { return turnstile_->busy_seconds; }
  [[nodiscard]] unsigned world_threads() const override { return world_.threads; }
  [[nodiscard]] std::string description() const override {
    return std::to_string(workers_) + (workers_ == 1 ? " thread" : " threads");
  }

 private:
  unsigned workers_;
  std::shared_ptr<ThreadEvaluator::Turnstile> turnstile_;
  model::Profile* profile_;
  model::WorldThreads world_;
};

}  // namespace

std::unique_ptr<Backend> thread_backend(unsigned workers, model::Profile* profile,
                                        model::WorldThreads world) {
  return std::make_unique<ThreadBackend>(workers, profile, world);
}

}  // namespace somas::evaluation
