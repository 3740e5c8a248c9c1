/// @file
/// The conformance check of fitness definitions.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "somas/sdk/fitness.hpp"
#include "somas/sdk/testing/declare.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/world.hpp"

namespace somas::testing {

/// How check_fitness looks at a fitness.
struct FitnessOptions {
  /// What the fitness is told of the experiment.
  WorldInfo info{.radius = 60, .max_steps = 3000, .substeps = 3, .time_step = 1.0 / 30};
  std::uint64_t steps = 40;      ///< that are observed
  Script script{};               ///< what the cells do meanwhile
  std::uint64_t outcomes = 200;  ///< that are scored
  std::uint64_t seed = 1;        ///< of the world and the outcomes
};

/// A new instance of the class that is checked, with its parameters.
using MakeFitness = std::function<std::unique_ptr<Fitness>()>;

namespace detail {

/// The single checks of a fitness; each throws what it finds.
class FitnessCheck {
 public:
  FitnessCheck(MakeFitness make, FitnessOptions options)
      : make_(std::move(make)), options_(std::move(options)) {}

  /// The checks, which keep `it`.
  [[nodiscard]] static Checks list(const std::shared_ptr<const FitnessCheck>& it) {
    return {
        {.law = "declare",
         .name = "declare",
         .remedy = "declare from the parameters alone; a fitness has no phases and no sensors",
         .body = [it] { it->declares_no_acts(); },
         .first = true},
        {.law = "objective",
         .name = "objective",
         .remedy = "return the same name, not empty, every time",
         .body = [it] { it->names_its_objective(); }},
        {.law = "score",
         .name = "score",
         .remedy = "compute a finite number from the Outcome alone, also for an organism that "
                   "lived no step",
         .body = [it] { it->scores(); }},
        {.law = "observe",
         .name = "observe",
         .remedy = "look at the world and leave it as it is; remember nothing from call to call",
         .body = [it] { it->observes(); }}};
  }

 private:
  [[nodiscard]] std::unique_ptr<Fitness> declared(Declared& declared) const {
    std::unique_ptr<Fitness> fitness = make_();
    TestDeclare declare(declared, options_.info, "fitness");
    fitness->declare(declare);
    return fitness;
  }
  [[nodiscard]] std::vector<Outcome> outcomes() const;
  void declares_no_acts() const;
  void names_its_objective() const;
  void scores() const;
  void observes() const;
  [[nodiscard]] std::vector<bool> watched(const Fitness& fitness, const Declared& declared) const;

