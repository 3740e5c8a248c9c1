// A campaign of kills: runs an experiment, kills what works on it with SIGKILL at random moments,
// resumes in another layout, kills again, lets it end, and compares all results with those of a run
// that was left in peace.
//
//   faults HOST DIRECTORY [--kills N] [--seed N] [--launcher WORDS] -- WORDS of somas-host run...
//
// A layout is a number of evaluator processes, of threads or, with a launcher, of MPI ranks. Killed
// are coordinators, evaluators, ranks and launchers. The coordinator names its thread after what it
// does: it is stopped, asked for its phase, and killed there, or let go if the campaign wants
// another phase. A run that loses an evaluator must not even notice; one that loses anything else
// must leave no process behind. Exit code 0: every run ended in the reference.
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <sys/wait.h>

#include "tests/core/host/results.hpp"
#include "tests/faults/processes.hpp"

namespace somas::test {
namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;
using Words = std::vector<std::string>;

/// For the end of a process whose parent, launcher or fellow was killed.
constexpr std::chrono::seconds patience{60};

/// Where the work of a start is done.
struct Layout {
  std::string name;
  Words before, after;  ///< the host's words
  bool ranks = false;
};

enum class Victim { coordinator, evaluator, rank, launcher };

const char* name_of(Victim victim) {
  constexpr const char* names[] = {"coordinator", "evaluator", "rank", "launcher"};
  return names[static_cast<std::size_t>(victim)];
}

/// What was killed, and how the run ended that it was part of.
struct Kill {
  std::string what;
  bool same = false;
};

/// A start of the host, and all that it has started.
class Job {
 public:
  Job(const Layout& layout, const Words& words, const fs::path& log)
      : ranks_(layout.ranks), begun_(Clock::now()) {
    Words all = layout.before;
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), layout.after.begin(), layout.after.end());
    process_ = start(all, log);
  }

  /// The launcher, or the host itself.
  [[nodiscard]] pid_t process() const { return process_; }
  /// -1: not there yet.
  [[nodiscard]] pid_t coordinator() const { return ranks_ ? rank(0) : process_; }
  [[nodiscard]] pid_t rank(int which) const {
    for (const pid_t child : children_of(process_))
      if (rank_of(child) == which) return child;
    return -1;
  }
  [[nodiscard]] std::vector<pid_t> other_ranks() const {
    std::vector<pid_t> found;
    for (const pid_t child : children_of(process_))
      if (ranks_ && rank_of(child) > 0) found.push_back(child);
    return found;
  }
  [[nodiscard]] std::vector<pid_t> evaluators() const {
    if (!ranks_) return children_of(process_);
    std::vector<pid_t> found;
    for (const pid_t child : children_of(process_))
      if (rank_of(child) >= 0)
        for (const pid_t evaluator : children_of(child)) found.push_back(evaluator);
    return found;
  }
  [[nodiscard]] std::vector<pid_t> everybody() const {
    std::vector<pid_t> found = {process_};
    for (std::size_t i = 0; i < found.size(); ++i)
      for (const pid_t child : children_of(found[i])) found.push_back(child);
    return found;
  }

  /// Of the launcher or the host, once it has ended.
  std::optional<int> ended() {
    if (!status_) {
      int status = 0;
      if (::waitpid(process_, &status, WNOHANG) == process_) status_ = status;
    }
    return status_;
  }
  int wait() {
    while (!ended()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return *status_;
  }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(Clock::now() - begun_).count();
  }

 private:
  bool ranks_;
  Clock::time_point begun_;
  pid_t process_ = -1;
  std::optional<int> status_;
};

