// Walls: things that stand still and push back the cells that overlap them.
//
// A cell of radius r that overlaps an obstacle by the depth d, along the unit normal n that points
// out of the obstacle, gets the force
//
//   n (stiffness d - damping v . n)    while d > 0
//
// in every substep: the linear spring and dashpot of Cundall and Strack, "A discrete numerical
// model for granular assemblies", Geotechnique 29 (1979), and the form that pairs of cells have
// (model, section 3). As there, the damper may exceed the spring: a cell that leaves fast is held
// back. Forces of several obstacles add up. Walls stop cells only; they add nothing to a cell's
// pressure.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

/// A shape with its centre. Discs and boxes are solid, an enclosure is solid outside itself.
struct Obstacle {
  enum class Shape { disc, box, enclosure };
  Shape shape = Shape::disc;
  double x = 0, y = 0;
  double half_width = 0;   ///< a disc's radius
  double half_height = 0;  ///< a disc's radius
};

class Walls final : public Environment {
 public:
  static constexpr About about{"walls", "Obstacles that push back the cells that overlap them"};

  /// One entry of the list; which keys it has follows from its kind.
  struct Entry {
    std::string kind = "disc";
    std::optional<double> x{}, y{};
    std::optional<double> radius{};
    std::optional<double> half_width{}, half_height{};
    std::optional<double> thickness{}, gap_y{}, gap_width{};

    /// A key is given if, and only if, the kind has it.
    static void belongs(Describe& d, const char* key, std::initializer_list<const char*> kinds) {
      d.only_when(key, "kind", kinds);
      d.required_when(key, "kind", kinds);
    }
    void describe(Describe& d) {
      d.choice("kind", kind, {"disc", "box", "enclosure", "gap_wall"},
               "A solid disc, a solid rectangle, a rectangle that cells stay inside, or an upright "
               "wall with a gap, symmetric to y = 0 but for the gap");
      d("x", x, "Centre of the shape",
        {.unit = "length", .minimum = -1e6, .maximum = 1e6, .required = true});
      d("y", y, "Centre of a disc, box or enclosure",
        {.unit = "length", .minimum = -1e6, .maximum = 1e6});
      d("radius", radius, "Radius of a disc", {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("half_width", half_width, "Half the extent along x of a box or enclosure",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("half_height", half_height, "Half the extent along y of a box, enclosure or gap_wall",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("thickness", thickness, "Extent along x of a gap_wall",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      d("gap_y", gap_y, "Middle of the gap of a gap_wall",
        {.unit = "length", .minimum = -1e6, .maximum = 1e6});
      d("gap_width", gap_width, "Width of the gap of a gap_wall",
        {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
      belongs(d, "y", {"disc", "box", "enclosure"});
      belongs(d, "radius", {"disc"});
      belongs(d, "half_width", {"box", "enclosure"});
      belongs(d, "half_height", {"box", "enclosure", "gap_wall"});
      for (const char* key : {"thickness", "gap_y", "gap_width"}) belongs(d, key, {"gap_wall"});
    }
  };

  struct Parameters {
    std::vector<Entry> obstacles{};
    double stiffness = 50;
    double damping = 3;
    double lightest_mass = 1;

    void describe(Describe& d) {
      d.list("obstacles", obstacles, "What stands in the way; pictures show it");
      d("stiffness", stiffness, "Spring of a contact",
        {.unit = "force/length", .minimum = 1e-6, .maximum = 1e6});
      d("damping", damping, "Damper of a contact, along its normal",
        {.unit = "force time/length", .minimum = 0, .maximum = 1e6});
      d("lightest_mass", lightest_mass,
        "Mass of the lightest cell for which contacts must be stable; walls do not see the tree, "
        "so this must be at most the least mass of its states",
        {.unit = "mass", .minimum = 1e-6, .maximum = 1e6});
    }
  };

  /// Throws ParameterError when an obstacle lacks a key of its kind, or has one of another.
  explicit Walls(const Parameters& parameters);
  /// Throws ParameterError when the substep is longer than `stable_contact_time_step`.
  void declare(Declare& declare) override;
  void act(Phase phase, World& world) const override;

 private:
  double stiffness_, damping_, lightest_mass_;
  std::vector<Obstacle> obstacles_;
};

/// The longest substep h that `walls` accepts: the root of k h^2 + 2 c h = 2 m. Semi-implicit Euler
/// of m x'' = -k x - c x' is stable for k h^2 + 2 c h <= 4 m (both roots z of
/// z^2 - (2 - h c/m - h^2 k/m) z + 1 - h c/m within the unit circle). The other half is left to the
/// springs between cells, whose part the host keeps at or below 2 m by a bound of its own.
[[nodiscard]] double stable_contact_time_step(double stiffness, double damping, double mass);

}  // namespace somas::environments
