// How a command that ran an experiment ends.
#pragma once

#include "core/run/runner.hpp"

namespace somas::host {

/// Prints the last line, unless quiet; the exit code.
[[nodiscard]] int end_run(const run::RunReport& report, bool quiet);

/// The exit code of a command that a signal stopped.
[[nodiscard]] int exit_code_of_signal(int signal);

}  // namespace somas::host
