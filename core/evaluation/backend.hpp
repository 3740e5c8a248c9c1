// Where the work of a whole command is done. Its runs, however many, share it.
#pragma once

#include <memory>
#include <string>

#include "core/evaluation/evaluator.hpp"
#include "core/experiment/experiment.hpp"
#include "core/model/profile.hpp"
#include "core/model/team.hpp"

namespace somas::evaluation {

class Backend {
 public:
  virtual ~Backend() = default;
  /// Evaluates tasks of one experiment, which must outlive it, as must this. May be called, and
  /// what it gives used, by several threads at a time.
  [[nodiscard]] virtual std::unique_ptr<Evaluator> evaluator(
      const experiment::Experiment& experiment) = 0;
  /// Simulations at a time.
  [[nodiscard]] virtual unsigned workers() const = 0;
  /// Time that they spent on simulations so far, summed. From any thread.
  [[nodiscard]] virtual double busy_seconds() const = 0;
  /// Threads that share the steps of a large world, of each simulation.
  [[nodiscard]] virtual unsigned world_threads() const = 0;
  /// "2 threads", "4 evaluator processes".
  [[nodiscard]] virtual std::string description() const = 0;
};

/// Threads of this process: nothing protects it from plugins that crash. workers = 0: with the
/// threads of their worlds one per processor. What all simulations take is added to `profile`,
/// which may be null and is complete between two evaluations.
[[nodiscard]] std::unique_ptr<Backend> thread_backend(unsigned workers = 0,
                                                      model::Profile* profile = nullptr,
                                                      model::WorldThreads world = {});

}  // namespace somas::evaluation
