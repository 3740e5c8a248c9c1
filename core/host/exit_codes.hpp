// How somas-host ends.
#pragma once

namespace somas::host {

enum ExitCode : int {
  exit_ok = 0,
  exit_internal_error = 1,
  exit_bad_input = 2,
  exit_plugin_failed = 3,
  exit_not_reproduced = 4,
  exit_cannot_write = 5,
  exit_evaluators_lost = 6,
  exit_hung_up = 129,
  exit_interrupted = 130,
  exit_terminated = 143,
};

/// For --help.
inline constexpr const char* exit_code_help =
    "Exit codes:\n"
    "  0    done\n"
    "  1    internal error, or not enough memory\n"
    "  2    bad input: command line, experiment file, saved genome or run directory\n"
    "  3    a plugin failed while the experiment ran, or in a check\n"
    "  4    a replay does not reproduce its record\n"
    "  5    results cannot be written (disk full, no permission)\n"
    "  6    evaluators were lost (killed, out of memory, no progress); finished work is saved\n"
    "  129  hung up (SIGHUP, the terminal closed); all finished generations are saved\n"
    "  130  interrupted (Ctrl-C); all finished generations are saved\n"
    "  143  terminated (SIGTERM, or a scheduler's SIGUSR1, SIGUSR2, SIGXCPU); all is saved\n";

}  // namespace somas::host
