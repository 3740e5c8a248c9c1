// A request to stop, seen by all who work on a run.
#pragma once

#include <atomic>

namespace somas::evaluation {

/// Refers to a flag that somebody (a signal handler, say) sets; copies are cheap. A token without a
/// flag never stops. May be asked from any thread; the flag must outlive the token.
class StopToken {
 public:
  StopToken() = default;
  explicit StopToken(const std::atomic<bool>& flag) : flag_(&flag) {}
  [[nodiscard]] bool stop_requested() const {
    return flag_ != nullptr && flag_->load(std::memory_order_relaxed);
  }

 private:
  const std::atomic<bool>* flag_ = nullptr;
};

}  // namespace somas::evaluation
