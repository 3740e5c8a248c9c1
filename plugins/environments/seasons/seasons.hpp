// Seasons: parameters of other environments that change with time.
//
// Each cycle takes one variable parameter in charge and sets it before every step t to
//
//   value (1 + amplitude wave(t)),
//
// where `value` is what the experiment gives and the wave lies within -1 and 1:
//
//   u = ((t - from) mod period) / period + phase, less its whole part
//   sine      sin(2 pi u)
//   square    1 where u < 1/2, else -1
//   triangle  4 u up to 1/4, 2 - 4 u up to 3/4, then 4 u - 4
//   ramp      min(1, (t - from) / period), once; the phase does not matter
//
// and 0 before `from`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

class Seasons final : public Environment {
 public:
  static constexpr About about{"seasons", "Parameters of other environments that vary in time"};

  struct Cycle {
    std::string environment = "nutrients";
    std::string parameter = "regeneration";
    std::string shape = "sine";
    std::int64_t period = 200;
    double amplitude = 1;
    double phase = 0;
    std::int64_t from = 0;

    void describe(Describe& d) {
      d("environment", environment, "Name of the environment in the experiment");
      d("parameter", parameter, "Key of its parameter, which it must let vary");
      d.choice("shape", shape, {"sine", "square", "triangle", "ramp"}, "How it goes up and down");
      d("period", period, "Length of a cycle; of a ramp: until its end",
        {.unit = "steps", .minimum = 1, .maximum = 1e15});
      d("amplitude", amplitude, "Largest change, as a part of the parameter's value",
        {.minimum = -1e6, .maximum = 1e6});
      d("phase", phase, "Where in its cycle the wave begins, as a part of the period",
        {.minimum = 0, .maximum = 1});
      d("from", from, "First step of the first cycle",
        {.unit = "step", .minimum = 0, .maximum = 1e15});
    }

    /// The wave in step `t`, within -1 and 1.
    [[nodiscard]] double wave(std::uint64_t t) const;
  };

  struct Parameters {
    std::vector<Cycle> cycles;

    void describe(Describe& d) {
      d.list("cycles", cycles, "The parameters that vary, each in one cycle",
             {.required = true, .minimum_count = 1});
    }
  };

  /// Throws ParameterError without a cycle.
  explicit Seasons(const Parameters& parameters);
  void declare(Declare& declare) override;
  /// Throws ParameterError for a parameter that nobody lets vary, that would not change, or that
  /// would leave its range.
  void connect(Connections& connections) override;
  void act(Phase phase, World& world) const override;

 private:
  std::vector<Cycle> cycles_;
  std::vector<Variable> variables_;  ///< by cycle
};

}  // namespace somas::environments
