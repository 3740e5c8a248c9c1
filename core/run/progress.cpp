#include "core/run/progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace somas::run {
namespace {

constexpr double redraw_seconds = 0.2;
constexpr double heartbeat_seconds = 10;
constexpr std::size_t bar_cells[] = {20, 10, 5};

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

std::string bar(double share, std::size_t cells) {
  const auto full = static_cast<std::size_t>(share * static_cast<double>(cells));
  std::string text(cells + 2, '.');
  std::fill_n(text.begin() + 1, full, '#');
  text.front() = '[';
  text.back() = ']';
  return text;
}

/// How much a line says, from all to the least.
enum class Wording { words, abbreviations, no_evaluations, no_total, least };

std::string value_text(const std::optional<double>& value) {
  return value ? number_text(*value) : "-";
}

// Generations count from 0, as everywhere else; the count from 1 stands beside it.
std::string generation_text(const Standing& standing, Wording wording) {
  std::string text = wording == Wording::words ? "generation " : "gen ";
  text += std::to_string(standing.generation);
  if (wording >= Wording::no_total) return text;
  text += " (" + std::to_string(standing.generation + 1) + " of " +
          std::to_string(standing.generations) + ")";
  if (wording >= Wording::no_evaluations || standing.done == standing.evaluations) return text;
  return text + " " + std::to_string(standing.done) + "/" + std::to_string(standing.evaluations);
}

std::string worded(const Standing& standing, Wording wording) {
  const bool least = wording == Wording::least;
  const std::string comma = least ? " " : ", ";
  std::string text = generation_text(standing, wording) + (least ? " best " : ": best ") +
                     value_text(standing.best) + comma + "median " + value_text(standing.median) +
                     comma + rate_text(standing.rate);
  text += least ? "/s" : wording == Wording::words ? " evaluations/s" : " eval/s";
  if (standing.seconds_left) text += comma + duration_text(*standing.seconds_left) + " left";
  return text;
}

double share_done(const Standing& standing) {
  const auto evaluations = static_cast<double>(standing.evaluations);
  const double so_far =
      static_cast<double>(standing.generation) * evaluations + static_cast<double>(standing.done);
  return std::min(1.0, so_far / (static_cast<double>(standing.generations) * evaluations));
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

std::string long_text(const Standing& standing) { return worded(standing, Wording::words); }

std::string text_within(const Standing& standing, std::size_t columns) {
  std::string text;
  for (const Wording wording : {Wording::words, Wording::abbreviations, Wording::no_evaluations,
                                Wording::no_total, Wording::least}) {
    text = worded(standing, wording);
    for (const std::size_t cells : bar_cells)
      if (text.size() + cells + 3 <= columns) return bar(share_done(standing), cells) + " " + text;
    if (text.size() <= columns) return text;
  }
  return text.substr(0, columns);
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
  if (!terminal_.interactive()) terminal_.line(long_text(standing(evaluations_)));
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

Standing Progress::standing(std::uint64_t done) const {
  Standing now{.generation = generation_,
               .generations = generations_,
               .done = done,
               .evaluations = evaluations_,
               .best = {},
               .median = {},
               .rate = rate_,
               .seconds_left = {}};
  if (last_) {
    now.best = last_->best;
    now.median = last_->median;
  }
  if (pace_ || done > 0) now.seconds_left = seconds_left(done);
  return now;
}

void Progress::draw(std::uint64_t done) {
  shown_ = Clock::now();
  if (terminal_.interactive())
    terminal_.status(text_within(standing(done), terminal_.columns()));
  else
    terminal_.line(long_text(standing(done)));
}

}  // namespace somas::run
