#include "core/report/recorded_life.hpp"

#include <charconv>
#include <string_view>
#include <system_error>

#include "core/recording/file.hpp"

namespace somas::report {
namespace {

/// Listens to a file for what the steps and the end are.
class Listener final : public recording::Sink {
 public:
  void begin(const recording::Header& header) override { life.header = header; }
  void event(const recording::Event&) override {}
  void summary(const recording::Summary&) override {}
  void frame(const recording::Frame& frame) override {
    life.frames.push_back(frame.step);
    if (frame.has_fields) life.fields.push_back(frame.step);
  }
  void finish(const recording::Ending& ending) override { life.ending = ending; }

  RecordedLife life;
};

class FrameReader final : public recording::Sink {
 public:
  explicit FrameReader(const FrameVisitor& visit) : visit_(visit) {}
  void begin(const recording::Header& header) override { header_ = header; }
  void event(const recording::Event&) override {}
  void summary(const recording::Summary&) override {}
  void frame(const recording::Frame& frame) override { visit_(header_, frame); }
  void finish(const recording::Ending&) override {}

 private:
  const FrameVisitor& visit_;
  recording::Header header_;
};

// "seed: 1" of the first level; 0 where there is none.
std::uint64_t seed_in(std::string_view yaml) {
  constexpr std::string_view key = "seed: ";
  std::uint64_t seed = 0;
  for (std::size_t at = 0; at < yaml.size();) {
    const std::size_t end = std::min(yaml.find('\n', at), yaml.size());
    const std::string_view line = yaml.substr(at, end - at);
    if (line.starts_with(key))
      std::from_chars(line.data() + key.size(), line.data() + line.size(), seed);
    at = end + 1;
  }
  return seed;
}

}  // namespace

bool is_recording(const std::filesystem::path& run) {
  std::error_code error;
  return std::filesystem::is_regular_file(run, error);
}

RecordedLife look_into(const std::filesystem::path& file) {
  Listener listener;
  recording::read(file, listener);
  return std::move(listener.life);
}

Subject subject_of(const RecordedLife& life) {
  const recording::Provenance& from = life.header.provenance;
  const Outcome& outcome = life.ending.outcomes.at(life.header.own);
  return {.experiment = from.experiment,
          .run = from.run,
          .seed = seed_in(from.resolved_yaml),
          .generation = from.generation,
          .population = from.population,
          .individual = from.individual,
          .origin = from.origin,
          .world_seed = life.header.seed,
          .survival = outcome.survival,
          .censored = outcome.censored};
}

void each_frame(const std::filesystem::path& file, const FrameVisitor& visit) {
  FrameReader reader(visit);
  recording::read(file, reader);
}

}  // namespace somas::report
