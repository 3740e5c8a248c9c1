#include "core/evaluation/crash_report.hpp"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace somas::evaluation {
namespace {

constexpr int crashes[] = {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS};
constexpr std::size_t stack_size = std::size_t{1} << 16;

int exit_code_of_crash = 3;
/// Where the present thread's crash is noted; null: nowhere.
thread_local const char* crash_note = nullptr;
/// What to start then; null: nothing.
std::atomic<char* const*> restart_arguments = nullptr;
static_assert(std::atomic<char* const*>::is_always_lock_free);

/// A line put together without anything that a signal handler must not call.
class Line {
 public:
  Line& add(const char* text) {
    for (; *text != 0 && size_ < sizeof text_; ++text) text_[size_++] = *text;
    return *this;
  }
  Line& add(std::uint64_t number) {
    char digits[21] = "";
    char* first = digits + 20;
    do *--first = static_cast<char>('0' + number % 10);
    while ((number /= 10) != 0);
    return add(first);
  }
  void write(int file) const { static_cast<void>(!::write(file, text_, size_)); }

 private:
  char text_[512];
  std::size_t size_ = 0;
};

extern "C" void report_crash(int signal) {
  const model::CallSite* site = model::watched_site;
  // Not in a plugin: the default action, which SA_RESETHAND has brought back, comes next.
  if (site == nullptr || site->instance[0] == 0) {
    ::raise(signal);
    return;
  }
  Line line;
  line.add("SIG").add(::sigabbrev_np(signal)).add(" in ").add(site->instance);
  line.add(": ").add(site->call);
  if (site->step != model::CallSite::no_step) line.add(" at step ").add(site->step);
  line.add(": the plugin crashed; what was finished before is saved\n");
  Line().add("\nsomas-host: ").write(STDERR_FILENO);
  line.write(STDERR_FILENO);
  if (crash_note == nullptr) ::_exit(exit_code_of_crash);
  if (const int file = ::open(crash_note, O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
      file >= 0) {
    line.write(file);
    if (char* const* arguments = restart_arguments) ::execv("/proc/self/exe", arguments);
  }
  ::_exit(exit_code_of_crash);
}

}  // namespace

void report_crashes(int exit_code) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  // Sanitizers tell more.
  static_cast<void>(exit_code);
#else
  exit_code_of_crash = exit_code;
  struct sigaction action {};
  action.sa_handler = report_crash;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_ONSTACK | SA_NODEFER;
  sigemptyset(&action.sa_mask);
  for (const int signal : crashes) ::sigaction(signal, &action, nullptr);
#endif
}

RestartAfterCrash::RestartAfterCrash(std::vector<std::string> words) : words_(std::move(words)) {
  if (words_.empty()) return;
  words_.insert(words_.begin(), "somas-host");
  for (std::string& word : words_) arguments_.push_back(word.data());
  arguments_.push_back(nullptr);
  restart_arguments = arguments_.data();
}

RestartAfterCrash::~RestartAfterCrash() { restart_arguments = nullptr; }

WatchedThread::WatchedThread(const std::filesystem::path& note)
    : outer_(std::exchange(model::watched_site, &site_)),
      note_(note.string()),
      outer_note_(std::exchange(crash_note, note_.empty() ? nullptr : note_.c_str())) {
  stack_t present{};
  if (::sigaltstack(nullptr, &present) != 0 || (present.ss_flags & SS_DISABLE) == 0) return;
  stack_ = std::make_unique<char[]>(stack_size);
  const stack_t own{.ss_sp = stack_.get(), .ss_flags = 0, .ss_size = stack_size};
  ::sigaltstack(&own, nullptr);
}

WatchedThread::~WatchedThread() {
  model::watched_site = outer_;
  crash_note = outer_note_;
  if (!stack_) return;
  const stack_t none{.ss_sp = nullptr, .ss_flags = SS_DISABLE, .ss_size = 0};
  ::sigaltstack(&none, nullptr);
}

}  // namespace somas::evaluation
