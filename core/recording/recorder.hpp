// Turns a running simulation into a recording.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/recording/life_witness.hpp"
#include "core/recording/sink.hpp"

namespace somas::recording {

struct RecorderOptions {
  std::uint64_t every = 1;         ///< steps between frames; at least 1
  std::uint64_t fields_every = 1;  ///< steps between frames with grids and morphogens
  bool controller = true;          ///< whether frames hold the controller's inputs and outputs
};

/// One simulation's recorder. Hand it to evaluation::simulate as the witness, call `observe` after
/// every step (as the step observer does) and `finish` with the result:
///
///   Recorder recorder(ecosystem, 0, sink, provenance);
///   const auto result = evaluation::simulate(
///       ecosystem, task, stop, [&](const auto& s) { recorder.observe(s); }, &recorder);
///   if (result) recorder.finish(*result);
///
/// It only reads the simulation, which therefore runs as if unrecorded.
class Recorder final : public LifeWitness {
 public:
  /// The recording is about the organism at place `own_seat` of the roster. `ecosystem` (the
  /// simulation's) and `sink` must outlive this.
  Recorder(const model::Ecosystem& ecosystem, std::size_t own_seat, Sink& sink,
           Provenance provenance = {}, RecorderOptions options = {});

  void observe(const model::Simulation& simulation) override;
  void finish(const evaluation::Result& result) override;

  void controlled(const model::WorldState& world, const model::FloatMatrix& inputs,
                  const model::FloatMatrix& outputs) override;
  void division_refused(const model::WorldState& world, std::uint32_t cell) override;
  void ambrosia_passed(const model::WorldState& world, std::uint32_t from, std::uint32_t to,
                       double amount) override;
  void specialized(const model::WorldState& world, std::uint32_t cell, std::uint16_t from) override;
  void born(const model::WorldState& world, std::uint32_t daughter) override;
  void died(const model::WorldState& world, std::uint32_t cell) override;

 private:
  void begin(const model::WorldState& world);
  void tell(const model::WorldState& world, std::uint32_t cell, EventKind kind,
            std::uint16_t from = none, std::uint16_t cause = none);
  void summarize(const model::WorldState& world, std::uint64_t step);
  void take_frame(const model::WorldState& world, std::uint64_t step, bool fields);
  void take_controller(const model::CellStore& cells);
  void take_fields(const model::WorldState& world);

  const model::Ecosystem& ecosystem_;
  std::size_t own_seat_;
  Sink& sink_;
  RecorderOptions options_;
  Header header_;
  bool begun_ = false;
  std::uint64_t steps_done_ = 0;

  std::vector<std::vector<std::uint32_t>> squares_in_world_;         ///< by grid
  std::map<std::array<std::uint16_t, 4>, double> flux_;              ///< of the step so far
  std::vector<std::pair<std::uint16_t, std::uint64_t>> controlled_;  ///< (organism, id) of lanes
  std::vector<std::vector<float>> inputs_, outputs_;                 ///< by channel, then lane
  Summary summary_;
  Frame frame_;
};

}  // namespace somas::recording