  MakeFitness make_;
  FitnessOptions options_;
};

/// Nothing, everything, and what may come between.
inline std::vector<Outcome> FitnessCheck::outcomes() const {
  constexpr auto most = std::numeric_limits<std::uint32_t>::max();
  std::vector<Outcome> all(2);
  all.push_back({.survival = options_.info.max_steps, .censored = true});
  all.push_back({.survival = most,
                 .censored = true,
                 .divisions = most,
                 .specializations = most,
                 .refused_divisions = most,
                 .final_cells = most,
                 .peak_cells = most,
                 .cell_steps = 1e18});
  Rng rng(options_.seed, 0, 0, stable_key("outcome"), 0);
  for (std::uint64_t i = 0; i < options_.outcomes; ++i) {
    Outcome outcome;
    outcome.survival = rng.below(options_.info.max_steps + 1);
    outcome.censored = rng.chance(0.2);
    outcome.divisions = rng.below(1000);
    outcome.specializations = rng.below(1000);
    outcome.refused_divisions = rng.below(10);
    outcome.peak_cells = static_cast<std::uint32_t>(1 + rng.below(500));
    outcome.final_cells =
        outcome.censored ? static_cast<std::uint32_t>(1 + rng.below(outcome.peak_cells)) : 0;
    outcome.cell_steps = static_cast<double>(outcome.survival) * rng.uniform(1, outcome.peak_cells);
    all.push_back(outcome);
  }
  return all;
}

inline void FitnessCheck::declares_no_acts() const {
  Declared first, second;
  static_cast<void>(declared(first));
  static_cast<void>(declared(second));
  if (!first.acting.empty() || !first.sensors.empty())
    throw std::runtime_error("a fitness observes: it has no phases and no sensors");
  if (first.lines() != second.lines())
    throw std::runtime_error("a second instance declares something else");
}

inline void FitnessCheck::names_its_objective() const {
  Declared notes, notes_of_other;
  const std::unique_ptr<Fitness> fitness = declared(notes), other = declared(notes_of_other);
  if (fitness->objective().empty()) throw std::runtime_error("has no name");
  if (fitness->objective() != other->objective())
    throw std::runtime_error("a second instance names another one");
}

inline void FitnessCheck::scores() const {
  Declared notes, notes_of_other;
  const std::unique_ptr<Fitness> fitness = declared(notes), other = declared(notes_of_other);
  const std::vector<Outcome> all = outcomes();
  std::vector<double> expected, back(all.size());
  for (const Outcome& outcome : all) {
    expected.push_back(fitness->score(outcome));
    if (!std::isfinite(expected.back()))
      throw std::runtime_error(text_of(expected.back()) + " for an organism that lived " +
                               std::to_string(outcome.survival) + " steps is not finite");
  }
  for (std::size_t i = all.size(); i-- > 0;) back[i] = fitness->score(all[i]);
  if (back != expected) throw std::runtime_error("equal outcomes score differently");
  for (std::size_t i = 0; i < all.size(); ++i) back[i] = other->score(all[i]);
  if (back != expected) throw std::runtime_error("a second instance scores differently");
  std::vector<std::vector<double>> threaded(4, std::vector<double>(all.size()));
  on_threads(threaded.size(), [&](std::size_t t) {
    for (std::size_t i = 0; i < all.size(); ++i) threaded[t][i] = fitness->score(all[i]);
  });
  for (const std::vector<double>& scores_of_thread : threaded)
    if (scores_of_thread != expected)
      throw std::runtime_error("scores differ when several threads call");
}

/// What the fitness said of every step of one world.
inline std::vector<bool> FitnessCheck::watched(const Fitness& fitness,
                                               const Declared& declared) const {
  TestWorld world(options_.info, declared, options_.seed, options_.script, {});
  world.begin();
  std::vector<bool> said;
  while (world.step() < options_.steps) {
    world.advance();
    const Bytes before = world.save();
    said.push_back(fitness.observe(world));
    if (world.save() != before) throw std::runtime_error("changes the world");
  }
  return said;
}

inline void FitnessCheck::observes() const {
  Declared notes, notes_of_other;
  const std::unique_ptr<Fitness> fitness = declared(notes), other = declared(notes_of_other);
  const std::vector<bool> expected = watched(*fitness, notes);
  if (watched(*fitness, notes) != expected)
    throw std::runtime_error("stops another time in an equal world");
  if (watched(*other, notes_of_other) != expected)
    throw std::runtime_error("a second instance stops another time");
}

}  // namespace detail

/// The checks of check_fitness, one by one.
[[nodiscard]] inline Checks fitness_checks(const MakeFitness& make,
                                           const FitnessOptions& options = {}) {
  return detail::FitnessCheck::list(std::make_shared<const detail::FitnessCheck>(make, options));
}

/// Whether fitness definitions made by `make` keep the contract of fitness.hpp: an objective with a
/// name, no phases and no sensors, finite scores that hang on the outcome alone, and an `observe`
/// that leaves the world as it is and says the same of equal worlds.
[[nodiscard]] inline Failures check_fitness(const MakeFitness& make,
                                            const FitnessOptions& options = {}) {
  return detail::run(fitness_checks(make, options));
}

/// The same for a plugin class and its parameters.
template <class F>
[[nodiscard]] Failures check_fitness(
    const typename F::Parameters& parameters = typename F::Parameters(),
    const FitnessOptions& options = {}) {
  return check_fitness([&] { return std::make_unique<F>(parameters); }, options);
}

}  // namespace somas::testing
