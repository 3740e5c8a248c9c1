// How far a campaign is, for people: one line for all of its runs.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/run/terminal.hpp"
#include "core/run/watcher.hpp"

namespace somas::run {

struct CampaignStanding {
  std::uint64_t runs = 0, done = 0, failed = 0, active = 0;  ///< done: failed ones, too
  double share = 0;                                          ///< of all evaluations
  double rate = 0;                                           ///< evaluations a second
  std::optional<double> seconds_left;
};

/// As much as fits into so many columns.
[[nodiscard]] std::string text_within(const CampaignStanding& standing, std::size_t columns);
/// In whole words, without a bar.
[[nodiscard]] std::string long_text(const CampaignStanding& standing);

class CampaignProgress {
 public:
  struct Work {
    std::uint64_t generations = 0, evaluations = 0;  ///< of a run; of a generation
    std::uint64_t finished = 0;                      ///< generations, before we came
  };
  /// Work by run.
  CampaignProgress(Terminal& terminal, const std::vector<Work>& runs);
  ~CampaignProgress();
  CampaignProgress(const CampaignProgress&) = delete;
  CampaignProgress& operator=(const CampaignProgress&) = delete;

  /// What the run tells, by a thread of its own. All other calls: by one thread at a time.
  [[nodiscard]] Watcher& watcher(std::size_t run);
  /// The run has failed: nobody waits for the rest of it.
  void give_up(std::size_t run);
  /// Several times a second: redraws the line of a terminal; elsewhere prints a
  /// line now and then.
  void update(std::uint64_t done, std::uint64_t failed, std::uint64_t active);
  /// A run has ended: elsewhere than on a terminal, a line with what to say of it.
  void ended(const std::string& text, std::uint64_t done, std::uint64_t failed,
             std::uint64_t active);

 private:
  using Clock = std::chrono::steady_clock;

  /// Counts the evaluations of one run.
  class Counter final : public Watcher {
   public:
    explicit Counter(const Work& work) : work_(work), done_(work.finished * work.evaluations) {}
    void begin_generation(std::uint64_t generation) override;
    void update(std::uint64_t done) override;
    void end_generation(const evolution::Statistics& statistics) override;
    [[nodiscard]] std::uint64_t done() const { return done_; }
    [[nodiscard]] std::uint64_t left() const {
      return work_.generations * work_.evaluations - done_;
    }

   private:
    Work work_;
    std::uint64_t before_ = 0;  ///< evaluations of the generations before this one
    std::atomic<std::uint64_t> done_;
  };

  [[nodiscard]] CampaignStanding standing(std::uint64_t done, std::uint64_t failed,
                                          std::uint64_t active);
  [[nodiscard]] std::uint64_t evaluations_done() const;

  Terminal& terminal_;
  std::vector<std::unique_ptr<Counter>> counters_;
  std::uint64_t planned_ = 0;
  std::deque<std::pair<Clock::time_point, std::uint64_t>> recent_;  ///< evaluations done, by time
  Clock::time_point shown_;
};

}  // namespace somas::run
