// The mind of a pool: who works on what, and what becomes of those who die over it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/evaluation/pool.hpp"
#include "core/evaluation/wire.hpp"

namespace somas::evaluation {

/// One call of `evaluate`. Guarded by the dispatcher's mutex.
struct Job {
  Job(std::uint32_t the_experiment, std::span<const Task> the_tasks);

  std::uint32_t experiment;
  std::span<const Task> tasks;      ///< of the caller, who waits
  std::deque<std::size_t> waiting;  ///< indices, the next first
  std::vector<Result> results;
  std::vector<std::uint32_t> faults, losses;  ///< by task: what attempts ended in
  std::size_t left;                           ///< tasks without a result
  std::size_t at_work = 0;                    ///< tasks with an evaluator
  std::vector<std::size_t> finished;          ///< and not handed on yet
  std::exception_ptr error;
  bool over = false;  ///< cancelled or failed: nobody wants results any more
  std::condition_variable news;
};

class Pool::Dispatcher {
 public:
  Dispatcher(std::vector<std::size_t> places, StationMaker make_stations,
             std::function<void(const std::string&)> warn);
  ~Dispatcher();
  Dispatcher(const Dispatcher&) = delete;
  Dispatcher& operator=(const Dispatcher&) = delete;

  [[nodiscard]] std::uint32_t enter(const experiment::Experiment& experiment);
  void leave(std::uint32_t experiment);
  [[nodiscard]] std::optional<std::vector<Result>> evaluate(std::uint32_t experiment,
                                                            std::span<const Task> tasks,
                                                            StopToken stop,
                                                            const ResultCallback& finished);
  [[nodiscard]] std::optional<Reference> reference(std::uint32_t experiment) const;
  void expect(std::uint32_t experiment, const Reference& reference);
  [[nodiscard]] std::size_t workers() const { return workers_.size(); }
  [[nodiscard]] double busy_seconds() const { return busy_seconds_; }

 private:
  struct Experiment {
    ExperimentMessage message;
    std::optional<std::string> reference;  ///< hash of the canary, as the first evaluator found it
    bool being_tried = false;              ///< by that first one
    std::uint32_t failures = 0;            ///< canaries that crashed or threw, before that
    std::uint32_t losses = 0;              ///< evaluators lost while they loaded it
    double task_seconds = 0;               ///< recent mean; 0: not known
  };
  struct Item {
    std::uint64_t id = 0;
    std::shared_ptr<Job> job;
    std::size_t task = 0;
    bool last_of_batch = false;
  };
  enum class State : std::uint8_t { absent, present, refused };
  struct Worker {
    std::size_t station = 0, place = 0;
    State state = State::absent;
    std::uint64_t life = 0;
    bool used = false;                  ///< has got tasks
    std::vector<std::uint32_t> loaded;  ///< experiments
    std::vector<std::uint32_t> unable;  ///< experiments that it cannot load
    std::optional<std::uint32_t> loading{};
    std::deque<Item> items{};     ///< sent, in order
    std::size_t batches = 0;      ///< of them
    std::uint32_t stillborn = 0;  ///< times that it died before it did anything
  };

  void run(const StationMaker& make_stations);
  void wake() const;
  void wait();
  void hand_out();
  bool serve(Worker& worker);
  [[nodiscard]] std::shared_ptr<Job> choose(const Worker& worker) const;
  void start(Worker& worker);
  void load(Worker& worker, std::uint32_t experiment);
  void send_batch(Worker& worker, const std::shared_ptr<Job>& job);
  [[nodiscard]] std::size_t batch_size(const Job& job) const;

  void handle(std::size_t station, const Event& event);
  void handle_message(Worker& worker, const std::string& message);
  void take_results(Worker& worker, Reader in);
  void ready(Worker& worker, const ReadyMessage& message);
  void not_ready(Worker& worker, std::uint32_t experiment, const std::string& why);
  void not_tried(std::uint32_t experiment);
  void died(Worker& worker, const Death& death);
  void died_loading(Worker& worker, std::uint32_t experiment, const Death& death);
  void refuse(Worker& worker, const std::string& why);
  void refuse_for(Worker& worker, std::uint32_t experiment, const std::string& why);
  void fail_those_without_evaluator();

  void finish(const Item& item, Result result);
  void again(const Item& item);
  void fault(const Item& item, Failure failure);
  void loss(const Item& item, std::uint32_t weight, const std::string& cause,
            const std::string& where);
  static void fail(Job& job, const std::exception_ptr& error);
  void fail_all(const std::exception_ptr& error, std::optional<std::uint32_t> experiment = {});

  std::function<void(const std::string&)> warn_;
  mutable std::mutex mutex_;
  std::map<std::uint32_t, Experiment> experiments_;
  std::vector<std::shared_ptr<Job>> jobs_;
  std::vector<Worker> workers_;
  std::uint32_t next_experiment_ = 1;
  std::uint64_t next_item_ = 1, next_life_ = 1;
  std::string last_refusal_;
  std::optional<std::string> lost_;  ///< why no work can be done any more
  bool ending_ = false;
  std::atomic<double> busy_seconds_ = 0;  ///< as evaluators measured them

  std::vector<std::unique_ptr<Station>> stations_;  ///< of the thread alone
  std::vector<std::uint32_t> to_forget_;
  int wake_ = -1;  ///< an eventfd
  std::jthread thread_;
};

}  // namespace somas::evaluation
