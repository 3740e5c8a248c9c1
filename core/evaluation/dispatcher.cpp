#include "core/evaluation/dispatcher.hpp"

#include <algorithm>
#include <cmath>
#include <unistd.h>
#include <utility>

#include <sys/eventfd.h>

#include "core/evaluation/canary.hpp"
#include "core/evaluation/thread_evaluator.hpp"

namespace somas::evaluation {
namespace {

/// Work of a batch, in seconds: much more than what sending it takes.
constexpr double batch_seconds = 0.004;
constexpr std::size_t largest_batch = 64;
/// Evaluators that may be lost over one task, or one loading. What runs out of memory or hangs will
/// do so again: it counts more than a kill from outside.
constexpr std::uint32_t most_losses = 9;
std::uint32_t weight_of(const Death& death) { return death.kind == Death::Kind::exhausted ? 3 : 1; }
constexpr std::chrono::milliseconds look_for_stop{100};

constexpr const char* resumable = "; finished work is saved, and the run can be resumed";

bool holds(const std::vector<std::uint32_t>& list, std::uint32_t id) {
  return std::find(list.begin(), list.end(), id) != list.end();
}

std::exception_ptr lost(const std::string& why) {
  return std::make_exception_ptr(EvaluatorsLost(why + resumable));
}
/// The same for everybody.
std::exception_ptr all_lost(const std::string& why) {
  return std::make_exception_ptr(PoolLost(why + resumable));
}

}  // namespace

Job::Job(std::uint32_t the_experiment, std::span<const Task> the_tasks)
    : experiment(the_experiment),
      tasks(the_tasks),
      results(the_tasks.size()),
      faults(the_tasks.size()),
      losses(the_tasks.size()),
      left(the_tasks.size()) {
  const std::vector<std::size_t> order = longest_first(the_tasks);
  waiting.assign(order.begin(), order.end());
}

// ---- for those who want work done --------------------------------------------------------------

Pool::Dispatcher::Dispatcher(std::vector<std::size_t> places, StationMaker make_stations,
                             std::function<void(const std::string&)> warn)
    : warn_(std::move(warn)), wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  // Round-robin over machines, so that few tasks spread out.
  const std::size_t most = places.empty() ? 0 : *std::max_element(places.begin(), places.end());
  for (std::size_t place = 0; place < most; ++place)
    for (std::size_t station = 0; station < places.size(); ++station)
      if (place < places[station]) {
        Worker& worker = workers_.emplace_back();
        worker.station = station;
        worker.place = place;
      }
  thread_ = std::jthread([this, make = std::move(make_stations)] { run(make); });
}

Pool::Dispatcher::~Dispatcher() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake();
  thread_.join();
  ::close(wake_);
}

std::uint32_t Pool::Dispatcher::enter(const experiment::Experiment& experiment) {
  const std::scoped_lock lock(mutex_);
  const std::uint32_t id = next_experiment_++;
  experiments_[id].message = message_of(experiment, id);
  return id;
}

void Pool::Dispatcher::leave(std::uint32_t experiment) {
  {
    const std::scoped_lock lock(mutex_);
    experiments_.erase(experiment);
    to_forget_.push_back(experiment);
  }
  wake();
}

std::optional<std::vector<Result>> Pool::Dispatcher::evaluate(std::uint32_t experiment,
                                                              std::span<const Task> tasks,
                                                              StopToken stop,
                                                              const ResultCallback& finished) {
  const auto job = std::make_shared<Job>(experiment, tasks);
  std::unique_lock lock(mutex_);
  if (lost_) throw PoolLost(*lost_);
  jobs_.push_back(job);
  fail_those_without_evaluator();
  wake();

  // However we leave, nobody touches the caller's tasks any more.
  const auto remove = [&] {
    job->over = true;
    std::erase(jobs_, job);
  };
  while (job->left > 0 || !job->finished.empty()) {
    job->news.wait_for(lock, look_for_stop,
                       [&] { return !job->finished.empty() || job->error != nullptr; });
    const std::vector<std::size_t> news = std::exchange(job->finished, {});
    lock.unlock();
    try {
      if (finished)
        for (const std::size_t task : news) finished(task, job->results[task]);
    } catch (...) {
      lock.lock();
      remove();
      throw;
    }
    lock.lock();
    if (!job->finished.empty()) continue;
    if (job->left > 0 && stop.stop_requested()) {
      remove();
      return std::nullopt;
    }
    if (job->error) {
      remove();
      std::rethrow_exception(job->error);
    }
  }
  remove();
  return std::move(job->results);
}

