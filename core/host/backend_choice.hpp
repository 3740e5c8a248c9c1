// Where a command evaluates: its options, and what they make.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/evaluation/backend.hpp"
#include "core/run/terminal.hpp"

namespace somas::host {

struct BackendChoice {
  std::string backend = "processes";  ///< or "threads"
  unsigned workers = 0;               ///< 0: with the threads of their worlds one per processor
  unsigned threads = 0;               ///< --threads N: backend threads, N workers
  unsigned world_threads = 1;         ///< that share a large world
  std::uint64_t memory_mib = 0;       ///< of an evaluator process; 0: no limit
  std::uint64_t watchdog_seconds = 600;
};

/// Warnings go to the terminal, which must outlive it.
[[nodiscard]] std::unique_ptr<evaluation::Backend> make_backend(const BackendChoice& choice,
                                                                run::Terminal& terminal);

}  // namespace somas::host
