// A moment of a champion's life as a file: a line of JSON that says whose it is, then the world's
// bytes (core/model/snapshot.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/champion.hpp"

namespace somas::run {

struct SavedState {
  std::string experiment;
  std::uint64_t generation = 0;
  std::uint64_t individual = 0;
  std::uint64_t seed = 0;        ///< of the simulation
  std::string genome;            ///< XXH3-128 of the champion's genes
  std::uint64_t step = 0;        ///< the one that comes next; at least 1
  std::uint64_t world_hash = 0;  ///< after the step before
  std::vector<std::byte> world;
};

/// RUN/states/gen-NNNN-step-NNNNNN.state; for the champion of a second population gen-NNNN-2-...
[[nodiscard]] std::filesystem::path state_path(const std::filesystem::path& run,
                                               std::uint64_t generation, std::uint32_t population,
                                               std::uint64_t step);

/// The file in RUN/states of the latest moment of a champion at or before `step`, if there is one.
[[nodiscard]] std::optional<std::filesystem::path> latest_state(const std::filesystem::path& run,
                                                                std::uint64_t generation,
                                                                std::uint32_t population,
                                                                std::uint64_t step);

/// A moment of this champion's life; `world` is its world before `step`.
[[nodiscard]] SavedState state_of(const Champion& champion, std::uint64_t step,
                                  std::uint64_t world_hash, std::vector<std::byte> world);

/// The file's bytes.
[[nodiscard]] std::string to_text(const SavedState& state);

/// Reads what to_text wrote; the world's bytes are not looked into. Throws UsageError that starts
/// with the file's name.
[[nodiscard]] SavedState read_state(const std::filesystem::path& file);

/// Throws UsageError, saying what differs, unless the state is of this champion and of a moment of
/// its record.
void check_owner(const SavedState& state, const Champion& champion, const std::string& origin);

}  // namespace somas::run
