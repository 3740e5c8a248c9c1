/// @file
/// Environments: what surrounds the cells.
#pragma once

#include "somas/sdk/extension.hpp"
#include "somas/sdk/world.hpp"

namespace somas {

/// A plugin class `E` has `static constexpr About about`, a `Parameters` struct and a constructor
/// E(const Parameters&). Life: constructor -> declare, once -> connect, once -> begin, once a
/// simulation -> act, in each declared phase of every step. After connect one instance serves many
/// simulations, possibly on several threads: begin and act are const and keep all state in the
/// World. Exceptions become an error that names plugin, call and step; the simulation then ends.
class Environment : public Extensible {
 public:
  /// Says what there will be; the only call in which the instance may change, with connect. The
  /// argument is valid during the call; the handles that it gives are good for ever. Throws
  /// ParameterError for parameters that do not suit the world.
  virtual void declare(Declare& declare) = 0;
  /// What all instances declare is known now: take charge of their variable parameters. The
  /// argument is valid during the call.
  virtual void connect(Connections&) {}
  /// Before step 0; the founders are in place. Fills grids and tables of this simulation.
  virtual void begin(World&) const {}
  /// Once a step in each declared phase; in Phase::forces once a substep. `world` and all that it
  /// gives are valid during the call.
  virtual void act(Phase phase, World& world) const = 0;
};

}  // namespace somas
