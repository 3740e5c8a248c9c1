#include "core/run/progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace somas::run {
namespace {

constexpr double redraw_seconds = 0.2;
constexpr double heartbeat_seconds = 10;
constexpr std::size_t bar_cells = 20;

// Enough digits to see a difference, no more: the exact numbers are in the files.
std::string number_text(double value) {
  char text[32];
  if (value == std::floor(value) && std::abs(value) < 1e9)
    std::snprintf(text, sizeof text, "%.0f", value);
  else
    std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

std::string rate_text(double rate) {
  char text[32];
  std::snprintf(text, sizeof text, rate < 10 ? "%.1f" : "%.0f", rate);
  return text;
}

std::string bar(double share) {
  const auto full = static_cast<std::size_t>(share * static_cast<double>(bar_cells));
  std::string text(bar_cells + 2, '.');
  std::fill_n(text.begin() + 1, full, '#');
  text.front() = '[';
  text.back() = ']';
  return text;
}

}  // namespace

std::string duration_text(double seconds) {
  const auto total = static_cast<long>(std::lround(std::clamp(seconds, 0.0, 1e9)));
  char text[32];
  if (total < 60)
    std::snprintf(text, sizeof text, "%lds", total);
  else if (total < 3600)
    std::snprintf(text, sizeof text, "%ldm%02lds", total / 60, total % 60);
  else if (total < 86400)
    std::snprintf(text, sizeof text, "%ldh%02ldm", total / 3600, total / 60 % 60);
  else
    std::snprintf(text, sizeof text, "%ldd%02ldh", total / 86400, total / 3600 % 24);
  return text;
}

Progress::Progress(Terminal& terminal, std::uint64_t generations, std::uint64_t evaluations)
    : terminal_(terminal), generations_(generations), evaluations_(evaluations) {}

Progress::~Progress() { terminal_.status(""); }

void Progress::begin_generation(std::uint64_t generation) {
  generation_ = generation;
  begun_ = shown_ = Clock::now();
  if (terminal_.interactive()) draw(0);
}

void Progress::update(std::uint64_t done) {
  const double interval = terminal_.interactive() ? redraw_seconds : heartbeat_seconds;
  const std::chrono::duration<double> since = Clock::now() - shown_;
  if (since.count() < interval) return;
  if (elapsed() > 0 && done > 0) rate_ = static_cast<double>(done) / elapsed();
  draw(done);
}

void Progress::end_generation(const evolution::Statistics& statistics) {
  const double seconds = std::max(elapsed(), 1e-9);
  rate_ = static_cast<double>(evaluations_) / seconds;
  pace_ = pace_ ? 0.7 * *pace_ + 0.3 * seconds : seconds;
  last_ = statistics;
  // On a terminal the next redraw shows it; elsewhere each generation gets its line.
  if (!terminal_.interactive()) terminal_.line(description(evaluations_));
}

double Progress::elapsed() const {
  return std::chrono::duration<double>(Clock::now() - begun_).count();
}

double Progress::seconds_left(std::uint64_t done) const {
  const auto finished = static_cast<double>(done) / static_cast<double>(evaluations_);
  const auto after = static_cast<double>(generations_ - generation_ - 1);
  // The first generation has nothing but itself to go by.
  const double pace = pace_.value_or(finished > 0 ? elapsed() / finished : 0);
  return pace * (after + std::max(0.0, 1 - finished));
}

std::string Progress::description(std::uint64_t done) const {
  const bool complete = done == evaluations_;
  // Generations count from 0, as everywhere else.
  std::string text = "generation " + std::to_string(generation_) + " (" +
                     std::to_string(generation_ + 1) + " of " + std::to_string(generations_) + ")";
  if (!complete) text += " " + std::to_string(done) + "/" + std::to_string(evaluations_);
  if (last_)
    text += ": best " + number_text(last_->best) + ", median " + number_text(last_->median);
  else
    text += ": best -, median -";
  text += ", " + rate_text(rate_) + " evaluations/s";
  if (pace_ || done > 0) text += ", " + duration_text(seconds_left(done)) + " left";
  return text;
}

void Progress::draw(std::uint64_t done) {
  shown_ = Clock::now();
  if (!terminal_.interactive()) {
    terminal_.line(description(done));
    return;
  }
  const double all = static_cast<double>(generations_) * static_cast<double>(evaluations_);
  const double so_far = static_cast<double>(generation_) * static_cast<double>(evaluations_) +
                        static_cast<double>(done);
  terminal_.status(bar(std::min(1.0, so_far / all)) + " " + description(done));
}

}  // namespace somas::run
