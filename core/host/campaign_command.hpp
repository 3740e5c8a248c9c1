// Campaigns: what `run`, `resume` and `validate` do where there are replicates or a sweep.
#pragma once

#include "core/experiment/sweep.hpp"
#include "core/host/commands.hpp"
#include "core/run/terminal.hpp"

namespace somas::host {

/// `run` of a design, or its --dry-run. The exit code.
[[nodiscard]] int run_design(const RunCommand& command, const experiment::Design& design,
                             run::Terminal& terminal);

/// `resume` of a campaign's directory. The exit code.
[[nodiscard]] int resume_design(const ResumeCommand& command, run::Terminal& terminal);

/// `validate` of a design: loads all conditions and prints the plan.
[[nodiscard]] int validate_design(const ValidateCommand& command, const experiment::Design& design);

}  // namespace somas::host
