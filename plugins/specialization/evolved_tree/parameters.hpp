// Parameters of evolved trees.
#pragma once

#include <cstdint>

#include "somas/sdk/parameters.hpp"

#include "plugins/specialization/common/body.hpp"

namespace somas::specialization {

struct EvolvedTreeParameters {
  std::int64_t max_states = 6;
  std::int64_t max_depth = 4;
  double budget = 13;
  double returns = 1;
  double move_weight = 6;
  double add_weight = 2;
  double split_weight = 1;
  double remove_weight = 2;
  double redraw_weight = 0;
  double attribute_weight = 3;
  bool evolve_motility = false;
  bool evolve_adhesion = false;
  bool evolve_thresholds = false;
  double max_motility = 1;
  double max_adhesion = 6;
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
    d("returns", returns,
      "Exponent of what points buy: 1 is in proportion; above, specialists get more than their "
      "share and jacks of all trades less",
      {.minimum = 0.1, .maximum = 10});
    const Limits weight = {.minimum = 0, .maximum = 1e6};
    d("move_weight", move_weight, "How often a mutation moves points between two skills", weight);
    d("add_weight", add_weight, "How often it adds a state below another", weight);
    d("split_weight", split_weight, "How often it puts a state between another and its children",
      weight);
    d("remove_weight", remove_weight, "How often it removes a state; its children go to its parent",
      weight);
    d("redraw_weight", redraw_weight,
      "How often it spends all points of a state anew, every way equally likely", weight);
    d("attribute_weight", attribute_weight,
      "How often it draws an attribute of a state anew, if any evolves", weight);
    d("evolve_motility", evolve_motility,
      "Whether each state's crawling force evolves, and the morphogen that it follows");
    d("evolve_adhesion", evolve_adhesion,
      "Whether each state's adhesion evolves, and that of pairs of states");
    d("evolve_thresholds", evolve_thresholds, "Whether each state's thresholds of actions evolve");
    d("max_motility", max_motility, "Greatest crawling force, up or down the gradient",
      {.unit = "force", .minimum = 0, .maximum = 1e6});
    d("max_adhesion", max_adhesion,
      "Strongest adhesion that evolves; the load-time check of the time step does not know it",
      {.unit = "force/length", .minimum = 0, .maximum = 1e6});
    describe_body(d, *this);
  }
};

}  // namespace somas::specialization
