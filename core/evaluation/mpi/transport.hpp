// Messages between the ranks of a job. What is behind it is a library of its own, loaded only into
// ranks that a launcher started, so that the host itself needs no MPI.
#pragma once

#include <string>

namespace somas::evaluation {

/// May be used by several threads, but by one at a time. Nothing blocks but `finish`.
class Transport {
 public:
  virtual ~Transport() = default;
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  virtual void send(int to, std::string message) = 0;
  /// False if nothing has arrived.
  [[nodiscard]] virtual bool receive(int& from, std::string& message) = 0;
  /// Waits until all has been sent and all ranks have come here.
  virtual void finish() = 0;
  /// Ends all ranks at once.
  [[noreturn]] virtual void abort(int exit_code) = 0;
};

inline constexpr const char* transport_entry = "somas_mpi_transport";
using TransportEntry = Transport*();  ///< once a process; the result lives for ever

}  // namespace somas::evaluation
