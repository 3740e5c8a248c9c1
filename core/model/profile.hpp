// Where the time of simulations goes: by phase of the step, and by plugin.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace somas::model {

/// The parts of a step, in their order (docs/model.md, section 0). Everything that a step does is
/// in one of them.
enum class StepPhase : std::uint8_t {
  fields,
  sense,
  control,
  decide,
  metabolism,
  cycle,
  deposit,
  mechanics,
  stress,
  deaths,
  observe
};
inline constexpr std::size_t step_phases = 11;

/// "fields", "sense", ...
[[nodiscard]] std::string_view name_of(StepPhase phase);

/// Sums over the steps of simulations. Used by one thread at a time.
class Profile {
 public:
  using Duration = std::chrono::nanoseconds;
  /// A call that a plugin gets in every step.
  struct Call {
    std::string plugin;  ///< instance, "controller" or "fitness"
    std::string call;    ///< "act(stress)", "step"
    Duration time{};
    std::uint64_t calls = 0;
  };

  void add_phase(StepPhase phase, Duration time) {
    phases_[static_cast<std::size_t>(phase)] += time;
  }
  void add_call(std::string_view plugin, std::string_view call, Duration time,
                std::uint64_t calls = 1);
  /// A simulation is over: `total` is the time of all its steps.
  void add_life(Duration total, std::uint64_t steps, double cell_steps);
  void add(const Profile& other);

  [[nodiscard]] Duration phase(StepPhase phase) const {
    return phases_[static_cast<std::size_t>(phase)];
  }
  /// In the order of their first calls; their times are part of the phases'.
  [[nodiscard]] const std::vector<Call>& calls() const { return calls_; }
  [[nodiscard]] Duration total() const { return total_; }
  [[nodiscard]] std::uint64_t lives() const { return lives_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  [[nodiscard]] double cell_steps() const { return cell_steps_; }

 private:
  Call& entry(std::string_view plugin, std::string_view call);

  std::array<Duration, step_phases> phases_{};
  std::vector<Call> calls_;
  Duration total_{};
  std::uint64_t lives_ = 0, steps_ = 0;
  double cell_steps_ = 0;
};

/// Hands the time from its birth to `stop` or its death to `record`; of no profile (null) nothing.
template <class Record>
class Stopwatch {
 public:
  Stopwatch(Profile* profile, Record record) : profile_(profile), record_(record) {
    if (profile_ != nullptr) begun_ = Clock::now();
  }
  ~Stopwatch() {
    if (profile_ != nullptr) record_(*profile_, Clock::now() - begun_);
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  Profile* profile_;
  Record record_;
  Clock::time_point begun_{};
};

}  // namespace somas::model
