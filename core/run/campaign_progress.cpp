#include "core/run/campaign_progress.hpp"

#include <algorithm>
#include <cstdio>

#include "core/run/progress.hpp"

namespace somas::run {
namespace {

constexpr std::chrono::milliseconds redraw{200};
constexpr std::chrono::seconds heartbeat{30};
constexpr std::chrono::seconds window{60};  ///< of which the rate is
constexpr std::chrono::seconds grain{1};

std::string counts_text(const CampaignStanding& standing) {
  std::string text =
      std::to_string(standing.done) + " of " + std::to_string(standing.runs) + " runs done";
  if (standing.failed > 0) text += ", " + std::to_string(standing.failed) + " failed";
  return text;
}

std::string pace_text(const CampaignStanding& standing, const char* unit) {
  char rate[32];
  std::snprintf(rate, sizeof rate, standing.rate < 10 ? "%.1f" : "%.0f", standing.rate);
  std::string text = std::string(rate) + unit;
  if (standing.seconds_left) text += ", " + duration_text(*standing.seconds_left) + " left";
  return text;
}

std::string bar(double share, std::size_t cells) {
  std::string text(cells + 2, '.');
  std::fill_n(text.begin() + 1, static_cast<std::size_t>(share * static_cast<double>(cells)), '#');
  text.front() = '[';
  text.back() = ']';
  return text;
}

}  // namespace

std::string long_text(const CampaignStanding& standing) {
  return counts_text(standing) + ", " + std::to_string(standing.active) + " at work; " +
         pace_text(standing, " evaluations/s");
}

std::string text_within(const CampaignStanding& standing, std::size_t columns) {
  const std::string whole = long_text(standing);
  const std::string least = counts_text(standing) + "; " + pace_text(standing, "/s");
  for (const std::size_t cells : {20, 10, 5})
    if (whole.size() + cells + 3 <= columns) return bar(standing.share, cells) + " " + whole;
  return whole.size() <= columns ? whole : least.substr(0, columns);
}

void CampaignProgress::Counter::begin_generation(std::uint64_t generation) {
  before_ = generation * work_.evaluations;
  done_ = before_;
}

void CampaignProgress::Counter::update(std::uint64_t done) { done_ = before_ + done; }

void CampaignProgress::Counter::end_generation(const evolution::Statistics&) {
  done_ = before_ + work_.evaluations;
}

CampaignProgress::CampaignProgress(Terminal& terminal, const std::vector<Work>& runs)
    : terminal_(terminal), shown_(Clock::now()) {
  for (const Work& work : runs) {
    counters_.push_back(std::make_unique<Counter>(work));
    planned_ += work.generations * work.evaluations;
  }
  recent_.emplace_back(Clock::now(), evaluations_done());
}

CampaignProgress::~CampaignProgress() { terminal_.status(""); }

Watcher& CampaignProgress::watcher(std::size_t run) { return *counters_[run]; }

void CampaignProgress::give_up(std::size_t run) { planned_ -= counters_[run]->left(); }

void CampaignProgress::update(std::uint64_t done, std::uint64_t failed, std::uint64_t active) {
  const Clock::time_point now = Clock::now();
  if (terminal_.interactive() ? now - shown_ < redraw : now - shown_ < heartbeat) return;
  shown_ = now;
  const CampaignStanding standing = this->standing(done, failed, active);
  if (terminal_.interactive())
    terminal_.status(text_within(standing, terminal_.columns()));
  else
    terminal_.line(long_text(standing));
}

void CampaignProgress::ended(const std::string& text, std::uint64_t done, std::uint64_t failed,
                             std::uint64_t active) {
  if (terminal_.interactive()) return;
  shown_ = Clock::now();
  terminal_.line(text + "; " + long_text(standing(done, failed, active)));
}

CampaignStanding CampaignProgress::standing(std::uint64_t done, std::uint64_t failed,
                                            std::uint64_t active) {
  const Clock::time_point now = Clock::now();
  const std::uint64_t evaluations = evaluations_done();
  const std::chrono::duration<double> seconds = now - recent_.front().first;
  CampaignStanding standing{.runs = counters_.size(),
                            .done = done,
                            .failed = failed,
                            .active = active,
                            .share = 1,
                            .rate = 0,
                            .seconds_left = {}};
  if (planned_ > 0)
    standing.share = static_cast<double>(evaluations) / static_cast<double>(planned_);
  if (evaluations > recent_.front().second && seconds.count() > 0) {
    standing.rate = static_cast<double>(evaluations - recent_.front().second) / seconds.count();
    standing.seconds_left = static_cast<double>(planned_ - evaluations) / standing.rate;
  }
  if (now - recent_.back().first >= grain) recent_.emplace_back(now, evaluations);
  while (recent_.size() > 2 && now - recent_[1].first > window) recent_.pop_front();
  return standing;
}

std::uint64_t CampaignProgress::evaluations_done() const {
  std::uint64_t sum = 0;
  for (const auto& counter : counters_) sum += counter->done();
  return std::min(sum, planned_);
}

}  // namespace somas::run
