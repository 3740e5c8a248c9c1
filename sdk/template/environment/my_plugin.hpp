// A wind along x that begins at a step, which cells can feel.
#pragma once

#include <somas/sdk/plugin.hpp>

class MyPlugin final : public somas::Environment {
 public:
  static constexpr somas::About about{"my_plugin", "A wind along x that begins at a step"};

  /// The initialisers are the defaults. The host checks the experiment against this list.
  struct Parameters {
    double strength = 0.1;
    std::int64_t start = 100;

    void describe(somas::Describe& d) {
      d("strength", strength, "Force on every cell", {.unit = "force", .maximum = 100});
      d("start", start, "First step of the wind", {.unit = "step", .minimum = 0});
    }
  };

  explicit MyPlugin(const Parameters& parameters) : p_(parameters) {}

  /// Once: what there will be, and when `act` is to be called.
  void declare(somas::Declare& d) override {
    wind_ = d.sensor(d.instance());
    d.acts_in(somas::Phase::sense);
    d.acts_in(somas::Phase::forces);
  }

  /// In every step, from several simulations at once: all that changes belongs to the world.
  void act(somas::Phase phase, somas::World& world) const override {
    if (world.step() < static_cast<std::uint64_t>(p_.start)) return;
    if (phase == somas::Phase::sense) {
      for (float& input : world.sensor(wind_)) input = 1;  // of every cell, best within [0, 1]
    } else {
      for (double& force : world.force_x()) force += p_.strength;
    }
  }

 private:
  Parameters p_;
  somas::Id wind_ = somas::no_id;
};
