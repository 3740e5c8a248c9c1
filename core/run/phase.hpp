// What a coordinator is doing, for people who look from outside (top -H, ps -L).
#pragma once

#include <pthread.h>

namespace somas::run {

/// Names the calling thread; at most 15 characters. A run goes through "select", "evaluate",
/// "commit" and "export". Not for the main thread, whose name is that of the process.
inline void enter_phase(const char* name) { ::pthread_setname_np(::pthread_self(), name); }

}  // namespace somas::run
