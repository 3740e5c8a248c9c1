// Tree: a specialization tree written out in the experiment (model, section 5).
//
// A list of states in any order, each with its parent, its physical properties and its points in
// the skills that the model and the environments declare. Exactly one state, the root, has no
// parent: the founder's. With a `budget` no state may have more points than that, all its skills
// together, at each skill's price.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "somas/sdk/parameters.hpp"
#include "somas/sdk/specialization.hpp"

namespace somas::specialization {

class Tree final : public Specialization {
 public:
  static constexpr About about{"tree", "A fixed specialization tree, state by state"};

  struct State {
    std::string name;
    std::string parent;
    double mass = 1;
    double radius = 1;
    double stiffness = 10;
    double adhesion = 3;
    double adhesion_range = 1.2;
    std::map<std::string, double> skills;

    void describe(Describe& d) {
      d("name", name, "Name of the state, unique in the tree", {.required = true});
      d("parent", parent, "State that specializes into this one; left out: this is the root");
      d("mass", mass, "Mass of a cell", {.unit = "mass", .minimum = 0, .minimum_open = true});
      d("radius", radius, "Radius of a cell that is not dividing",
        {.unit = "length", .minimum = 0, .minimum_open = true});
      d("stiffness", stiffness, "Stiffness of the collision spring",
        {.unit = "force/length", .minimum = 0});
      d("adhesion", adhesion, "Strength of the adhesion spring",
        {.unit = "force/length", .minimum = 0});
      d("adhesion_range", adhesion_range,
        "Distance at which adhesion begins, over the sum of both radii", {.minimum = 1});
      d.table("skills", skills, "Points by skill; a skill left out has its fallback");
    }
  };

  struct Parameters {
    std::vector<State> states;
    std::optional<double> budget{};

    void describe(Describe& d) {
      d.list("states", states, "The states, 1 to 64, in any order", true);
      d("budget", budget, "Points that a state may spend on skills; left out: no limit",
        {.unit = "points", .minimum = 0});
    }
  };

  /// Throws ParameterError when the states are not one tree.
  explicit Tree(const Parameters& parameters);
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override;

 private:
  [[nodiscard]] std::vector<double> points(std::size_t state,
                                           std::span<const SkillInfo> skills) const;
  void check_budget(std::size_t state, std::span<const SkillInfo> skills,
                    std::span<const double> points) const;

  std::vector<State> states_;
  std::optional<double> budget_;
  std::vector<std::size_t> order_;  ///< of emission: parents first, else as listed
};

}  // namespace somas::specialization
