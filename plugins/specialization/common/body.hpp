// The physical properties of a state as parameters, which are the same for every kind of tree.
#pragma once

#include "somas/sdk/parameters.hpp"

namespace somas::specialization {

/// Describes the members mass, radius, stiffness, adhesion and adhesion_range of `state`.
template <class State>
void describe_body(Describe& d, State& state) {
  d("mass", state.mass, "Mass of a cell", {.unit = "mass", .minimum = 1e-6, .maximum = 1e6});
  d("radius", state.radius, "Radius of a cell that is not dividing",
    {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
  d("stiffness", state.stiffness, "Stiffness of the collision spring",
    {.unit = "force/length", .minimum = 0, .maximum = 1e6});
  d("adhesion", state.adhesion, "Strength of the adhesion spring",
    {.unit = "force/length", .minimum = 0, .maximum = 1e6});
  d("adhesion_range", state.adhesion_range,
    "Distance at which adhesion begins, over the sum of both radii",
    {.minimum = 1, .maximum = 100});
}

}  // namespace somas::specialization
