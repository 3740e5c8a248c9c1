// The evaluator: a process that does one simulation at a time for a coordinator, so that what
// crashes in a plugin takes nothing else along.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/model/call_site.hpp"

namespace somas::evaluation {

/// The first word of the command line of an evaluator; no subcommand for people.
inline constexpr const char* evaluator_command = "evaluator-process";

/// Memory that evaluator and supervisor share, so that the latter can tell what the former did when
/// it died. Zeroes are a valid value.
struct EvaluatorPage {
  std::atomic<std::uint64_t> task;  ///< id of the one that runs; 0: none
  std::atomic<bool> busy;           ///< not waiting for a message
  model::CallSite site;
};

inline constexpr int evaluator_socket = 3;  ///< descriptors of the evaluator
inline constexpr int evaluator_page = 4;

/// How an evaluator says why it ends by itself.
enum EvaluatorExit : int {
  evaluator_released = 0,    ///< the coordinator has gone
  evaluator_spent = 75,      ///< a plugin threw: a fresh process is to go on
  evaluator_no_memory = 76,  ///< std::bad_alloc
};

/// Serves until the coordinator goes; never returns to plugins' destructors. `arguments`: the id of
/// the parent process, the limit of memory in MiB (0: none), threads that share a large world.
[[noreturn]] void serve_evaluations(const std::vector<std::string>& arguments);

}  // namespace somas::evaluation
