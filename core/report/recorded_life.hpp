// Recordings as subjects of figures and movies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "core/recording/recording.hpp"
#include "core/report/figure.hpp"

namespace somas::report {

/// Whether a RUN on the command line is a recording instead of a run directory: any regular file.
[[nodiscard]] bool is_recording(const std::filesystem::path& run);

/// What is known of a recorded life before it is drawn.
struct RecordedLife {
  recording::Header header;
  std::vector<std::uint64_t> frames;  ///< their steps, ascending
  std::vector<std::uint64_t> fields;  ///< of these, with grids and morphogens
  recording::Ending ending;
};
/// Throws recording::FileError.
[[nodiscard]] RecordedLife look_into(const std::filesystem::path& file);

/// The seed of the run is that of the experiment in the recording.
[[nodiscard]] Subject subject_of(const RecordedLife& life);

using FrameVisitor = std::function<void(const recording::Header&, const recording::Frame&)>;
/// Reads a file frame by frame. Throws recording::FileError, and what `visit` throws.
void each_frame(const std::filesystem::path& file, const FrameVisitor& visit);

}  // namespace somas::report