std::optional<Reference> Pool::Dispatcher::reference(std::uint32_t id) const {
  const std::scoped_lock lock(mutex_);
  const Experiment& experiment = experiments_.at(id);
  if (!experiment.reference) return std::nullopt;
  return Reference{experiment.message.canary, *experiment.reference};
}

void Pool::Dispatcher::expect(std::uint32_t id, const Reference& reference) {
  const std::scoped_lock lock(mutex_);
  Experiment& experiment = experiments_.at(id);
  experiment.message.canary = reference.canary;
  experiment.reference = reference.hash;
}

// ---- the thread --------------------------------------------------------------------------------

void Pool::Dispatcher::wake() const {
  const std::uint64_t one = 1;
  // Full means that it is awake already.
  static_cast<void>(!::write(wake_, &one, sizeof one));
}

void Pool::Dispatcher::run(const StationMaker& make_stations) {
  std::vector<Event> events;
  for (;;) {
    try {
      if (stations_.empty()) stations_ = make_stations();
      {
        const std::scoped_lock lock(mutex_);
        if (ending_) break;
        if (!lost_) hand_out();
      }
      wait();
      for (std::size_t station = 0; station < stations_.size(); ++station) {
        events.clear();
        stations_[station]->collect(events);
        const std::scoped_lock lock(mutex_);
        for (const Event& event : events) handle(station, event);
      }
    } catch (const std::exception& error) {
      // A machine is lost, or no process can be started: all who wait are told.
      const std::scoped_lock lock(mutex_);
      lost_ = std::string(error.what()) + resumable;
      fail_all(all_lost(error.what()));
      break;
    }
  }
  stations_.clear();
}

void Pool::Dispatcher::wait() {
  std::vector<pollfd> descriptors = {{.fd = wake_, .events = POLLIN, .revents = 0}};
  int patience = -1;
  for (const auto& station : stations_) {
    station->wait_for(descriptors);
    const int other = station->patience();
    if (other >= 0) patience = patience < 0 ? other : std::min(patience, other);
  }
  ::poll(descriptors.data(), descriptors.size(), patience);
  std::uint64_t count = 0;
  static_cast<void>(!::read(wake_, &count, sizeof count));
}

// ---- handing out -------------------------------------------------------------------------------

void Pool::Dispatcher::hand_out() {
  for (const std::uint32_t id : to_forget_)
    for (Worker& worker : workers_)
      if (std::erase(worker.loaded, id) > 0) {
        Writer out;
        out.put(Tag::forget).put(id);
        stations_[worker.station]->send(worker.place, out.take());
      }
  to_forget_.clear();
  // One batch each in turn: nobody gets a second one while another has none.
  for (bool any = true; any;) {
    any = false;
    for (Worker& worker : workers_) any = serve(worker) || any;
  }
}

// True if the worker got something.
bool Pool::Dispatcher::serve(Worker& worker) {
  if (worker.state == State::refused || worker.loading || worker.batches >= 2) return false;
  const std::shared_ptr<Job> job = choose(worker);
  if (!job) return false;
  // A task that waits behind another is taken from those who have nothing: not towards the end.
  if (worker.batches == 1 && job->waiting.size() < workers_.size()) return false;
  if (job->faults[job->waiting.front()] > 0 && worker.used) {
    // It has failed before: it gets a process of its own.
    if (worker.batches > 0) return false;
    stations_[worker.station]->stop(worker.place);
    worker.state = State::absent;
    worker.loaded.clear();
  }
  if (worker.state == State::absent) start(worker);
  if (holds(worker.loaded, job->experiment))
    send_batch(worker, job);
  else
    load(worker, job->experiment);
  return true;
}

