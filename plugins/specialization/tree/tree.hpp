// Tree: a specialization tree written out in the experiment (model, section 5).
//
// A list of states in any order, each with its parent, its physical properties and its points in
// the skills that the model and the environments declare. Exactly one state, the root, has no
// parent: the founder's. Adhesion between two states is the mean of theirs unless `adhesion_pairs`
// names the two. With a `budget` no state may have more points than that, all its skills
// together, at each skill's price.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "somas/sdk/parameters.hpp"
#include "somas/sdk/specialization.hpp"

#include "plugins/specialization/common/body.hpp"

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
    double motility = 0;
    std::int64_t motility_signal = 0;
    double quiescence_threshold = 0;
    double division_threshold = 0;
    double specialization_threshold = 0;
    double apoptosis_threshold = 0;

    void describe(Describe& d) {
      d("name", name, "Name of the state, unique in the tree", {.required = true});
      d("parent", parent, "State that specializes into this one; left out: this is the root");
      describe_body(d, *this);
      d("motility", motility,
        "Force with which a cell crawls along the gradient of a morphogen: up when positive, down "
        "when negative",
        {.unit = "force", .minimum = -1e6, .maximum = 1e6});
      d("motility_signal", motility_signal, "Which morphogen it follows, counted from 0",
        {.minimum = 0, .maximum = 1e6});
      const Limits threshold = {.minimum = 0, .maximum = 1};
      d("quiescence_threshold", quiescence_threshold,
        "Least output, clamped to [0, 1], at which quiescence can be chosen", threshold);
      d("division_threshold", division_threshold,
        "Least output, clamped to [0, 1], at which division can be chosen", threshold);
      d("specialization_threshold", specialization_threshold,
        "Least output, clamped to [0, 1], at which specialization can be chosen", threshold);
      d("apoptosis_threshold", apoptosis_threshold,
        "Least output, clamped to [0, 1], at which apoptosis can be chosen", threshold);
      d.table("skills", skills, "Points by skill; a skill left out has its fallback",
              {.minimum = -1e9, .maximum = 1e9});
    }
  };

  /// Two states whose adhesion to each other is not the mean of both.
  struct AdhesionPair {
    std::string first;
    std::string second;
    double strength = 0;

    void describe(Describe& d) {
      d("first", first, "Name of a state", {.required = true});
      d("second", second, "Name of another state", {.required = true});
      d("strength", strength, "Strength of the adhesion spring between cells of the two",
        {.unit = "force/length", .minimum = 0, .required = true});
    }
  };

  struct Parameters {
    std::vector<State> states;
    std::optional<double> budget{};
    std::vector<AdhesionPair> adhesion_pairs{};

    void describe(Describe& d) {
      d.list("states", states, "The states, in any order",
             {.required = true, .minimum_count = 1, .maximum_count = 64});
      d("budget", budget, "Points that a state may spend on skills; left out: no limit",
        {.unit = "points", .minimum = 0, .maximum = 1e9});
      d.list("adhesion_pairs", adhesion_pairs,
             "Adhesion between two states, in any order; for two not named: the mean of theirs");
    }
  };

  /// Throws ParameterError when the states are not one tree, or the pairs not pairs of them.
  explicit Tree(const Parameters& parameters);
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override;

 private:
  [[nodiscard]] std::vector<double> points(std::size_t state,
                                           std::span<const SkillInfo> skills) const;
  void check_signal(std::size_t state, std::uint32_t morphogens) const;
  void check_budget(std::size_t state, std::span<const SkillInfo> skills,
                    std::span<const double> points) const;

  std::vector<State> states_;
  std::optional<double> budget_;
  std::vector<std::size_t> order_;             ///< of emission: parents first, else as listed
  std::vector<std::vector<double>> adhesion_;  ///< by state and state; NaN where no pair names them
};

}  // namespace somas::specialization
