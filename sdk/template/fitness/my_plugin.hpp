// Steps survived, and something for every division.
#pragma once

#include <somas/sdk/plugin.hpp>

class MyPlugin final : public somas::Fitness {
 public:
  static constexpr somas::About about{"my_plugin", "Steps survived, and a bonus for divisions"};

  /// The initialisers are the defaults. The host checks the experiment against this list.
  struct Parameters {
    double bonus = 0.5;

    void describe(somas::Describe& d) {
      d("bonus", bonus, "Score of a division", {.unit = "step/division", .minimum = 0});
    }
  };

  explicit MyPlugin(const Parameters& parameters) : p_(parameters) {}

  /// The name of the number, for tables and progress.
  std::string_view objective() const override { return "survival+divisions"; }

  /// Of one organism in one simulation; larger is better, never NaN.
  double score(const somas::Outcome& outcome) const override {
    return static_cast<double>(outcome.survival) +
           p_.bonus * static_cast<double>(outcome.divisions);
  }

 private:
  Parameters p_;
};
