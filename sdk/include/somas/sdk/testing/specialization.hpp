/// @file
/// The conformance check of specialization trees.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "somas/sdk/specialization.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/heritable.hpp"

namespace somas::testing {

/// How check_specialization looks at a specialization.
struct SpecializationOptions {
  HeritableOptions heritable{};   ///< for trees that evolve
  std::uint64_t mutations = 500;  ///< in a row, each of which must give a tree again
};

/// A new instance of the class that is checked, with its parameters.
using MakeSpecialization = std::function<std::unique_ptr<Specialization>()>;

/// A state that a tree emitted, with its own copies.
struct GrownState {
  std::string name;                     ///< StateSpec::name
  std::uint64_t key = 0;                ///< derived from the name when the tree gives 0
  std::uint16_t parent = no_state;      ///< StateSpec::parent
  double mass = 0;                      ///< StateSpec::mass
  double radius = 0;                    ///< StateSpec::radius
  double stiffness = 0;                 ///< StateSpec::stiffness
  double adhesion = 0;                  ///< StateSpec::adhesion
  double adhesion_range = 0;            ///< StateSpec::adhesion_range
  std::vector<double> skills{};         ///< StateSpec::skills
  double motility = 0;                  ///< StateSpec::motility
  std::uint32_t motility_signal = 0;    ///< StateSpec::motility_signal
  std::vector<double> adhesion_with{};  ///< -1: the mean of both
  std::array<double, 4> thresholds{};   ///< of quiescence, division, specialization, apoptosis
  /// Whether all members are equal.
  bool operator==(const GrownState&) const = default;
};

/// Takes what the host takes; throws std::runtime_error, naming the state, for what it refuses.
class TestTreeSink final : public TreeSink {
 public:
  /// For a world with these skills.
  explicit TestTreeSink(std::span<const SkillInfo> skills) : skills_(skills) {}

  void add(const StateSpec& spec) override {
    const std::string name(spec.name);
    const auto require = [&](bool fine, const std::string& what) {
      if (!fine) throw std::runtime_error("state '" + name + "': " + what);
    };
    const bool root = states.empty();
    const auto at_least = [](double x, double least) { return std::isfinite(x) && x >= least; };
    require(!name.empty(), "a state needs a name");
    require(root == (spec.parent == no_state), "one state, the first, is the root");
    require(root || spec.parent < states.size(), "its parent must come before it");
    require(at_least(spec.mass, 0) && spec.mass > 0, "the mass must be positive");
    require(at_least(spec.radius, 0) && spec.radius > 0, "the radius must be positive");
    require(at_least(spec.stiffness, 0), "the stiffness must not be negative");
    require(at_least(spec.adhesion, 0), "the adhesion must not be negative");
    require(at_least(spec.adhesion_range, 1), "the adhesion range must be at least 1");
    require(spec.skills.size() == skills_.size(), "one value is needed for every skill");
    for (std::size_t i = 0; i < skills_.size(); ++i)
      require(at_least(spec.skills[i], skills_[i].spec.minimum) &&
                  spec.skills[i] <= skills_[i].spec.maximum,
              "the skill '" + std::string(skills_[i].name) + "' is out of its range");
    check_behaviour(spec);
    GrownState state;
    state.name = name;
    state.key = spec.key != 0 ? spec.key : stable_key(name);
    state.parent = spec.parent;
    state.mass = spec.mass;
    state.radius = spec.radius;
    state.stiffness = spec.stiffness;
    state.adhesion = spec.adhesion;
    state.adhesion_range = spec.adhesion_range;
    state.skills.assign(spec.skills.begin(), spec.skills.end());
    state.motility = spec.motility;
    state.motility_signal = spec.motility_signal;
    for (const double strength : spec.adhesion_with)
      state.adhesion_with.push_back(std::isnan(strength) ? -1 : strength);
    state.thresholds = thresholds_of(spec);
    require(names_.insert(name).second, "the name is taken");
    require(keys_.insert(state.key).second, "the key is taken");
    states.push_back(std::move(state));
  }

