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

}  // namespace

SignalGuard::SignalGuard() {
  stop_requested = false;
  signal_received = 0;
  // After the first one the default action is back, so that a second one kills.
  const int flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU})
    install(number, remember_signal, flags);
  for (const int number : {SIGPIPE, SIGXFSZ}) install(number, SIG_IGN, 0);
}

SignalGuard::~SignalGuard() {
  for (const Installed& one : installed_) ::sigaction(one.number, &one.before, nullptr);
}

void SignalGuard::install(int number, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  Installed one{number, {}};
  ::sigaction(number, &action, &one.before);
  // What nohup has set aside stays so.
  if (number == SIGHUP && one.before.sa_handler == SIG_IGN)
    ::sigaction(number, &one.before, nullptr);
  installed_.push_back(one);
}

evaluation::StopToken SignalGuard::token() const { return evaluation::StopToken(stop_requested); }

int SignalGuard::received() { return signal_received; }

}  // namespace somas::run
