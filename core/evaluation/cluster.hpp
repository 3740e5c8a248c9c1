// The ranks of a job that a launcher (mpirun, srun) started. Rank 0 coordinates; the others load no
// plugin and supervise evaluator processes of their machines, which rank 0 directs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/evaluation/mpi/transport.hpp"
#include "core/evaluation/pool.hpp"

namespace somas::evaluation {

class Cluster {
 public:
  /// Whether the environment says that a launcher started this process.
  [[nodiscard]] static bool launched();
  /// This process's rank, as the environment says: for messages while there is no MPI.
  [[nodiscard]] static int expected_rank();

  /// Joins the others. Throws std::runtime_error, saying why, where MPI cannot be loaded.
  Cluster();
  ~Cluster();
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  /// The one of this process; null: there is none.
  [[nodiscard]] static Cluster* present();
  [[nodiscard]] int rank() const;
  [[nodiscard]] int size() const;

  /// The work of all ranks but the first, until that says that it is over.
  void supervise();

  /// Rank 0: evaluators of all ranks, as many of each as `options` says; 0: as the rank sees fit.
  /// Throws EvaluatorsLost if a rank does not answer. One at a time.
  [[nodiscard]] std::unique_ptr<Backend> backend(const PoolOptions& options);
  /// Rank 0: lets the others go; where one is lost, ends them all.
  void end(int exit_code);

  class Mail;

 private:
  void meet_ranks();

  Transport* transport_;
  std::shared_ptr<Mail> mail_;
  std::vector<std::string> names_;       ///< of the ranks' machines, once they have said so
  std::vector<std::size_t> processors_;  ///< that they may use
};

}  // namespace somas::evaluation