  /// As many as the reference world's.
  [[nodiscard]] std::uint32_t morphogens() const override { return 3; }

  std::vector<GrownState> states;  ///< that were added, in order

 private:
  static std::array<double, 4> thresholds_of(const StateSpec& spec) {
    return {spec.quiescence_threshold, spec.division_threshold, spec.specialization_threshold,
            spec.apoptosis_threshold};
  }
  void check_behaviour(const StateSpec& spec) const {
    const auto require = [&](bool fine, const char* what) {
      if (!fine) throw std::runtime_error("state '" + std::string(spec.name) + "': " + what);
    };
    require(std::isfinite(spec.motility), "motility must be a finite number");
    require(spec.motility == 0 || spec.motility_signal < morphogens(),
            "motility_signal names a morphogen that the world does not have");
    require(spec.adhesion_with.size() <= states.size(),
            "adhesion_with is for the states before it only");
    for (const double strength : spec.adhesion_with)
      require(std::isnan(strength) || (std::isfinite(strength) && strength >= 0),
              "an adhesion to another state must be finite and not negative");
    for (const double threshold : thresholds_of(spec))
      require(threshold >= 0 && threshold <= 1, "thresholds of actions are from 0 to 1");
  }

  std::span<const SkillInfo> skills_;
  std::set<std::string> names_;
  std::set<std::uint64_t> keys_;
};

namespace detail {

/// The single checks of a specialization; each throws what it finds.
class SpecializationCheck {
 public:
  SpecializationCheck(MakeSpecialization make, std::span<const SkillInfo> skills,
                      SpecializationOptions options)
      : make_(std::move(make)), skills_(skills), options_(options) {}

  /// The checks, which keep `it`.
  [[nodiscard]] static Checks list(const std::shared_ptr<const SpecializationCheck>& it);

 private:
  using States = std::vector<GrownState>;

  /// An instance that has been told the skills, by views that are valid during the call only.
  [[nodiscard]] std::unique_ptr<Specialization> declared() const {
    std::unique_ptr<Specialization> made = make_();
    std::vector<std::string> names;
    for (const SkillInfo& skill : skills_) names.emplace_back(skill.name);
    std::vector<SkillInfo> views;
    for (std::size_t i = 0; i < names.size(); ++i) views.push_back({names[i], skills_[i].spec});
    made->declare(views);
    return made;
  }
  [[nodiscard]] States grow(const Specialization& tree, GenesView genes) const {
    TestTreeSink sink(skills_);
    tree.grow(genes, skills_, sink);
    if (sink.states.empty()) throw std::runtime_error("the tree has no states");
    return std::move(sink.states);
  }
  [[nodiscard]] Genes random(const Specialization& tree, std::uint64_t number) const {
    Rng rng(options_.heritable.seed, 0, 0, stable_key("tree"), number);
    Genes genes;
    if (const Heritable* heritable = tree.heritable()) {
      heritable->random({}, rng, genes);
      for (std::uint64_t i = 0; i < 10 * number; ++i) heritable->mutate({}, rng, genes);
    }
    return genes;
  }
  void grows_the_same() const;
  void keeps_growing(const Specialization& tree, const Heritable& heritable) const;

