// When a plugin crashes in this very process: who it was, before the end.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/model/call_site.hpp"

namespace somas::evaluation {

/// From here on a crash (SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS) in a plugin, called by a thread
/// that is watched, ends the process with `exit_code` and a line on standard error that names
/// plugin, call and step. Other crashes stay what they are.
void report_crashes(int exit_code);

/// Notes the present thread's calls into plugins while it lives. With a stack of its own for the
/// report: the crash may be that the other one is full.
class WatchedThread {
 public:
  /// `note`: a file that a crash writes its line into; none if empty.
  explicit WatchedThread(const std::filesystem::path& note = {});
  ~WatchedThread();
  WatchedThread(const WatchedThread&) = delete;
  WatchedThread& operator=(const WatchedThread&) = delete;

 private:
  model::CallSite site_{};
  model::CallSite* outer_;
  std::string note_;
  const char* outer_note_;
  std::unique_ptr<char[]> stack_;  ///< null: the thread has one already
};

/// While this lives, a crash in a watched thread that has a note does not end the process: once its
/// line is written, this program starts anew, as the same process, with other words. One at a time.
class RestartAfterCrash {
 public:
  /// `words`: of the command line, without the program; if empty, nothing starts anew.
  explicit RestartAfterCrash(std::vector<std::string> words);
  ~RestartAfterCrash();
  RestartAfterCrash(const RestartAfterCrash&) = delete;
  RestartAfterCrash& operator=(const RestartAfterCrash&) = delete;

 private:
  std::vector<std::string> words_;
  std::vector<char*> arguments_;  ///< as execv takes them
};

}  // namespace somas::evaluation
