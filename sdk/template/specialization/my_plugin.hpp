// A generalist, and below it a specialist for every skill that the experiment has.
#pragma once

#include <algorithm>

#include <somas/sdk/plugin.hpp>

class MyPlugin final : public somas::Specialization {
 public:
  static constexpr somas::About about{"my_plugin", "A generalist, and a specialist for each skill"};

  /// The initialisers are the defaults. The host checks the experiment against this list.
  struct Parameters {
    double common = 2;
    double best = 8;

    void describe(somas::Describe& d) {
      d("common", common, "Points of the generalist in every skill", {.minimum = 0});
      d("best", best,
        "Points of a specialist in its own skill; it has half of the common ones in "
        "the others",
        {.minimum = 0});
    }
  };

  explicit MyPlugin(const Parameters& parameters) : p_(parameters) {
    // What depends on several parameters is the constructor's to check.
    if (p_.best < p_.common)
      throw somas::ParameterError("best", "a specialist must not be worse than the generalist");
  }

  /// A tree without genes always grows alike. `skills` are the model's and those of all
  /// environments.
  void grow(somas::GenesView, std::span<const somas::SkillInfo> skills,
            somas::TreeSink& tree) const override {
    std::vector<double> points(skills.size());
    for (std::size_t s = 0; s < skills.size(); ++s) points[s] = within(skills[s], p_.common);
    somas::StateSpec state;
    state.name = "generalist";
    state.skills = points;
    tree.add(state);

    for (std::size_t own = 0; own < skills.size(); ++own) {
      const std::string name = "best_at_" + std::string(skills[own].name);
      for (std::size_t s = 0; s < skills.size(); ++s)
        points[s] = within(skills[s], s == own ? p_.best : p_.common / 2);
      state.name = name;
      state.parent = 0;  // the generalist
      state.skills = points;
      tree.add(state);  // copies what it is given
    }
  }

 private:
  static double within(const somas::SkillInfo& skill, double points) {
    return std::clamp(points, skill.spec.minimum, skill.spec.maximum);
  }

  Parameters p_;
};
