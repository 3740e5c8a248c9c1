#include "core/model/team.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <span>
#include <system_error>
#include <utility>

namespace somas::model {

namespace {

/// Phases follow one another closely: whoever waits a little finds work without a call to the
/// system. Plugins and other simulations may take longer: then it sleeps.
constexpr std::chrono::microseconds longest_wait{50};

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Until it is another than `old`; awake at first, if so.
void await_change(const std::atomic<std::uint32_t>& value, std::uint32_t old, bool awake) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + (awake ? longest_wait : longest_wait.zero());
  do
    for (int i = 0; i < 32; ++i) {
      if (value.load(std::memory_order_acquire) != old) return;
      pause();
    }
  while (Clock::now() < end);
  value.wait(old, std::memory_order_acquire);
}

/// For the report of a crash, which may be that the thread's own stack is full.
class ReportStack {
 public:
  ReportStack() {
    const stack_t own{.ss_sp = bytes_.data(), .ss_flags = 0, .ss_size = bytes_.size()};
    ::sigaltstack(&own, nullptr);
  }
  ~ReportStack() {
    const stack_t none{.ss_sp = nullptr, .ss_flags = SS_DISABLE, .ss_size = 0};
    ::sigaltstack(&none, nullptr);
  }
  ReportStack(const ReportStack&) = delete;
  ReportStack& operator=(const ReportStack&) = delete;

 private:
  std::array<char, std::size_t{1} << 16> bytes_;
};

}  // namespace

Team::Team(unsigned threads, std::uint32_t least)
    : threads_(std::max(threads, 1u)),
      least_(std::max(least, 1u)),
      awake_(threads_ <= std::thread::hardware_concurrency()),
      members_(threads_) {}

Team::~Team() {
  over_ = true;
  for (Member& member : members_) {
    if (!member.thread.joinable()) continue;
    member.calls.fetch_add(1, std::memory_order_release);
    member.calls.notify_one();
    member.thread.join();
  }
}

void Team::start() {
  started_ = true;
  try {
    for (unsigned m = 1; m < threads_; ++m)
      members_[m].thread = std::thread([this, m] { serve(m); });
  } catch (const std::system_error&) {
    // The system gives no more: those that it gave take all parts.
    threads_ = 1;
    while (threads_ < members_.size() && members_[threads_].thread.joinable()) ++threads_;
  }
}

void Team::call(const Job& job) {
  if (!started_) start();
  job_ = job;
  site_ = watched_site;
  const unsigned called = std::min(job.parts, threads_);
  at_work_.store(called - 1, std::memory_order_relaxed);
  for (unsigned m = 1; m < called; ++m) {
    members_[m].calls.fetch_add(1, std::memory_order_release);
    members_[m].calls.notify_one();
  }
  take_part(0);
  for (std::uint32_t left = at_work_.load(std::memory_order_acquire); left != 0;
       left = at_work_.load(std::memory_order_acquire))
    await_change(at_work_, left, awake_);
  throw_on(called);
}

void Team::serve(unsigned member) {
  const ReportStack stack;
  Member& own = members_[member];
  for (std::uint32_t done = 0;; ++done) {
    await_change(own.calls, done, awake_);
    if (over_) return;
    watched_site = site_;
    take_part(member);
    watched_site = nullptr;
    if (at_work_.fetch_sub(1, std::memory_order_acq_rel) == 1) at_work_.notify_one();
  }
}

void Team::take_part(unsigned member) {
  // Where the system gave fewer threads than there are parts, each takes several.
  unsigned part = member;
  try {
    for (; part < job_.parts; part += threads_) job_.call(job_.context, part);
  } catch (...) {
    members_[member].failed = part;
    members_[member].error = std::current_exception();
  }
}

void Team::throw_on(unsigned called) {
  const Member* lowest = nullptr;
  for (const Member& member : std::span(members_).first(called))
    if (member.error && (lowest == nullptr || member.failed < lowest->failed)) lowest = &member;
  if (lowest == nullptr) return;
  const std::exception_ptr error = lowest->error;
  for (Member& member : members_) member.error = nullptr;
  std::rethrow_exception(error);
}

}  // namespace somas::model
