// Sees what happens within the steps of a simulation.
#pragma once

#include <cstdint>

#include "core/model/world_state.hpp"

namespace somas::model {

/// Called as things happen, by the simulation's thread; must not change anything. Cells are given
/// by their place in storage, which holds during the call only.
class Witness {
 public:
  virtual ~Witness() = default;
  /// The controllers have run (phase 3); the lanes of both matrices are the cells.
  virtual void controlled(const WorldState&, const FloatMatrix& inputs,
                          const FloatMatrix& outputs) = 0;
  /// By the cap on cells.
  virtual void division_refused(const WorldState&, std::uint32_t cell) = 0;
  /// `amount` > 0 arrived from one cell at another.
  virtual void ambrosia_passed(const WorldState&, std::uint32_t from, std::uint32_t to,
                               double amount) = 0;
  /// The cell is of its new state.
  virtual void specialized(const WorldState&, std::uint32_t cell, std::uint16_t from) = 0;
  virtual void born(const WorldState&, std::uint32_t daughter) = 0;
  /// The cell is about to be removed; CellStore::cause says why, no_cause: by a wound.
  virtual void died(const WorldState&, std::uint32_t cell) = 0;
};

}  // namespace somas::model
