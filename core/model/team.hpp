// Threads that share the steps of one large world.
//
// What is shared is cut by place alone, and whatever hangs on an order is added up by one thread in
// that order: how many threads there are never reaches the results.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <thread>
#include <type_traits>
#include <vector>

#include "core/model/call_site.hpp"

namespace somas::model {

/// Cells below which a thread is not worth waking: what they take in a phase of the step is about
/// what it takes to hand work over and to wait for its end (docs/benchmarks.md).
inline constexpr std::uint32_t cells_worth_a_thread = 1000;

/// How many threads, the calling one among them, share a world, and how many cells each gets at
/// least.
struct WorldThreads {
  unsigned threads = 1;
  std::uint32_t least = cells_worth_a_thread;
};

class Team {
 public:
  /// At least one thread, the caller's. The others start with the first work that is shared; where
  /// the system refuses some, fewer share it.
  explicit Team(unsigned threads, std::uint32_t least = cells_worth_a_thread);
  explicit Team(WorldThreads of) : Team(of.threads, of.least) {}
  /// No work may be running.
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] unsigned threads() const { return threads_; }
  /// How many parts work is cut into that is worth that of so many cells, one for each thread that
  /// it is worth: 1 to threads().
  [[nodiscard]] unsigned parts(std::uint64_t cells) const {
    return static_cast<unsigned>(std::clamp<std::uint64_t>(cells / least_, 1, threads_));
  }
  /// The same of work that may be cut as one likes: where there is enough, several for each thread,
  /// as many for all, so that a slower one takes fewer. At most most_pieces().
  [[nodiscard]] unsigned pieces(std::uint64_t cells) const {
    const std::uint64_t worth = cells / least_;
    if (worth < threads_) return parts(cells);
    return static_cast<unsigned>(std::min<std::uint64_t>(worth - worth % threads_, most_pieces()));
  }
  [[nodiscard]] unsigned most_pieces() const { return threads_ == 1 ? 1 : 8 * threads_; }

  /// Calls work(part) for each part below `parts`, at most most_pieces(), and ends when all have
  /// ended.
  /// Each thread begins with parts of its own, the same ones each time, whose data it may still
  /// have in its caches, and goes on to those that nobody has begun; the calling one has the first:
  /// where the machine has no processor for the team, it does all. Of what parts throw, the
  /// exception of the lowest is thrown on. Crashes are noted where the caller's are. By one thread
  /// at a time, and never from within; allocates nothing once the threads have started.
  template <class Work>
  void run(unsigned parts, Work& work) {
    carry_out([](void* context, unsigned part) { (*static_cast<Work*>(context))(part); },
              const_cast<std::remove_const_t<Work>*>(&work), parts);
  }

 private:
  using Call = void (*)(void* context, unsigned part);

  void carry_out(Call call, void* context, unsigned parts);
  void start();
  void serve(unsigned thread);
  void help(unsigned thread);
  void help_with(unsigned lane);
  void finish(unsigned part, Call call, void* context);
  void throw_on(unsigned parts);

  std::uint32_t least_;
  unsigned threads_;
  bool awake_;  ///< whoever waits, for a little while: there is a processor for everybody
  bool started_ = false;
  std::vector<std::exception_ptr> errors_;  ///< by part
  std::vector<std::thread> others_;

  // The present work. Whoever takes a part by the ticket has read what it belongs to: it changes
  // when all parts have ended only, and while it does the ticket is for no part.
  std::atomic<Call> call_ = nullptr;
  std::atomic<void*> context_ = nullptr;
  std::atomic<CallSite*> site_ = nullptr;
  std::atomic<bool> over_ = false;
  /// The parts of a thread.
  struct alignas(64) Lane {
    std::atomic<std::uint64_t> ticket = 0;  ///< number of the work, then the next part
    std::atomic<unsigned> end = 0;
  };
  std::vector<Lane> lanes_;
  alignas(64) std::atomic<std::uint32_t> works_ = 0;  ///< so far: what the others wait for
  alignas(64) std::atomic<std::uint32_t> left_ = 0;   ///< parts that have not ended
};

/// A part of [0, count).
struct Stretch {
  std::uint32_t begin = 0, end = 0;
};

/// The part-th of `parts` parts, as equal as can be.
[[nodiscard]] inline Stretch stretch(std::uint32_t count, unsigned part, unsigned parts) {
  const auto bound = [&](std::uint64_t p) { return static_cast<std::uint32_t>(count * p / parts); };
  return {bound(part), bound(std::uint64_t{part} + 1)};
}

/// Calls work(begin, end) for parts that make up [0, count), at once; without a team (null), or
/// when it does not pay, for the whole by the calling thread. It is as much work as that of `cells`
/// cells in a phase of the step.
template <class Work>
void share(Team* team, std::uint32_t count, std::uint64_t cells, const Work& work) {
  const unsigned parts = team == nullptr ? 1 : team->pieces(cells);
  if (parts == 1) {
    work(std::uint32_t{0}, count);
    return;
  }
  const auto part_of = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    work(own.begin, own.end);
  };
  team->run(parts, part_of);
}
template <class Work>
void share(Team* team, std::uint32_t count, const Work& work) {
  share(team, count, count, work);
}

}  // namespace somas::model
