#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <cstdlib>
#include <list>
#include <mpi.h>

#include "core/evaluation/mpi/transport.hpp"

namespace somas::evaluation {
namespace {

class MpiTransport final : public Transport {
 public:
  MpiTransport() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    if (provided < MPI_THREAD_SERIALIZED) MPI_Abort(MPI_COMM_WORLD, 1);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }

  void send(int to, std::string message) override {
    Outgoing& outgoing = outgoing_.emplace_back(Outgoing{std::move(message), MPI_REQUEST_NULL});
    MPI_Isend(outgoing.message.data(), static_cast<int>(outgoing.message.size()), MPI_BYTE, to, 0,
              MPI_COMM_WORLD, &outgoing.request);
  }

  [[nodiscard]] bool receive(int& from, std::string& message) override {
    forget_sent();
    int arrived = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &arrived, &handle, &status);
    if (arrived == 0) return false;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    message.resize(static_cast<std::size_t>(size));
    MPI_Mrecv(message.data(), size, MPI_BYTE, &handle, &status);
    from = status.MPI_SOURCE;
    return true;
  }

  void finish() override {
    for (Outgoing& outgoing : outgoing_) MPI_Wait(&outgoing.request, MPI_STATUS_IGNORE);
    outgoing_.clear();
    MPI_Finalize();
  }

  [[noreturn]] void abort(int exit_code) override {
    MPI_Abort(MPI_COMM_WORLD, exit_code);
    std::_Exit(exit_code);
  }

 private:
  struct Outgoing {
    std::string message;
    MPI_Request request;
  };

  void forget_sent() {
    outgoing_.remove_if([](Outgoing& outgoing) {
      int done = 0;
      MPI_Test(&outgoing.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
  }

  int rank_ = 0, size_ = 1;
  std::list<Outgoing> outgoing_;
};

}  // namespace
}  // namespace somas::evaluation

extern "C" [[gnu::visibility("default")]] somas::evaluation::Transport* somas_mpi_transport() {
  return new somas::evaluation::MpiTransport;
}
