// somas-host as a child process.
#pragma once

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include <sys/resource.h>
#include <sys/wait.h>

#include "core/run/files.hpp"

namespace somas::test {

class HostProcess {
 public:
  /// Starts the host in `directory`, which also gets its output. `limit`: no file of the child may
  /// grow beyond it, in bytes; 0: no limit.
  HostProcess(const std::filesystem::path& directory, std::vector<std::string> arguments,
              rlim_t limit = 0)
      : HostProcess(Program{}, directory, with_host(std::move(arguments)), limit) {}
  /// Another program; the first of the words is its file.
  struct Program {};
  HostProcess(Program, const std::filesystem::path& directory, std::vector<std::string> arguments,
              rlim_t limit = 0)
      : out_(directory / ".stdout"), err_(directory / ".stderr") {
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);

    child_ = ::fork();
    if (child_ != 0) return;
    const int flags = O_WRONLY | O_CREAT | O_TRUNC;
    ::dup2(::open(out_.c_str(), flags, 0666), STDOUT_FILENO);
    ::dup2(::open(err_.c_str(), flags, 0666), STDERR_FILENO);
    const rlimit small{limit, limit};
    if (limit != 0) ::setrlimit(RLIMIT_FSIZE, &small);
    if (::chdir(directory.c_str()) == 0) ::execv(words[0], words.data());
    ::_exit(127);
  }
  ~HostProcess() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  HostProcess(const HostProcess&) = delete;
  HostProcess& operator=(const HostProcess&) = delete;

  [[nodiscard]] pid_t id() const { return child_; }
  void send(int signal) const { ::kill(child_, signal); }

  /// The exit code; 1000 + the signal's number if one killed it.
  int wait() {
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  [[nodiscard]] std::string out() const { return run::read_file(out_); }
  [[nodiscard]] std::string err() const { return run::read_file(err_); }

 private:
  static std::vector<std::string> with_host(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), SOMAS_BINARY_DIR "/bin/somas-host");
    return arguments;
  }

  std::filesystem::path out_, err_;
  pid_t child_ = 0;
};

/// Asks until it is so; false after a minute.
inline bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 6000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace somas::test
