// Parameters of evolved trees.
#pragma once

#include <cstdint>

#include "somas/sdk/parameters.hpp"

namespace somas::specialization {

struct EvolvedTreeParameters {
  std::int64_t max_states = 6;
  std::int64_t max_depth = 4;
  double budget = 13;
  double move_weight = 6;
  double add_weight = 2;
  double split_weight = 1;
  double remove_weight = 2;
  double mass = 1;
  double radius = 1;
  double stiffness = 10;
  double adhesion = 3;
  double adhesion_range = 1.2;

  void describe(Describe& d) {
    d("max_states", max_states, "Most states of a tree", {.minimum = 1, .maximum = 64});
    d("max_depth", max_depth, "Most states from the root to a leaf, both counted",
      {.minimum = 1, .maximum = 64});
    d("budget", budget, "Points that a state spends on skills, each at the skill's price",
      {.unit = "points", .minimum = 1e-9, .maximum = 1e9});
    const Limits weight = {.minimum = 0, .maximum = 1e6};
    d("move_weight", move_weight, "How often a mutation moves points between two skills", weight);
    d("add_weight", add_weight, "How often it adds a state below another", weight);
    d("split_weight", split_weight, "How often it puts a state between another and its children",
      weight);
    d("remove_weight", remove_weight, "How often it removes a state; its children go to its parent",
      weight);
    d("mass", mass, "Mass of a cell, in every state",
      {.unit = "mass", .minimum = 1e-6, .maximum = 1e6});
    d("radius", radius, "Radius of a cell that is not dividing",
      {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
    d("stiffness", stiffness, "Stiffness of the collision spring",
      {.unit = "force/length", .minimum = 0, .maximum = 1e6});
    d("adhesion", adhesion, "Strength of the adhesion spring",
      {.unit = "force/length", .minimum = 0, .maximum = 1e6});
    d("adhesion_range", adhesion_range,
      "Distance at which adhesion begins, over the sum of both radii",
      {.minimum = 1, .maximum = 100});
  }
};

}  // namespace somas::specialization
