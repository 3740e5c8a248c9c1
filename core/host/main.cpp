// somas-host: the command line of SOMAS. Chooses a command and turns what it throws into an exit
// code; everything else happens in the rooms below.
#include <cerrno>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/conformance/examiner.hpp"
#include "core/conformance/report.hpp"
#include "core/evaluation/cluster.hpp"
#include "core/evaluation/crash_report.hpp"
#include "core/evaluation/evaluator.hpp"
#include "core/evaluation/evaluator_process.hpp"
#include "core/experiment/experiment.hpp"
#include "core/host/command_line.hpp"
#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/host/logging.hpp"
#include "core/recording/file.hpp"
#include "core/run/errors.hpp"

namespace somas::host {
namespace {

int run_command(const Command& command, run::Terminal& terminal) {
  return std::visit(
      [&](const auto& chosen) {
        if constexpr (std::is_same_v<std::decay_t<decltype(chosen)>, Done>)
          return chosen.exit_code;
        else
          return execute(chosen, terminal);
      },
      command);
}

int complain(run::Terminal& terminal, const std::string& what, int exit_code) {
  terminal.line("somas-host: " + what);
  return exit_code;
}

int guarded_main(const std::vector<std::string>& arguments, run::Terminal& terminal) {
  try {
    return run_command(parse_command_line(arguments), terminal);
  } catch (const experiment::InputError& error) {
    return complain(terminal, error.what(), exit_bad_input);
  } catch (const run::UsageError& error) {
    return complain(terminal, error.what(), exit_bad_input);
  } catch (const recording::FileError& error) {
    return complain(terminal, error.what(), exit_bad_input);
  } catch (const run::PluginError& error) {
    return complain(terminal, error.what(), exit_plugin_failed);
  } catch (const model::PluginFailure& error) {
    return complain(terminal, error.what(), exit_plugin_failed);
  } catch (const run::WriteError& error) {
    return complain(terminal, error.what(), exit_cannot_write);
  } catch (const evaluation::ExperimentFails& error) {
    return complain(terminal, error.what(), exit_plugin_failed);
  } catch (const evaluation::EvaluatorsLost& error) {
    return complain(terminal, error.what(), exit_evaluators_lost);
  } catch (const std::bad_alloc&) {
    return complain(terminal, "not enough memory for this experiment", exit_internal_error);
  } catch (const std::exception& error) {
    return complain(terminal, std::string("internal error: ") + error.what(), exit_internal_error);
  } catch (...) {
    return complain(terminal, "internal error", exit_internal_error);
  }
}

}  // namespace

void print(const std::string& text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) throw run::WriteError("(standard output)", errno);
}

}  // namespace somas::host

namespace {

// Rank 0 does what the command line says; the others serve it.
int cluster_main(const std::vector<std::string>& arguments, somas::run::Terminal& terminal) {
  std::optional<somas::evaluation::Cluster> cluster;
  try {
    cluster.emplace();
  } catch (const std::exception& error) {
    // Once is enough.
    if (somas::evaluation::Cluster::expected_rank() == 0)
      somas::host::complain(terminal, error.what(), somas::host::exit_bad_input);
    return somas::host::exit_bad_input;
  }
  if (cluster->rank() > 0) {
    cluster->supervise();
    return somas::host::exit_ok;
  }
  const int exit_code = somas::host::guarded_main(arguments, terminal);
  cluster->end(exit_code);
  return exit_code;
}

}  // namespace

int main(int count, char** words) {
  const std::vector<std::string> arguments(words + (count > 0 ? 1 : 0), words + count);
  if (!arguments.empty() && arguments.front() == somas::evaluation::evaluator_command)
    somas::evaluation::serve_evaluations({arguments.begin() + 1, arguments.end()});
  if (!arguments.empty() && arguments.front() == somas::conformance::examiner_command)
    somas::conformance::examine({arguments.begin() + 1, arguments.end()});
  somas::evaluation::report_crashes(somas::host::exit_plugin_failed);
  const somas::evaluation::WatchedThread watched;
  somas::run::Terminal terminal(stderr);
  somas::host::log_to(terminal);
  if (somas::evaluation::Cluster::launched()) return cluster_main(arguments, terminal);
  return somas::host::guarded_main(arguments, terminal);
}
