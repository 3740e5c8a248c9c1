// One task, from its genomes to its result.
#pragma once

#include <functional>
#include <optional>

#include "core/evaluation/evaluator.hpp"
#include "core/model/simulation.hpp"

namespace somas::evaluation {

/// Sees the simulation after every step.
using StepObserver = std::function<void(const model::Simulation&)>;

/// Expresses the genomes and simulates them to the end. Nothing if `stop`, asked before every step,
/// ended it early. `witness` (may be null) is told what happens within the steps; what they take is
/// added to `profile` (may be null); `team` (may be null) shares them. Throws model::PluginFailure.
[[nodiscard]] std::optional<Result> simulate(const model::Ecosystem& ecosystem, const Task& task,
                                             StopToken stop = {}, const StepObserver& observe = {},
                                             model::Witness* witness = nullptr,
                                             model::Profile* profile = nullptr,
                                             model::Team* team = nullptr);

/// As simulate, but what a plugin throws (std::bad_alloc apart, which is the machine's fault) makes
/// a failed result of one attempt.
[[nodiscard]] std::optional<Result> attempt(const model::Ecosystem& ecosystem, const Task& task,
                                            StopToken stop = {}, model::Profile* profile = nullptr,
                                            model::Team* team = nullptr);

/// The same as simulate from where `simulation` is now.
[[nodiscard]] std::optional<Result> complete(model::Simulation& simulation, StopToken stop = {},
                                             const StepObserver& observe = {});

}  // namespace somas::evaluation
