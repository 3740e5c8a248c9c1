// A pool of evaluator processes, shared by all runs of a command.
//
// A thread of its own, asleep unless something happens, hands out tasks: to each evaluator the one
// that it works on and, while there are plenty, one more to go on with; costliest first; small ones
// several at a time. A task whose plugin throws or crashes is tried again in a fresh process and,
// after `most_attempts`, set aside. An evaluator that is killed, runs out of memory or makes no
// progress says nothing about its task: it is tried again, but not for ever.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/evaluation/backend.hpp"
#include "core/evaluation/station.hpp"

namespace somas::evaluation {

struct PoolOptions {
  unsigned workers = 0;           ///< on this machine; 0: with their threads one per processor
  std::uint64_t memory_mib = 0;   ///< limit of an evaluator's data; 0: none
  double watchdog_seconds = 600;  ///< without a step of the simulation, until it is killed
  unsigned world_threads = 1;     ///< of an evaluator, that share a large world
  std::filesystem::path program = "/proc/self/exe";  ///< understands `evaluator_command`
  /// What a person should know (an evaluator refused or lost); may be called by any thread.
  std::function<void(const std::string&)> warn{};
};

/// Makes the stations that a pool directs; called by the thread that uses them.
using StationMaker = std::function<std::vector<std::unique_ptr<Station>>()>;

class Pool final : public Backend {
 public:
  /// Evaluators of this machine. Processes start with the first task.
  explicit Pool(const PoolOptions& options);
  /// Evaluators of several machines; the first station is the coordinator's and sets the reference.
  Pool(std::vector<std::string> names, std::vector<std::size_t> places, StationMaker make_stations,
       std::function<void(const std::string&)> warn, unsigned world_threads = 1);
  /// Kills the evaluators. No evaluation may be running.
  ~Pool() override;
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  [[nodiscard]] std::unique_ptr<Evaluator> evaluator(
      const experiment::Experiment& experiment) override;
  [[nodiscard]] unsigned workers() const override;
  [[nodiscard]] double busy_seconds() const override;
  [[nodiscard]] unsigned world_threads() const override { return world_threads_; }
  [[nodiscard]] std::string description() const override;

  class Dispatcher;

 private:
  std::unique_ptr<Dispatcher> dispatcher_;
  std::string description_;
  unsigned world_threads_;
};

}  // namespace somas::evaluation
