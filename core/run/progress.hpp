// How far a run is, for people.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/evolution/ranking.hpp"
#include "core/run/terminal.hpp"
#include "core/run/watcher.hpp"

namespace somas::run {

/// What a progress line says.
struct Standing {
  std::uint64_t generation = 0, generations = 1;  ///< counted from 0; how many
  std::uint64_t done = 0, evaluations = 1;        ///< of this generation
  std::optional<double> best, median;             ///< of the generation before
  double rate = 0;                                ///< evaluations a second
  std::optional<double> seconds_left;
};

/// In whole words, without a bar.
[[nodiscard]] std::string long_text(const Standing& standing);

/// As much as fits into so many columns: the bar shrinks first, then the words, then the number of
/// evaluations done and the number of generations go. From 60 columns on there are always
/// generation, best, median, evaluations a second and time left.
[[nodiscard]] std::string text_within(const Standing& standing, std::size_t columns);

/// On a terminal one line, redrawn five times a second: bar, generation, best, median, evaluations
/// a second, time left. Elsewhere a line a generation, and within one that takes long, now and
/// then.
class Progress final : public Watcher {
 public:
  /// `evaluations`: simulations a generation.
  Progress(Terminal& terminal, std::uint64_t generations, std::uint64_t evaluations);
  ~Progress() override;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin_generation(std::uint64_t generation) override;
  void update(std::uint64_t done) override;
  void end_generation(const evolution::Statistics& statistics) override;

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] double elapsed() const;
  [[nodiscard]] double seconds_left(std::uint64_t done) const;
  [[nodiscard]] Standing standing(std::uint64_t done) const;
  void draw(std::uint64_t done);

  Terminal& terminal_;
  std::uint64_t generations_, evaluations_;
  std::uint64_t generation_ = 0;
  Clock::time_point begun_, shown_;
  std::optional<evolution::Statistics> last_;  ///< of the generation before
  std::optional<double> pace_;                 ///< seconds a generation, recent ones count more
  double rate_ = 0;                            ///< evaluations a second
};

/// "47s", "3m20s", "2h05m", "3d04h".
[[nodiscard]] std::string duration_text(double seconds);

}  // namespace somas::run
