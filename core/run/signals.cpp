#include "core/run/signals.hpp"

#include <atomic>

namespace somas::run {
namespace {

std::atomic<bool> stop_requested{false};
std::atomic<int> signal_received{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

extern "C" void remember_signal(int number) {
  signal_received = number;
  stop_requested = true;
}

void install(int number, void (*handler)(int), int flags, struct sigaction& old) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  ::sigaction(number, &action, &old);
}

}  // namespace

SignalGuard::SignalGuard() {
  stop_requested = false;
  signal_received = 0;
  // After the first one the default action is back, so that a second one kills.
  const int flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  install(SIGINT, remember_signal, flags, interrupt_);
  install(SIGTERM, remember_signal, flags, terminate_);
  install(SIGHUP, remember_signal, flags, hang_up_);
  if (hang_up_.sa_handler == SIG_IGN) ::sigaction(SIGHUP, &hang_up_, nullptr);
  install(SIGPIPE, SIG_IGN, 0, pipe_);
  install(SIGXFSZ, SIG_IGN, 0, size_);
}

SignalGuard::~SignalGuard() {
  ::sigaction(SIGINT, &interrupt_, nullptr);
  ::sigaction(SIGTERM, &terminate_, nullptr);
  ::sigaction(SIGHUP, &hang_up_, nullptr);
  ::sigaction(SIGPIPE, &pipe_, nullptr);
  ::sigaction(SIGXFSZ, &size_, nullptr);
}

evaluation::StopToken SignalGuard::token() const { return evaluation::StopToken(stop_requested); }

int SignalGuard::received() { return signal_received; }

}  // namespace somas::run