  MakeSpecialization make_;
  std::span<const SkillInfo> skills_;
  SpecializationOptions options_;
};

inline Checks SpecializationCheck::list(const std::shared_ptr<const SpecializationCheck>& it) {
  Checks checks = {{.law = "declare",
                    .name = "declare",
                    .remedy = "copy what you need of the skills; what declare throws ends a run",
                    .body = [it] { static_cast<void>(it->declared()); },
                    .first = true}};
  // What evolves, an instance has to say.
  std::shared_ptr<Specialization> tree;
  try {
    tree = it->declared();
  } catch (...) {
    return checks;
  }
  checks.push_back({.law = "grow",
                    .name = "grow",
                    .remedy = "emit the root first, parents before children, names and keys once, "
                              "every number in the range of specialization.hpp, from the "
                              "parameters and genes alone",
                    .body = [it] { it->grows_the_same(); }});
  const Heritable* heritable = tree->heritable();
  if (heritable == nullptr) return checks;
  static const Layout none{};
  for (Check& law : heritable_checks(*heritable, std::span(&none, 1), it->options_.heritable)) {
    // The genes' operators live as long as the tree.
    law.body = [tree, body = std::move(law.body)] { body(); };
    law.scope = "genes";
    checks.push_back(std::move(law));
  }
  checks.push_back({.law = "grow after mutations",
                    .name = "grow after mutations",
                    .remedy = "mutate and cross must leave genes that give a tree: undo, or do not "
                              "do, what would not",
                    .body = [it, tree, heritable] { it->keeps_growing(*tree, *heritable); },
                    .needs = {"grow", "random and mutate", "cross"}});
  return checks;
}

inline void SpecializationCheck::grows_the_same() const {
  const std::unique_ptr<Specialization> tree = declared(), other = declared();
  constexpr std::size_t genomes = 4;
  std::vector<States> expected(genomes), threaded(genomes);
  for (std::size_t i = 0; i < genomes; ++i) expected[i] = grow(*tree, random(*tree, i));
  for (std::size_t i = genomes; i-- > 0;) {
    if (grow(*tree, random(*tree, i)) != expected[i])
      throw std::runtime_error("equal genes give another tree the second time");
    if (grow(*other, random(*other, i)) != expected[i])
      throw std::runtime_error("equal genes give another tree in a second instance");
  }
  on_threads(genomes, [&](std::size_t i) { threaded[i] = grow(*tree, random(*tree, i)); });
  if (threaded != expected)
    throw std::runtime_error("equal genes give another tree when several threads call");
}

/// A long walk of mutations, and children of what lies on it: every one must give a tree.
inline void SpecializationCheck::keeps_growing(const Specialization& tree,
                                               const Heritable& heritable) const {
  Rng rng(options_.heritable.seed, 0, 0, stable_key("walk"), 0);
  Genes genes, child;
  heritable.random({}, rng, genes);
  Genes ancestor = genes;
  for (std::uint64_t i = 0; i < options_.mutations; ++i) {
    heritable.mutate({}, rng, genes);
    try {
      heritable.check({}, genes);
      static_cast<void>(grow(tree, genes));
      heritable.cross({}, ancestor, genes, rng, child);
      static_cast<void>(grow(tree, child));
    } catch (const std::exception& error) {
      throw std::runtime_error("mutation " + std::to_string(i + 1) + ": " + error.what());
    }
    if (i % 20 == 19) ancestor = child;
  }
}

}  // namespace detail

/// The checks of check_specialization, one by one. They make an instance to see whether it evolves;
/// `skills` must outlive them.
[[nodiscard]] inline Checks specialization_checks(const MakeSpecialization& make,
                                                  std::span<const SkillInfo> skills,
                                                  const SpecializationOptions& options = {}) {
  return detail::SpecializationCheck::list(
      std::make_shared<const detail::SpecializationCheck>(make, skills, options));
}

/// Whether specializations made by `make` keep the contract of specialization.hpp when there are
/// `skills` (as the host lists them: the model's capacity, diffusion and energy_efficiency, then
/// the environments'): trees that the host takes (the root first, parents before children, names
/// and keys unique, every number in its range), the same for equal genes; and, if the tree evolves,
/// the laws of heritable.hpp and a tree from all genes that fit.
[[nodiscard]] inline Failures check_specialization(const MakeSpecialization& make,
                                                   std::span<const SkillInfo> skills,
                                                   const SpecializationOptions& options = {}) {
  return detail::run(specialization_checks(make, skills, options));
}

/// The same for a plugin class and its parameters.
template <class S>
[[nodiscard]] Failures check_specialization(const typename S::Parameters& parameters,
                                            std::span<const SkillInfo> skills,
                                            const SpecializationOptions& options = {}) {
  return check_specialization([&] { return std::make_unique<S>(parameters); }, skills, options);
}

}  // namespace somas::testing
