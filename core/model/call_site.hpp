// Which plugin a thread is in, for whoever has to say where it crashed or hangs: a signal handler,
// or another process that shares the memory.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace somas::model {

/// Plain memory; zeroes are a valid value.
struct CallSite {
  static constexpr std::uint64_t no_step = ~std::uint64_t{0};

  std::atomic<std::uint64_t> progress;  ///< counts steps begun
  std::uint64_t step;                   ///< of the simulation, or no_step
  char instance[64];                    ///< of the plugin, cut if longer; empty: in none
  char call[32];
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// Where the calls of the present thread are noted; null: nowhere.
inline constinit thread_local CallSite* watched_site = nullptr;

/// Notes a call into a plugin while it lives.
class PluginCall {
 public:
  PluginCall(std::string_view instance, std::string_view call,
             std::uint64_t step = CallSite::no_step) {
    CallSite* site = watched_site;
    if (site == nullptr) return;
    site->step = step;
    copy(call, site->call);
    copy(instance, site->instance);
  }
  ~PluginCall() {
    if (watched_site != nullptr) watched_site->instance[0] = 0;
  }
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

 private:
  template <std::size_t size>
  static void copy(std::string_view text, char (&to)[size]) {
    const std::size_t count = std::min(text.size(), size - 1);
    std::memcpy(to, text.data(), count);
    to[count] = 0;
  }
};

inline void note_progress() {
  if (watched_site != nullptr) watched_site->progress.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace somas::model
