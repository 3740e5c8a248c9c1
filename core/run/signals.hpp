// Ctrl-C and friends as a request to stop.
#pragma once

#include <csignal>
#include <vector>

#include "core/evaluation/stop.hpp"

namespace somas::run {

/// While it lives, the first SIGINT, SIGTERM, SIGHUP, or one of those that schedulers send before a
/// time limit (SIGUSR1, SIGUSR2, SIGXCPU), asks the run to stop, and the same once more kills at
/// once; a SIGHUP that nohup has set aside stays so; a closed pipe or an exceeded file size limit
/// is reported by the call that met it, not by a signal. At most one at a time.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  [[nodiscard]] evaluation::StopToken token() const;
  /// The signal that asked, or 0 if none came.
  [[nodiscard]] static int received();

 private:
  struct Installed {
    int number = 0;
    struct sigaction before {};
  };
  void install(int number, void (*handler)(int), int flags);

  std::vector<Installed> installed_;
};

}  // namespace somas::run
