// What of a run is recorded: the block `record` of an experiment file.
#pragma once

#include <cstdint>

namespace somas::experiment {

/// Whose lives.
enum class Recorded { none, champions, all };

struct RecordSettings {
  Recorded what = Recorded::none;
  std::uint64_t every = 10;        ///< steps between frames
  std::uint64_t fields_every = 0;  ///< steps between frames with grids and morphogens; 0: `every`
  bool controller = true;          ///< whether frames hold what controllers read and wrote

  friend bool operator==(const RecordSettings&, const RecordSettings&) = default;
};

}  // namespace somas::experiment