bool within(std::chrono::seconds limit, const std::function<bool()>& true_at_last) {
  const Clock::time_point end = Clock::now() + limit;
  while (!true_at_last()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

std::vector<Layout> layouts_with(const Words& launcher) {
  std::vector<Layout> layouts;
  for (const char* workers : {"1", "2", "4"})
    layouts.push_back({std::string(workers) + " evaluators", {}, {"--workers", workers}});
  layouts.push_back({"2 threads", {}, {"--threads", "2"}});
  if (launcher.empty()) return layouts;
  for (const char* ranks : {"1", "2", "3", "4"}) {
    Layout layout{std::string(ranks) + " ranks", launcher, {"--workers", "1"}, true};
    layout.before.insert(layout.before.end(), {"-np", ranks});
    layouts.push_back(std::move(layout));
  }
  return layouts;
}

class Campaign {
 public:
  Campaign(std::string host, fs::path directory, Words words, const Words& launcher, unsigned seed)
      : host_(std::move(host)),
        directory_(std::move(directory)),
        words_(std::move(words)),
        layouts_(layouts_with(launcher)),
        random_(seed) {
    fs::create_directories(directory_);
  }

  bool run(std::size_t kills) {
    if (!reference()) return false;
    while (kills_.size() < kills)
      if (!round(kills)) return false;
    return table();
  }

 private:
  [[nodiscard]] fs::path log() const { return directory_ / "host.log"; }
  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }

  /// Begins or resumes a run.
  Job begin(const fs::path& run, const Layout& layout) const {
    Words words = {host_, "resume", run.string(), "--quiet"};
    if (!fs::exists(run / "manifest.json")) {
      words = {host_, "run"};
      words.insert(words.end(), words_.begin(), words_.end());
      words.insert(words.end(), {"--quiet", "--out", run.string()});
    }
    return Job(layout, words, log());
  }

  bool reference() {
    const fs::path run = directory_ / "reference";
    if (begin(run, layouts_[0]).wait() != 0) return complain("the reference run failed");
    reference_ = results_of(run);
    return true;
  }

  /// One run with some kills; false if anything is not as it should be but for its results.
  bool round(std::size_t wanted) {
    const fs::path run = directory_ / ("run-" + std::to_string(++rounds_));
    const std::size_t first = kills_.size();
    const std::size_t here = first + std::min<std::size_t>(wanted - first, 1 + below(8));
    bool over = false;
    while (kills_.size() < here && !over) {
      const Layout& layout = layouts_[below(layouts_.size())];
      Job job = begin(run, layout);
      if (!attack(job, layout, here, over)) return false;
    }
    const Layout& last = layouts_[below(layouts_.size())];
    if (begin(run, last).wait() != 0)
      return complain(run.string() + " could not be resumed with " + last.name);
    const bool same = results_of(run) == reference_;
    for (std::size_t k = first; k < kills_.size(); ++k) kills_[k].same = same;
    std::printf("%s: %zu kills, ended with %s, %s\n", run.filename().c_str(), kills_.size() - first,
                last.name.c_str(), same ? "same results" : "OTHER RESULTS");
    std::fflush(stdout);
    if (same) fs::remove_all(run);
    return true;
  }

  /// Kills evaluators, which a job survives, until something else was killed. `over`: the job ended
  /// by itself. False if it did not end as it should.
  bool attack(Job& job, const Layout& layout, std::size_t most, bool& over) {
    while (kills_.size() < most) {
      const Victim victim = draw_victim(layout);
      const std::vector<pid_t> all = kill(job, layout, victim);
      if (all.empty()) break;
      if (victim != Victim::evaluator) return no_one_left(job, all, layout);
    }
    over = true;
    if (job.wait() == 0) return true;
    return complain("with " + layout.name + ", a run that lost at most evaluators failed");
  }

  Victim draw_victim(const Layout& layout) {
    const std::uint64_t dice = below(10);
    if (layout.ranks && dice < 3) return Victim::rank;
    if (layout.ranks && dice < 5) return Victim::launcher;
    return dice < 8 ? Victim::coordinator : Victim::evaluator;
  }

  /// In a phase drawn at random. All processes that the job had; none if it ended first.
  std::vector<pid_t> kill(Job& job, const Layout& layout, Victim victim) {
    constexpr const char* phases[] = {"select", "evaluate", "commit", "export"};
    const std::string wanted = phases[below(4)];
    for (;;) {
      std::this_thread::sleep_for(std::chrono::microseconds(below(3000)));
      if (job.ended()) return {};
      const pid_t coordinator = job.coordinator();
      if (coordinator < 0 || ::kill(coordinator, SIGSTOP) != 0) continue;
      const std::string phase = phase_of(coordinator);
      // Sometimes whatever it is doing: loading, verifying, ending.
      const bool now = phase == wanted || below(400) == 0;
      const pid_t target = now ? find(job, victim, coordinator) : -1;
      const std::vector<pid_t> all = job.everybody();
      const bool killed = target > 0 && ::kill(target, SIGKILL) == 0;
      ::kill(coordinator, SIGCONT);
      if (!killed) continue;
      note(job, layout, name_of(victim), phase);
      return all;
    }
  }

  /// -1: there is none now.
  pid_t find(const Job& job, Victim victim, pid_t coordinator) {
    if (victim == Victim::coordinator) return coordinator;
    if (victim == Victim::launcher) return job.process();
    const std::vector<pid_t> among = victim == Victim::rank ? job.other_ranks() : job.evaluators();
    return among.empty() ? -1 : among[below(among.size())];
  }

  void note(const Job& job, const Layout& layout, const std::string& what,
            const std::string& phase) {
    kills_.push_back({what + ", " + phase});
    std::printf("  kill %zu: %s in %s, %.6f s after the start with %s\n", kills_.size(),
                what.c_str(), phase.c_str(), job.seconds(), layout.name.c_str());
  }

  /// Whoever has lost its coordinator, launcher or fellow ends by itself, and soon.
  bool no_one_left(Job& job, const std::vector<pid_t>& all, const Layout& layout) const {
    if (!within(patience, [&] { return job.ended().has_value(); }))
      return complain("with " + layout.name + ", a job went on after a kill");
    if (*job.ended() == 0)
      return complain("with " + layout.name + ", a job that was killed ended with exit code 0");
    for (const pid_t process : all)
      if (!within(patience, [&] { return !alive(process); }))
        return complain("with " + layout.name + ", process " + std::to_string(process) +
                        " was left behind");
    return true;
  }

  [[nodiscard]] bool table() const {
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

  [[nodiscard]] bool complain(const std::string& what) const {
    std::printf("%s; what the host said:\n%s", what.c_str(),
                fs::exists(log()) ? run::read_file(log()).c_str() : "nothing\n");
    return false;
  }

  std::string host_;
  fs::path directory_;
  Words words_;
  std::vector<Layout> layouts_;
  std::mt19937_64 random_;
  std::map<std::string, std::string> reference_;
  std::vector<Kill> kills_;
  int rounds_ = 0;
};

Words words_of(const std::string& text) {
  std::istringstream in(text);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

int main_of(const Words& words) {
  std::size_t kills = 100;
  unsigned seed = std::random_device()();
  Words host_words, launcher;
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (words[i] == "--") {
      host_words.assign(words.begin() + static_cast<std::ptrdiff_t>(i) + 1, words.end());
      break;
    }
    if (i + 1 == words.size()) continue;
    if (words[i] == "--kills") kills = std::stoul(words[++i]);
    if (words[i] == "--seed") seed = static_cast<unsigned>(std::stoul(words[++i]));
    if (words[i] == "--launcher") launcher = words_of(words[++i]);
  }
  if (words.size() < 2 || host_words.empty()) {
    std::printf(
        "usage: faults HOST DIRECTORY [--kills N] [--seed N] [--launcher WORDS] -- WORDS of "
        "somas-host run\n");
    return 2;
  }
  std::printf("seed of the campaign: %u\n", seed);
  return Campaign(words[0], words[1], host_words, launcher, seed).run(kills) ? 0 : 1;
}

}  // namespace
}  // namespace somas::test

int main(int count, char** words) {
  return somas::test::main_of({words + (count > 0 ? 1 : 0), words + count});
}
