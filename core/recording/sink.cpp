#include "core/recording/sink.hpp"

namespace somas::recording {

void play(const Recording& recording, Sink& sink) {
  sink.begin(recording.header);
  auto event = recording.events.begin();
  auto frame = recording.frames.begin();
  for (const Summary& summary : recording.summaries) {
    for (; event != recording.events.end() && event->step <= summary.step; ++event)
      sink.event(*event);
    sink.summary(summary);
    for (; frame != recording.frames.end() && frame->step <= summary.step; ++frame)
      sink.frame(*frame);
  }
  for (; event != recording.events.end(); ++event) sink.event(*event);
  sink.finish(recording.ending);
}

}  // namespace somas::recording
