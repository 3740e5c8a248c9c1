// The recordings of a run: recordings/gen-0003.h5, a file per recorded life.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/evaluation/stop.hpp"
#include "core/evolution/heredity.hpp"
#include "core/experiment/experiment.hpp"
#include "core/recording/recorder.hpp"
#include "core/run/champion.hpp"

namespace somas::run {

/// recordings/gen-NNNN.h5; of the second population recordings/gen-NNNN-2.h5.
[[nodiscard]] std::filesystem::path recording_path(const std::filesystem::path& run,
                                                   std::uint64_t generation,
                                                   std::uint32_t population = 1);
/// recordings/gen-NNNN-id-ID.h5; of the second population recordings/gen-NNNN-2-id-ID.h5.
[[nodiscard]] std::filesystem::path individual_recording_path(const std::filesystem::path& run,
                                                              std::uint64_t generation,
                                                              std::uint32_t population,
                                                              std::uint64_t id);

/// What a recording says of where it comes from. `run` is the run directory.
[[nodiscard]] recording::Provenance provenance_of(const Champion& champion,
                                                  const evolution::Heredity& heredity,
                                                  const experiment::Experiment& experiment,
                                                  const std::filesystem::path& run);

/// What of a life an experiment wants recorded.
[[nodiscard]] recording::RecorderOptions recorder_options(
    const experiment::RecordSettings& settings);

/// Simulates lives again and records them as the experiment's `record` says. A file is written
/// whole, after its life, or not at all.
class Recordings {
 public:
  /// All must outlive this. `world_threads` share a large world.
  Recordings(const experiment::Experiment& experiment, const evolution::Heredity& heredity,
             std::filesystem::path run, unsigned world_threads = 1)
      : experiment_(experiment), heredity_(heredity), run_(std::move(run)), team_(world_threads) {}

  /// A champion's life, recorded or not. Nothing if stopped. Throws WriteError.
  [[nodiscard]] std::optional<LifeRecord> champion(const Champion& champion,
                                                   evaluation::StopToken stop);
  /// Whether everybody's life is to be recorded, by `individual`.
  [[nodiscard]] bool of_all() const { return experiment_.record.what == experiment::Recorded::all; }
  /// An individual's life; `individual` says who, as a champion does. False if stopped. Throws
  /// WriteError.
  [[nodiscard]] bool individual(const Champion& individual, evaluation::StopToken stop);

 private:
  [[nodiscard]] std::optional<LifeRecord> live(const Champion& who,
                                               const std::filesystem::path& file,
                                               evaluation::StopToken stop);

  const experiment::Experiment& experiment_;
  const evolution::Heredity& heredity_;
  std::filesystem::path run_;
  model::Team team_;
};

}  // namespace somas::run
