// Moments in the middle of a recorded life: finding them, and living on from there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/model/simulation.hpp"
#include "core/run/champion.hpp"
#include "core/run/life_record.hpp"

namespace somas::run {

/// A champion's world between two steps.
struct Moment {
  std::uint64_t step = 0;                     ///< the one that comes next
  std::optional<std::filesystem::path> file;  ///< the state file that it comes from
  std::vector<std::byte> world;
};

/// A simulation together with the phenotypes of its roster.
struct Life {
  std::vector<std::unique_ptr<const model::Phenotype>> phenotypes;
  std::unique_ptr<model::Simulation> simulation;
};

/// The champion in its world, with all its roster, from a moment on. Throws model::SnapshotError.
[[nodiscard]] Life live_from(const model::Ecosystem& ecosystem, const Champion& champion,
                             std::span<const std::byte> world);

/// The moment before `step` of a recorded life, from the latest state file that helps, simulating
/// the rest, which `team` (may be null) shares. Nothing where the life up to there is not the
/// recorded one. Throws UsageError for a step beyond the life and for a state file that is damaged
/// or of another life.
[[nodiscard]] std::optional<Moment> moment_before(std::uint64_t step,
                                                  const std::filesystem::path& run,
                                                  const Champion& champion,
                                                  const model::Ecosystem& ecosystem,
                                                  model::Team* team = nullptr);

/// The moment that a state file holds. Throws UsageError as above.
[[nodiscard]] Moment moment_in(const std::filesystem::path& file, const Champion& champion,
                               const model::Ecosystem& ecosystem);

/// Simulates `life` to its end. The record, of the organism at place `own` of the roster,
/// begins with the next step. `witness` (may be null) must have been told to the simulation.
[[nodiscard]] LifeRecord record_rest(Life& life, std::size_t own, const Observer& observer,
                                     recording::LifeWitness* witness = nullptr);

/// The part of a record from `step` on.
[[nodiscard]] LifeRecord rest_of(const LifeRecord& record, std::uint64_t step);

}  // namespace somas::run
