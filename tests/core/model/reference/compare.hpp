// Holds a life in the engine to the same life in the reference, bit for bit.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/model/simulation.hpp"
#include "tests/core/model/reference/life.hpp"

namespace somas::reference {

/// The first thing in which two worlds differ.
struct Difference {
  std::uint64_t step = 0;  ///< the one after which they differ; 0: step 0 or the start
  std::string what;        ///< "cell 3 of organism 0: vx"
  std::string engine, reference;

  [[nodiscard]] std::string text() const;
};

/// Everything that a world holds: all columns of cells, contacts, memories, storage order, fields,
/// grids, tables, scalars, parameters, books, outcomes, deaths by cause. Numbers are equal when
/// their bits are, or when both are NaN.
[[nodiscard]] std::optional<Difference> compare(const model::Simulation& simulation,
                                                const World& world);

/// An engine's life and the reference's, side by side.
class Twins {
 public:
  Twins(const model::Ecosystem& ecosystem, std::span<const model::RosterEntry> roster,
        std::uint64_t seed);

  [[nodiscard]] model::Simulation& engine() { return engine_; }
  [[nodiscard]] World& reference() { return reference_; }
  /// Copies the engine's present state into the reference: after a test changed it.
  void adopt();
  /// One step of both.
  [[nodiscard]] std::optional<Difference> step();
  /// Up to so many steps, or until both lives end.
  [[nodiscard]] std::optional<Difference> run(std::uint64_t steps);

 private:
  model::Simulation engine_;
  World reference_;
};

/// Lives the same life in the engine and in the reference, comparing at the start and after every
/// step, until it ends or for so many steps. `events` (may be null) gets what happened added.
[[nodiscard]] std::optional<Difference> compare_lives(const model::Ecosystem& ecosystem,
                                                      std::span<const model::RosterEntry> roster,
                                                      std::uint64_t seed, std::uint64_t steps,
                                                      Events* events = nullptr);

}  // namespace somas::reference
