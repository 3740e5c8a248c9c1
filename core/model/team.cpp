#include "core/model/team.hpp"

#include <algorithm>
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

/// In a ticket: the work is being changed.
constexpr std::uint32_t no_part = 0xFFFFFFFFu;

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
    : least_(std::max(least, 1u)),
      threads_(std::max(threads, 1u)),
      awake_(threads <= std::thread::hardware_concurrency()),
      errors_(most_pieces()),
      lanes_(threads_) {}

Team::~Team() {
  over_ = true;
  works_.fetch_add(1, std::memory_order_release);
  works_.notify_all();
  for (std::thread& other : others_) other.join();
}

void Team::start() {
  started_ = true;
  others_.reserve(threads() - 1);
  try {
    while (others_.size() < threads() - 1) {
      const auto thread = static_cast<unsigned>(others_.size()) + 1;
      others_.emplace_back([this, thread] { serve(thread); });
    }
  } catch (const std::system_error&) {
    // The system gives no more: those that it gave take all parts.
  }
}

void Team::carry_out(Call call, void* context, unsigned parts) {
  if (!started_) start();
  // First nobody can take parts any more by the ticket of the work before: who reads what follows
  // has then seen that.
  const std::uint64_t number = works_.load(std::memory_order_relaxed) + std::uint64_t{1};
  for (Lane& lane : lanes_) lane.ticket.store(number << 32 | no_part, std::memory_order_release);
  call_.store(call, std::memory_order_release);
  context_.store(context, std::memory_order_release);
  site_.store(watched_site, std::memory_order_release);
  left_.store(parts, std::memory_order_release);
  unsigned next = 1;  // the first part is taken
  for (unsigned thread = 0; thread < threads_; ++thread) {
    const unsigned end = (parts * (thread + 1) + threads_ - 1) / threads_;
    lanes_[thread].end.store(end, std::memory_order_release);
    lanes_[thread].ticket.store(number << 32 | next, std::memory_order_release);
    next = end;
  }
  // Sequentially consistent: notifying looks for sleepers, and must not do so before.
  works_.store(static_cast<std::uint32_t>(number));
  if (parts >= threads_) {
    works_.notify_all();
  } else {
    for (unsigned other = 1; other < parts; ++other) works_.notify_one();
  }

  finish(0, call, context);
  help(0);
  for (std::uint32_t left = left_.load(std::memory_order_acquire); left != 0;
       left = left_.load(std::memory_order_acquire))
    await_change(left_, left, awake_);
  throw_on(parts);
}

void Team::serve(unsigned thread) {
  const ReportStack stack;
  for (std::uint32_t done = 0;;) {
    await_change(works_, done, awake_);
    // In this order: the end comes with a number of its own, which must not be taken for a work's.
    done = works_.load(std::memory_order_acquire);
    if (over_) return;
    help(thread);
  }
}

/// Takes parts until there are none, those of its own lane first.
void Team::help(unsigned thread) {
  for (unsigned k = 0; k < threads_; ++k) help_with((thread + k) % threads_);
}

void Team::help_with(unsigned lane) {
  // What is read of a work that has meanwhile ended is not used.
  std::atomic<std::uint64_t>& next = lanes_[lane].ticket;
  std::uint64_t ticket = next.load(std::memory_order_acquire);
  for (;;) {
    const Call call = call_.load(std::memory_order_acquire);
    void* const context = context_.load(std::memory_order_acquire);
    CallSite* const site = site_.load(std::memory_order_acquire);
    const auto part = static_cast<std::uint32_t>(ticket);
    if (part >= lanes_[lane].end.load(std::memory_order_acquire)) return;
    if (!next.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) continue;
    CallSite* const outer = std::exchange(watched_site, site);
    finish(part, call, context);
    watched_site = outer;
    ++ticket;
  }
}

void Team::finish(unsigned part, Call call, void* context) {
  try {
    call(context, part);
  } catch (...) {
    errors_[part] = std::current_exception();
  }
  if (left_.fetch_sub(1, std::memory_order_acq_rel) == 1) left_.notify_one();
}

void Team::throw_on(unsigned parts) {
  const auto thrown = std::span(errors_).first(parts);
  const auto lowest =
      std::find_if(thrown.begin(), thrown.end(),
                   [](const std::exception_ptr& error) { return error != nullptr; });
  if (lowest == thrown.end()) return;
  const std::exception_ptr error = *lowest;
  std::fill(thrown.begin(), thrown.end(), nullptr);
  std::rethrow_exception(error);
}

}  // namespace somas::model
