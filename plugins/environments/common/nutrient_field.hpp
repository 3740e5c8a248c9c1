// A field of nutrient patches: a square grid centred on the origin whose patches hold up to a
// capacity, are eaten by the cells through the host, grow again, and are sensed by the cells above
// them (model, section 2). When it fills, grows or vanishes is the business of the environments.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::environments {

/// The parameters that every nutrient environment has.
struct PatchParameters {
  double capacity = 2;
  double regeneration = 0.15;
  std::int64_t resolution = 64;
  double side = 2;
  std::string production_skill = "production";

  void describe(Describe& d) {
    d("capacity", capacity, "Nutrient that a full patch holds",
      {.unit = "nutrient", .minimum = 1e-9, .maximum = 1e9});
    d("regeneration", regeneration, "Nutrient that grows in a patch, up to its capacity",
      {.unit = "nutrient/step", .minimum = 0, .maximum = 1e9});
    d("resolution", resolution,
      "Patches along an edge of the grid; if even, edges of patches run through the origin",
      {.unit = "patches", .minimum = 1, .maximum = 16384});
    d("side", side, "Edge of a patch; resolution x side should span the world",
      {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
    d("production_skill", production_skill,
      "Skill of the states that limits how much a cell takes up in a step");
  }
};

/// The part of the grid that has nutrients: the patches whose centre lies inside.
struct Region {
  enum class Shape { everywhere, square, disc };
  Shape shape = Shape::everywhere;
  double size = 0;  ///< half the side of the square, or the radius of the disc

  [[nodiscard]] bool contains(double x, double y) const;
};

class NutrientField {
 public:
  /// Declares grid, resource, sensor and skill; resource and sensor are named like the instance.
  /// Throws ParameterError when the region holds no patch.
  void declare(Declare& declare, const PatchParameters& parameters, const Region& region);

  /// Sets every patch of the region to `level`, at most its capacity; the others are empty.
  void set(World& world, double level) const;
  /// One step of growth.
  void regenerate(World& world) const;
  /// Every cell's sensor: content / capacity of the patch that holds its centre, or 0.
  void sense(World& world) const;

 private:
  void sense(const Grid& grid, const Cells& cells, std::span<float> sensed, std::uint32_t first,
             std::uint32_t count) const;

  std::vector<double> capacity_;  ///< of each patch; 0 outside the region
  double everywhere_ = 0;         ///< the capacity, where all patches have the same
  Id grid_ = no_id;
  Id sensor_ = no_id;
  Id regeneration_ = no_id;
};

}  // namespace somas::environments
