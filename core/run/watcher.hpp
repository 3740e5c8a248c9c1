// Who wants to know how far a run is.
#pragma once

#include <cstdint>

#include "core/evolution/ranking.hpp"

namespace somas::run {

/// Called by the thread that coordinates the run.
class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual void begin_generation(std::uint64_t generation) = 0;
  /// `done` evaluations of this generation have their results.
  virtual void update(std::uint64_t done) = 0;
  virtual void end_generation(const evolution::Statistics& statistics) = 0;
};

}  // namespace somas::run
