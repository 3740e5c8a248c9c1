// A simulation with a trace: what proves that two simulations were the same.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/model/simulation.hpp"
#include "core/recording/life_witness.hpp"

namespace somas::run {

/// One organism's life, alone or in company, step by step. An entry of a step tells the world after
/// it; the first entry is that of `first_step`.
struct LifeRecord {
  std::uint64_t first_step = 0;
  std::vector<std::string> states;                 ///< names, by index
  std::vector<std::uint64_t> hashes;               ///< of the whole world, by step
  std::vector<std::vector<std::uint32_t>> census;  ///< live cells, by state, then step
  Outcome outcome;
  double score = 0;
};

/// The task of one organism alone, at the origin.
[[nodiscard]] evaluation::Task single_task(const model::Genome& genome, std::uint64_t seed);

/// Sees the simulation after every step; must not change it.
using Observer = std::function<void(const model::Simulation&)>;

/// Simulates as an evaluation does; tells the life of the organism at place `own` of the roster.
/// Nothing if stopped early. `witness` (may be null) records all of it; `team` (may be null) shares
/// the steps. Throws model::PluginFailure, and what observer and witness throw.
[[nodiscard]] std::optional<LifeRecord> record_life(const model::Ecosystem& ecosystem,
                                                    const evaluation::Task& task, std::size_t own,
                                                    evaluation::StopToken stop = {},
                                                    const Observer& observer = {},
                                                    recording::LifeWitness* witness = nullptr,
                                                    model::Team* team = nullptr);

/// The same of an organism alone: of its single_task.
[[nodiscard]] std::optional<LifeRecord> record_life(const model::Ecosystem& ecosystem,
                                                    const model::Genome& genome, std::uint64_t seed,
                                                    evaluation::StopToken stop = {},
                                                    const Observer& observer = {});

/// The two halves of recording a life by hand: an empty one, and adding the step that is just over,
/// for the organism at place `own` of the roster.
[[nodiscard]] LifeRecord begin_life_record(const model::Tree& tree);
void observe_step(const model::Simulation& simulation, std::size_t own, LifeRecord& life);

/// The first step at which two recordings with the same first step differ: in a hash, in the cells
/// of a state, or because only one of them got that far. Nothing if they are equal.
[[nodiscard]] std::optional<std::uint64_t> first_difference(const LifeRecord& a,
                                                            const LifeRecord& b);

/// "step,<state>...,cells,hash", a line a step.
[[nodiscard]] std::string to_csv(const LifeRecord& life);

}  // namespace somas::run
