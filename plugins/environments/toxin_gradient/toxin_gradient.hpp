// Toxin gradient: a poison that sources give off, that diffuses, decays, and harms whom it reaches.
//
// The concentration C obeys dC/dt = D laplace(C) - k C + sources (Crank, "The Mathematics of
// Diffusion", 1975, sections 1.3 and 14.2), solved on a square grid centred on the origin by the
// explicit scheme (forward in time, centred in space) with one step of the model as time step:
//
//   C <- C + D/side^2 (left + right + below + above - 4 C) - k C + emission_scale rate / side^2
//
// Each step every live cell absorbs toxicity * C as a hazard named like the instance, C being that
// of the square that holds its centre; off the grid there is none.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

class ToxinGradient final : public Environment {
 public:
  static constexpr About about{"toxin_gradient",
                               "A poison that diffuses from its sources and kills by its dose"};

  /// A point that gives off toxin into the square that holds it.
  struct Source {
    double x = 0, y = 0;
    double rate = 0;

    void describe(Describe& d) {
      d("x", x, "Place of the source, on the grid",
        {.unit = "length", .minimum = -1e6, .maximum = 1e6, .required = true});
      d("y", y, "Place of the source, on the grid",
        {.unit = "length", .minimum = -1e6, .maximum = 1e6, .required = true});
      d("rate", rate, "Toxin given off",
        {.unit = "toxin/step", .minimum = 0, .maximum = 1e9, .required = true});
    }
  };

  struct Parameters {
    std::int64_t resolution = 64;
    double side = 2;
    std::vector<Source> sources{};
    std::string edge = "none";
    double emission_scale = 1;
    double diffusion = 0.5;
    double decay = 0.01;
    std::string boundary = "zero_flux";
    double saturation = 1;
    double toxicity = 0.01;
    std::string resistance_skill = "toxin_resistance";

    void describe(Describe& d) {
      d("resolution", resolution,
        "Squares along an edge of the grid; if odd, one is centred on the origin",
        {.unit = "squares", .minimum = 1, .maximum = 1024});
      d("side", side, "Edge of a square; resolution x side should span the world",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d.list("sources", sources, "Points that give off toxin; several in a square add up");
      d.choice("edge", edge, {"none", "left", "right", "top", "bottom"},
               "Edge of the grid whose squares are held at the concentration emission_scale");
      d("emission_scale", emission_scale,
        "Factor on all rates, and the concentration of the held edge; may vary in time",
        {.minimum = 0, .maximum = 1e9});
      d("diffusion", diffusion, "Diffusion coefficient, at most side^2 / 4",
        {.unit = "length^2/step", .minimum = 0, .maximum = 1e12});
      d("decay", decay, "Share of the toxin that decays, at most 1 - 4 diffusion / side^2",
        {.unit = "1/step", .minimum = 0, .maximum = 1});
      d.choice(
          "boundary", boundary, {"zero_flux", "absorbing"},
          "What the edges of the grid do: let nothing pass, or border on a world without toxin");
      d("saturation", saturation, "Concentration that the sensor reads as 1",
        {.unit = "toxin/length^2", .minimum = 1e-9, .maximum = 1e9});
      d("toxicity", toxicity,
        "Dose that a cell absorbs at concentration 1; may vary in time; a cell dies above its "
        "resistance",
        {.unit = "dose/step", .minimum = 0, .maximum = 1e9});
      d("resistance_skill", resistance_skill,
        "Skill of the states: the dose that a cell can absorb and live");
    }
  };

  /// Throws ParameterError when the scheme would be unstable, or a source is off the grid.
  explicit ToxinGradient(const Parameters& parameters);
  void declare(Declare& declare) override;
  void act(Phase phase, World& world) const override;

 private:
  void spread(World& world) const;
  void sense(World& world) const;
  void poison(World& world) const;
  void hold_edge(const Grid& grid, double concentration) const;

  Parameters parameters_;
  GridSpec spec_;
  std::vector<std::size_t> squares_;  ///< of the sources
  Id grid_ = no_id;
  Id sensor_ = no_id;
  Id hazard_ = no_id;
  Id emission_scale_ = no_id;
  Id toxicity_ = no_id;
};

}  // namespace somas::environments
