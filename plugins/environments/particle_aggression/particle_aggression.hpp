// Particle aggression: ever more particles fly in from all round (model, section 8, experiment 1).
//
// Particles start evenly spread on a circle, fly straight at a point drawn from a normal
// distribution round the centre, and are spent on the first cell they meet, which absorbs their
// energy as a hazard named like the instance. Those that meet none leave past the far side.
// Counting t from the first step of aggression,
//
//   rate_scale * (rate_constant + rate_linear t + rate_quadratic t^2)
//
// particles are due at a step; fractions are carried over to the next.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

class ParticleAggression final : public Environment {
 public:
  static constexpr About about{"particle_aggression",
                               "Particles from all round that kill the cells they hit"};

  struct Parameters {
    std::optional<double> spawn_radius{};
    double speed = 0.5;
    double aim_spread = 12;
    double energy = 1;
    std::int64_t start = 0;
    double rate_scale = 1;
    double rate_constant = 0.5;
    double rate_linear = 0.004;
    double rate_quadratic = 2e-5;
    std::string resistance_skill = "resistance";

    void describe(Describe& d) {
      d("spawn_radius", spawn_radius,
        "Radius of the circle round the origin where particles start; left out: the world's",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("speed", speed, "Distance that a particle flies in a step",
        {.unit = "length/step", .minimum = 1e-6, .maximum = 1e6});
      d("aim_spread", aim_spread,
        "Standard deviation, along x and along y, of the points aimed at round the origin",
        {.unit = "length", .minimum = 0, .maximum = 1e6});
      d("energy", energy, "Energy of a particle; a cell dies above its resistance",
        {.unit = "energy", .minimum = 1e-9, .maximum = 1e9});
      d("start", start, "First step of aggression, where t = 0",
        {.unit = "step", .minimum = 0, .maximum = 1e9});
      d("rate_scale", rate_scale, "Factor on the whole rate", {.minimum = 0, .maximum = 1e6});
      d("rate_constant", rate_constant, "Rate at t = 0",
        {.unit = "particles/step", .minimum = 0, .maximum = 1e6});
      d("rate_linear", rate_linear, "Growth of the rate with t",
        {.unit = "particles/step^2", .minimum = 0, .maximum = 1e6});
      d("rate_quadratic", rate_quadratic, "Growth of the rate with the square of t",
        {.unit = "particles/step^3", .minimum = 0, .maximum = 1e6});
      d("resistance_skill", resistance_skill,
        "Skill of the states: the energy that a cell can absorb and live");
    }
  };

  explicit ParticleAggression(const Parameters& parameters) : parameters_(parameters) {}
  void declare(Declare& declare) override;
  void act(Phase phase, World& world) const override;

  /// Particles due at the step `t` after the start, times `scale`.
  [[nodiscard]] double rate(double t, double scale) const;

 private:
  struct Particles;
  struct Draws;
  struct Box;
  struct Block;
  struct Round;
  void check_number(std::uint64_t max_steps) const;
  void emit(World& world) const;
  void launch(const Particles& p, std::size_t i, const Draws& draws) const;
  void fly(World& world, Round& round) const;
  static Box bounds_of(World& world, Round& round);
  void advance(const Particles& p, const Box& inhabited, Round& round, std::uint32_t part,
               std::uint32_t parts) const;
  void advance(const Particles& p, const Box& inhabited, Block& block, std::uint32_t* nears,
               Segment* near_paths, std::uint64_t* all_leave) const;
  static void find_hits(World& world, Round& round);
  void strike(World& world, const Particles& p, Round& round, const Block& block) const;
  static std::uint32_t fill_gaps(World& world, const Particles& p, Round& round);

  Parameters parameters_;
  double spawn_radius_ = 0;
  Id particles_ = no_id;
  Id due_ = no_id;     ///< the fraction of a particle carried over
  Id serial_ = no_id;  ///< particles emitted so far; exact up to 2^53
  Id hazard_ = no_id;
  Id purpose_ = no_id;
  Id rate_scale_ = no_id;
};

}  // namespace somas::environments
