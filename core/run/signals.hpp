// Ctrl-C and friends as a request to stop.
#pragma once

#include <csignal>

#include "core/evaluation/stop.hpp"

namespace somas::run {

/// While it lives, the first SIGINT, SIGTERM or SIGHUP asks the run to stop, and a second one
/// kills at once; a SIGHUP that nohup has set aside stays so; a closed pipe or an exceeded file
/// size limit is reported by the call that met it, not by a signal. At most one at a time.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  [[nodiscard]] evaluation::StopToken token() const;
  /// SIGINT, SIGTERM, SIGHUP, or 0 if none came.
  [[nodiscard]] static int received();

 private:
  struct sigaction interrupt_ {
  }, terminate_{}, hang_up_{}, pipe_{}, size_{};
};

}  // namespace somas::run
