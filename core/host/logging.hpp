// Log messages share the terminal with the progress line.
#pragma once

#include "core/run/terminal.hpp"

namespace somas::host {

/// Sends spdlog's default logger to `terminal`, which must live until the process ends.
void log_to(run::Terminal& terminal);

}  // namespace somas::host
