/// @file
/// Controllers: what turns a cell's inputs into its outputs.
#pragma once

#include <cstdint>
#include <memory>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/heritable.hpp"

namespace somas {

/// Cells of one (organism, state), all or some, as one contiguous range of lanes.
/// in: Layout::input_channels rows; out: one row per Layout::outputs; memory: memory_per_cell rows.
struct Batch {
  std::uint32_t count = 0;     ///< cells: the lanes of each matrix
  std::uint16_t organism = 0;  ///< place of its key in the roster's order of keys
  std::uint16_t state = 0;     ///< of all its cells: index into Layout::states
  Matrix<const float> in;      ///< what the cells sense, mostly in [0, 1]; never NaN
  Matrix<float> memory;        ///< host-owned, zero at the founder's birth, copied at division
  Matrix<float> out;           ///< write every channel; values outside [0, 1] are clamped by the
                               ///< host, which still ranks saturated actions by the unclamped value
};

/// An expressed genome: immutable, called concurrently on disjoint batches, even of one simulation.
class Program : public Extensible {
 public:
  /// Rows of Batch::memory, the same every time.
  [[nodiscard]] virtual std::uint32_t memory_per_cell() const = 0;
  /// Initialises the memory of a founder (which the host has zeroed).
  virtual void start(const Batch&) const {}
  /// One controller step of every lane. No allocation, no lane may depend on another.
  virtual void step(const Batch& batch) const = 0;
};

/// Makes programs out of genes. A plugin class has `about`, `Parameters` and a constructor from
/// them. Life: constructor -> for every genome, from any thread, at once for several: calls of
/// heritable(), and express. An exception becomes an error that names controller and call; the run
/// ends.
class Controller : public Extensible {
 public:
  /// The genes' operators; owned by this instance, the same one every time.
  [[nodiscard]] virtual const Heritable& heritable() const = 0;
  /// Compiles genes that fit `layout` into a program. The caller owns it and destroys it before
  /// this instance.
  [[nodiscard]] virtual std::unique_ptr<Program> express(GenesView genes,
                                                         const Layout& layout) const = 0;
};

}  // namespace somas
