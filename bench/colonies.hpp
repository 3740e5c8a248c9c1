// Experiment 1's world at any size: as many colonies of the champion as make up the cells, each a
// copy of the recorded life at a step of its prime.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/experiment/experiment.hpp"
#include "core/model/simulation.hpp"

namespace somas::bench {

/// Overrides of experiment 1 that give a world of `cells` cells what the recorded life's world
/// gives its own: morphogen squares, nutrient patches and area grow with the cells, the radius and
/// the edges of the grids with their root; the particles launched keep the number in flight.
[[nodiscard]] std::vector<std::string> scaled_world(std::uint32_t cells);

/// One organism of `cells` cells, alive: births, deaths, specializations, hits go on as they do in
/// the recorded life, since every colony has its cells with all they hold, its morphogens, its
/// nutrients and its particles in flight. The last colony is cut down to its inner cells and a part
/// of its particles. Ids follow the time of birth: the colonies' n-th born come one after another,
/// so neighbours are far apart in canonical order, as in a life that long. The colonies are spread
/// evenly over a square.
class Colonies {
 public:
  explicit Colonies(std::uint32_t cells);

  [[nodiscard]] model::Simulation& simulation() { return *simulation_; }
  [[nodiscard]] const experiment::Experiment& experiment() const { return experiment_; }
  [[nodiscard]] const model::WorldState& start() const { return start_; }
  /// Back to the start, a few steps after the copies were made.
  void rewind() { simulation_->mutable_state() = start_; }
  /// All memory that the world takes, with what the steps need beside its state.
  [[nodiscard]] std::size_t heap_bytes() const { return heap_bytes_; }

 private:
  std::size_t heap_before_;
  experiment::Experiment experiment_;
  model::Phenotype phenotype_;
  std::unique_ptr<model::Simulation> simulation_;
  std::size_t heap_bytes_ = 0;
  model::WorldState start_;
};

/// The last Colonies asked for, if of that size, else new ones in their place; rewound.
[[nodiscard]] Colonies& colonies_of(std::uint32_t cells);

/// Bytes of the state of the cells: all columns but the controller's memory, contacts, order.
[[nodiscard]] std::size_t state_bytes(const model::WorldState& world);

}  // namespace somas::bench