// Of the jobs with work for this worker the one that has the fewest at it.
std::shared_ptr<Job> Pool::Dispatcher::choose(const Worker& worker) const {
  std::shared_ptr<Job> chosen;
  for (const auto& job : jobs_) {
    if (job->over || job->waiting.empty() || holds(worker.unable, job->experiment)) continue;
    // The reference comes from one evaluator of the coordinator's machine; the others wait for it.
    const Experiment& experiment = experiments_.at(job->experiment);
    if (!experiment.reference && (experiment.being_tried || worker.station != 0)) continue;
    if (!chosen || job->at_work < chosen->at_work) chosen = job;
  }
  return chosen;
}

void Pool::Dispatcher::start(Worker& worker) {
  worker.life = next_life_++;
  stations_[worker.station]->start(worker.place, worker.life);
  worker.state = State::present;
  worker.used = false;
}

void Pool::Dispatcher::load(Worker& worker, std::uint32_t id) {
  Experiment& experiment = experiments_.at(id);
  if (!experiment.reference) experiment.being_tried = true;
  worker.loading = id;
  stations_[worker.station]->send(worker.place, encode(experiment.message));
}

std::size_t Pool::Dispatcher::batch_size(const Job& job) const {
  const double seconds = experiments_.at(job.experiment).task_seconds;
  const auto suspect = [&](std::size_t task) { return job.faults[task] > 0; };
  // A task that has failed before comes alone.
  if (seconds <= 0 || suspect(job.waiting.front())) return 1;
  const std::size_t fair = job.waiting.size() / (2 * workers_.size());
  const double fitting = std::min<double>(largest_batch, std::floor(batch_seconds / seconds));
  const std::size_t count =
      std::max<std::size_t>(1, std::min(static_cast<std::size_t>(fitting), fair));
  const auto end = job.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  return static_cast<std::size_t>(std::find_if(job.waiting.begin(), end, suspect) -
                                  job.waiting.begin());
}

void Pool::Dispatcher::send_batch(Worker& worker, const std::shared_ptr<Job>& job) {
  Writer out;
  out.put(Tag::tasks).put(job->experiment);
  const std::size_t count = batch_size(*job);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t task = job->waiting.front();
    job->waiting.pop_front();
    ++job->at_work;
    worker.items.push_back({next_item_++, job, task, i + 1 == count});
    out.put(worker.items.back().id);
    encode(out, job->tasks[task]);
  }
  ++worker.batches;
  worker.used = true;
  stations_[worker.station]->send(worker.place, out.take());
}

// ---- what happens ------------------------------------------------------------------------------

void Pool::Dispatcher::handle(std::size_t station, const Event& event) {
  const auto who = std::find_if(workers_.begin(), workers_.end(), [&](const Worker& worker) {
    return worker.station == station && worker.place == event.place;
  });
  // Of a process that has been replaced.
  if (who == workers_.end() || who->state != State::present || who->life != event.life) return;
  if (const auto* death = std::get_if<Death>(&event.what)) return died(*who, *death);
  try {
    handle_message(*who, std::get<std::string>(event.what));
  } catch (const WireError& error) {
    stations_[station]->stop(event.place);
    died(*who, {.kind = Death::Kind::fault,
                .cause = error.what(),
                .plugin = {},
                .task = who->items.empty() ? 0 : who->items.front().id});
  }
}

void Pool::Dispatcher::handle_message(Worker& worker, const std::string& message) {
  Reader in(message);
  worker.stillborn = 0;
  switch (in.get<Tag>()) {
    case Tag::results:
      return take_results(worker, in);
    case Tag::ready:
      return ready(worker, decode_ready(in));
    case Tag::not_ready: {
      const auto id = in.get<std::uint32_t>();
      return not_ready(worker, id, std::string(in.text()));
    }
    default:
      throw WireError();
  }
}

