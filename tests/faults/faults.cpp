// A campaign of kills: runs an experiment, kills what works on it with SIGKILL at random moments,
// resumes, kills again, lets it end, and compares all results with those of a run that was left in
// peace.
//
//   faults HOST DIRECTORY [--kills N] [--seed N] [-- WORDS of somas-host run...]
//
// The coordinator names its thread after what it does: it is stopped, asked for its phase, and
// killed there, or let go if the campaign wants another phase. Child processes of the host
// (evaluators) are killed as well, if it has any; the run must not even notice. Exit code 0: every
// run ended in the reference.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include <sys/wait.h>

#include "tests/core/host/results.hpp"

namespace somas::test {
namespace {

namespace fs = std::filesystem;

using Words = std::vector<std::string>;

pid_t start(const Words& words, const fs::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// What the coordinator of a stopped process was doing: the name of the thread that has one.
std::string phase_of(pid_t process) {
  std::error_code error;
  std::string phase = "start or end";
  const fs::path tasks = "/proc/" + std::to_string(process) + "/task";
  for (const auto& task : fs::directory_iterator(tasks, error)) {
    const std::string name = first_line(task.path() / "comm");
    for (const char* known : {"select", "evaluate", "commit", "export"})
      if (name == known) phase = name;
  }
  return phase;
}

std::vector<pid_t> children_of(pid_t process) {
  const std::string id = std::to_string(process);
  std::istringstream in;
  std::vector<pid_t> children;
  std::error_code error;
  for (const auto& task : fs::directory_iterator("/proc/" + id + "/task", error)) {
    in.clear();
    in.str(first_line(task.path() / "children"));
    for (pid_t child = 0; in >> child;) children.push_back(child);
  }
  return children;
}

/// What was killed, and how the run ended that it was part of.
struct Kill {
  std::string what;
  bool same = false;
};

class Campaign {
 public:
  Campaign(std::string host, fs::path directory, Words words, unsigned seed)
      : host_(std::move(host)),
        directory_(std::move(directory)),
        words_(std::move(words)),
        random_(seed) {
    fs::create_directories(directory_);
  }

  bool run(std::size_t kills) {
    if (!reference()) return false;
    while (kills_.size() < kills) {
      if (!round(kills)) return false;
    }
    return table();
  }

 private:
  Words host_words(const fs::path& run) const {
    Words words = {host_, "run"};
    words.insert(words.end(), words_.begin(), words_.end());
    words.insert(words.end(), {"--quiet", "--out", run.string()});
    return words;
  }
  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }

  int finish(const Words& words) {
    const pid_t child = start(words, log());
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
  }
  [[nodiscard]] fs::path log() const { return directory_ / "host.log"; }

  bool reference() {
    const fs::path run = directory_ / "reference";
    if (finish(host_words(run)) != 0) return complain("the reference run failed");
    reference_ = results_of(run);
    return true;
  }

  /// One run with some kills; false if something is wrong with the campaign itself.
  bool round(std::size_t wanted) {
    const fs::path run = directory_ / ("run-" + std::to_string(++rounds_));
    const std::size_t first = kills_.size();
    const std::size_t here = std::min<std::size_t>(wanted - first, 1 + below(8));
    while (kills_.size() < first + here) {
      const bool begun = fs::exists(run / "manifest.json");
      const Words words = begun ? Words{host_, "resume", run.string(), "--quiet"} : host_words(run);
      const pid_t process = start(words, log());
      if (!kill_something(process)) break;  // it was over first
    }
    if (failed_) return complain("the host ended by itself with an error");

    const bool begun = fs::exists(run / "manifest.json");
    if (finish(begun ? Words{host_, "resume", run.string(), "--quiet"} : host_words(run)) != 0)
      return complain(run.string() + " could not be resumed");
    const bool same = results_of(run) == reference_;
    for (std::size_t k = first; k < kills_.size(); ++k) kills_[k].same = same;
    std::printf("%s: %zu kills, %s\n", run.filename().c_str(), kills_.size() - first,
                same ? "same results" : "OTHER RESULTS");
    std::fflush(stdout);
    if (same) fs::remove_all(run);
    return true;
  }

  /// Kills the process in a phase drawn at random, or one of its children; false if it ended first.
  bool kill_something(pid_t process) {
    constexpr const char* phases[] = {"select", "evaluate", "commit", "export"};
    const std::string wanted = phases[below(4)];
    const bool of_child = below(4) == 0;
    for (;;) {
      std::this_thread::sleep_for(std::chrono::microseconds(below(3000)));
      if (of_child) kill_child(process);
      ::kill(process, SIGSTOP);
      int status = 0;
      ::waitpid(process, &status, WUNTRACED);
      if (!WIFSTOPPED(status)) {
        failed_ = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
        return false;
      }
      const std::string phase = phase_of(process);
      // Sometimes whatever it is doing: loading, verifying, ending.
      if (phase == wanted || below(200) == 0) {
        ::kill(process, SIGKILL);
        ::waitpid(process, &status, 0);
        kills_.push_back({"coordinator, " + phase});
        return true;
      }
      ::kill(process, SIGCONT);
    }
  }

  void kill_child(pid_t process) {
    const std::vector<pid_t> children = children_of(process);
    if (children.empty() || below(20) != 0) return;
    if (::kill(children[below(children.size())], SIGKILL) == 0) kills_.push_back({"evaluator"});
  }

  bool table() const {
    std::map<std::string, std::pair<int, int>> rows;
    for (const Kill& kill : kills_) {
      ++rows[kill.what].first;
      rows[kill.what].second += kill.same ? 1 : 0;
    }
    std::printf("\n%-28s %6s %14s\n", "killed", "kills", "same results");
    int kills = 0, same = 0;
    for (const auto& [what, count] : rows) {
      std::printf("%-28s %6d %14d\n", what.c_str(), count.first, count.second);
      kills += count.first;
      same += count.second;
    }
    std::printf("%-28s %6d %14d, in %d runs\n", "all", kills, same, rounds_);
    return kills == same;
  }

  bool complain(const std::string& what) const {
    std::printf("%s; what the host said:\n%s", what.c_str(),
                fs::exists(log()) ? run::read_file(log()).c_str() : "nothing\n");
    return false;
  }

  std::string host_;
  fs::path directory_;
  Words words_;
  std::mt19937_64 random_;
  std::map<std::string, std::string> reference_;
  std::vector<Kill> kills_;
  int rounds_ = 0;
  bool failed_ = false;
};

int main_of(Words words) {
  std::size_t kills = 100;
  unsigned seed = std::random_device()();
  Words host_words;
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (words[i] == "--") {
      host_words.assign(words.begin() + static_cast<std::ptrdiff_t>(i) + 1, words.end());
      break;
    }
    if (words[i] == "--kills" && i + 1 < words.size()) kills = std::stoul(words[++i]);
    if (words[i] == "--seed" && i + 1 < words.size())
      seed = static_cast<unsigned>(std::stoul(words[++i]));
  }
  if (words.size() < 2 || host_words.empty()) {
    std::printf("usage: faults HOST DIRECTORY [--kills N] [--seed N] -- WORDS of somas-host run\n");
    return 2;
  }
  std::printf("seed of the campaign: %u\n", seed);
  return Campaign(words[0], words[1], host_words, seed).run(kills) ? 0 : 1;
}

}  // namespace
}  // namespace somas::test

int main(int count, char** words) {
  return somas::test::main_of({words + (count > 0 ? 1 : 0), words + count});
}
