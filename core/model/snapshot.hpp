// A world between two steps as bytes: saved and restored to the last bit, whenever.
//
// Layout, little-endian; a text is its length (32 bits) and its bytes:
//
//   "SOMASNAP", format version (32 bits)
//   vocabulary: what the experiment declares, as pairs of texts
//   seed, steps, finished; organisms; cells, column by column; contacts; grids; tables; scalars;
//   parameters that somebody varies
//   XXH3-64 of all that comes before
//
// Cells stand in canonical order (organism, id), so equal worlds give equal bytes. What can be
// derived (ranges, order, pairs of neighbours, springs) is not saved, but built anew.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/model/simulation.hpp"

namespace somas::model {

inline constexpr std::uint32_t snapshot_format = 1;

/// Bytes that cannot be restored: no snapshot, damaged, or of another experiment or roster.
class SnapshotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// All that the next step depends on, and what has been counted so far. Restored by a constructor
/// of Simulation, in an ecosystem with the same vocabulary; other parameters may differ, and hold
/// from then on.
[[nodiscard]] std::vector<std::byte> save(const Simulation& simulation);

/// What must agree between the ecosystem of a snapshot and that of its restoration: names of
/// skills, sensors, cell values, scalars, grids with their shapes, tables with their columns,
/// causes, hazards, varied parameters, resources, morphogens.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> vocabulary(
    const Ecosystem& ecosystem);

}  // namespace somas::model