void Pool::Dispatcher::take_results(Worker& worker, Reader in) {
  while (!in.done()) {
    const auto id = in.get<std::uint64_t>();
    const auto seconds = in.get<double>();
    busy_seconds_ += seconds;
    Result result = decode_result(in);
    if (worker.items.empty() || worker.items.front().id != id) throw WireError();
    const Item item = worker.items.front();
    worker.items.pop_front();
    if (item.last_of_batch) --worker.batches;
    --item.job->at_work;
    if (const auto found = experiments_.find(item.job->experiment); found != experiments_.end()) {
      double& mean = found->second.task_seconds;
      mean = mean <= 0 ? seconds : 0.9 * mean + 0.1 * seconds;
    }
    if (result.failure)
      fault(item, std::move(*result.failure));
    else
      finish(item, std::move(result));
  }
}

void Pool::Dispatcher::ready(Worker& worker, const ReadyMessage& message) {
  worker.loading.reset();
  const auto found = experiments_.find(message.id);
  if (found == experiments_.end()) {
    // Nobody wants it any more.
    worker.loaded.push_back(message.id);
    to_forget_.push_back(message.id);
    return;
  }
  Experiment& experiment = found->second;
  experiment.losses = 0;
  if (!experiment.reference) {
    experiment.reference = message.hash;
    experiment.being_tried = false;
  }
  if (*experiment.reference == message.hash) {
    worker.loaded.push_back(message.id);
    return;
  }
  refuse(worker, "the reference simulation gives " + message.hash + " instead of " +
                     *experiment.reference + " (" + message.machine + ")");
}

void Pool::Dispatcher::not_ready(Worker& worker, std::uint32_t id, const std::string& why) {
  worker.loading.reset();
  const auto found = experiments_.find(id);
  if (found == experiments_.end()) return;
  Experiment& experiment = found->second;
  if (experiment.reference) return refuse_for(worker, id, why);
  // The reference simulation itself failed: another organism may do.
  experiment.being_tried = false;
  ++experiment.message.canary;
  if (++experiment.failures >= most_canaries)
    fail_all(std::make_exception_ptr(
                 ExperimentFails("no evaluator can simulate this experiment: " + why)),
             id);
}

void Pool::Dispatcher::died_loading(Worker& worker, std::uint32_t id, const Death& death) {
  const auto found = experiments_.find(id);
  if (found == experiments_.end()) return;
  const std::string why = (death.plugin.empty() ? "" : death.plugin + ": ") + death.cause;
  if (death.kind == Death::Kind::fault) return not_ready(worker, id, why);
  found->second.being_tried = false;
  found->second.losses += weight_of(death);
  if (found->second.losses >= most_losses)
    fail_all(lost("evaluators that load the experiment are lost: " + why), id);
}

void Pool::Dispatcher::not_tried(std::uint32_t id) {
  const auto found = experiments_.find(id);
  if (found != experiments_.end()) found->second.being_tried = false;
}

void Pool::Dispatcher::died(Worker& worker, const Death& death) {
  worker.state = State::absent;
  worker.loaded.clear();
  worker.batches = 0;
  std::deque<Item> items;
  items.swap(worker.items);
  const std::optional<std::uint32_t> loading = std::exchange(worker.loading, {});
  for (const Item& item : items) --item.job->at_work;
  const std::string machine = stations_[worker.station]->name();

  // Who has not begun goes to another; back to front, so that the order stays.
  const auto culprit = std::find_if(items.begin(), items.end(),
                                    [&](const Item& item) { return item.id == death.task; });
  for (auto item = items.rbegin(); item != items.rend(); ++item)
    if (culprit == items.end() || item->id != culprit->id) again(*item);
  if (culprit != items.end() && death.kind == Death::Kind::fault)
    fault(*culprit,
          {.attempts = 1, .cause = death.cause, .plugin = death.plugin, .step = death.step});
  else if (culprit != items.end() && death.kind != Death::Kind::spent)
    loss(*culprit, weight_of(death), death.cause,
         (death.plugin.empty() ? "" : " in " + death.plugin) +
             (death.step ? " at step " + std::to_string(*death.step) : "") + " on " + machine);
  else if (culprit != items.end())
    again(*culprit);
  // What it was to load came after what it was to do.
  if (loading && items.empty() && death.kind != Death::Kind::spent)
    died_loading(worker, *loading, death);
  else if (loading)
    not_tried(*loading);
  if (culprit == items.end() && !loading && death.kind != Death::Kind::spent &&
      ++worker.stillborn >= most_losses)
    fail_all(lost("evaluators on " + machine + " end before they work: " + death.cause));
}

