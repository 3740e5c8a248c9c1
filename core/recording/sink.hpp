// Who receives a recording.
#pragma once

#include <utility>

#include "core/recording/recording.hpp"

namespace somas::recording {

/// Calls come in the order of the life: begin; then, of every step, its events, its summary and, if
/// it is due, its frame; finish. A life that is cut short has no finish. References hold during the
/// call. What a sink throws ends the recording and reaches whoever records.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void begin(const Header& header) = 0;
  virtual void event(const Event& event) = 0;
  virtual void summary(const Summary& summary) = 0;
  virtual void frame(const Frame& frame) = 0;
  virtual void finish(const Ending& ending) = 0;
};

/// Keeps everything.
class Collector final : public Sink {
 public:
  void begin(const Header& header) override { recording_.header = header; }
  void event(const Event& event) override { recording_.events.push_back(event); }
  void summary(const Summary& summary) override { recording_.summaries.push_back(summary); }
  void frame(const Frame& frame) override { recording_.frames.push_back(frame); }
  void finish(const Ending& ending) override { recording_.ending = ending; }

  [[nodiscard]] const Recording& recording() const { return recording_; }
  [[nodiscard]] Recording take() { return std::move(recording_); }

 private:
  Recording recording_;
};

/// Hands a recording on as the recorder did.
void play(const Recording& recording, Sink& sink);

}  // namespace somas::recording
