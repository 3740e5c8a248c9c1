// Opening a run that ended, to go on with it.
#pragma once

#include <memory>

#include "core/experiment/experiment.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/runner.hpp"

namespace somas::run {

/// A run that can go on.
struct Resumption {
  experiment::Experiment experiment;
  std::unique_ptr<RunDirectory> directory;
};

/// Locks and verifies the run, compares plugins, experiment and host with those of its manifest,
/// and makes its files agree with its store. Throws as resume() does.
[[nodiscard]] Resumption reopen(const ResumeOptions& options, Terminal& terminal);

}  // namespace somas::run