void Pool::Dispatcher::refuse(Worker& worker, const std::string& why) {
  const std::string& machine = stations_[worker.station]->name();
  stations_[worker.station]->stop(worker.place);
  for (const Item& item : worker.items) --item.job->at_work;
  for (auto item = worker.items.rbegin(); item != worker.items.rend(); ++item) again(*item);
  worker.items.clear();
  worker.batches = 0;
  worker.loaded.clear();
  worker.state = State::refused;
  last_refusal_ = "an evaluator on " + machine + " is refused: " + why;
  if (warn_) warn_(last_refusal_);
  const bool none = std::all_of(workers_.begin(), workers_.end(),
                                [](const Worker& w) { return w.state == State::refused; });
  if (none) {
    lost_ = last_refusal_ + "; no evaluator is left" + resumable;
    fail_all(all_lost(last_refusal_ + "; no evaluator is left"));
  }
  fail_those_without_evaluator();
}

// Others can load it; this evaluator goes on with other experiments.
void Pool::Dispatcher::refuse_for(Worker& worker, std::uint32_t id, const std::string& why) {
  worker.unable.push_back(id);
  last_refusal_ = "an evaluator on " + stations_[worker.station]->name() + " is refused: " + why;
  if (warn_) warn_(last_refusal_);
  fail_those_without_evaluator();
}

void Pool::Dispatcher::fail_those_without_evaluator() {
  for (const auto& job : jobs_) {
    const bool none = std::all_of(workers_.begin(), workers_.end(), [&](const Worker& worker) {
      return worker.state == State::refused || holds(worker.unable, job->experiment);
    });
    if (none) fail(*job, lost(last_refusal_ + "; no evaluator is left"));
  }
}

// ---- what becomes of tasks ---------------------------------------------------------------------

void Pool::Dispatcher::finish(const Item& item, Result result) {
  Job& job = *item.job;
  if (job.over) return;
  job.results[item.task] = std::move(result);
  --job.left;
  job.finished.push_back(item.task);
  job.news.notify_one();
}

void Pool::Dispatcher::again(const Item& item) {
  if (!item.job->over) item.job->waiting.push_front(item.task);
}

void Pool::Dispatcher::fault(const Item& item, Failure failure) {
  Job& job = *item.job;
  if (job.over) return;
  if (++job.faults[item.task] < most_attempts) {
    again(item);
    return;
  }
  Result result;
  result.rows.resize(job.tasks[item.task].roster.size());
  failure.attempts = job.faults[item.task];
  result.failure = std::move(failure);
  finish(item, std::move(result));
}

void Pool::Dispatcher::loss(const Item& item, std::uint32_t weight, const std::string& cause,
                            const std::string& where) {
  Job& job = *item.job;
  if (job.over) return;
  job.losses[item.task] += weight;
  if (job.losses[item.task] < most_losses) {
    again(item);
    return;
  }
  fail(job, lost("a simulation (seed " + std::to_string(job.tasks[item.task].seed) +
                 ") loses evaluators time and again, the last by: " + cause + where));
}

void Pool::Dispatcher::fail(Job& job, const std::exception_ptr& error) {
  if (job.over) return;
  job.over = true;
  job.error = error;
  job.news.notify_one();
}

void Pool::Dispatcher::fail_all(const std::exception_ptr& error,
                                std::optional<std::uint32_t> experiment) {
  for (const auto& job : jobs_)
    if (!experiment || job->experiment == *experiment) fail(*job, error);
}

}  // namespace somas::evaluation
