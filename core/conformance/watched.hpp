// Plugin instances whose every call is noted, so that whoever has to say where one crashed, hung or
// threw can name it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/model/call_site.hpp"
#include "core/plugins/library.hpp"

namespace somas::conformance {

/// Where the calls of all threads are counted, and those of the main thread noted; null: nowhere.
/// Set once, before the first call.
void watch_calls(model::CallSite* site);

/// How instances are made.
struct Making {
  plugins::PluginClass plugin;
  plugins::ParameterValue parameters;
  /// Exceptions are replaced by a std::runtime_error whose text begins with the call. Otherwise
  /// they pass as they are. (std::bad_alloc ends the process, see examiner_no_memory.)
  bool names_calls = true;
};

/// A new instance behind a watch. Precondition: the class is of that kind.
[[nodiscard]] std::unique_ptr<Environment> make_environment(const Making& making);
[[nodiscard]] std::unique_ptr<Specialization> make_specialization(const Making& making);
[[nodiscard]] std::unique_ptr<Controller> make_controller(const Making& making);
[[nodiscard]] std::unique_ptr<Fitness> make_fitness(const Making& making);

/// Seconds that calls of act, step, grow and observe have taken so far, in any thread.
[[nodiscard]] double seconds_in_steps();

}  // namespace somas::conformance
