#include "core/conformance/supervisor.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <poll.h>
#include <set>
#include <spawn.h>
#include <unistd.h>
#include <utility>

#include <sys/mman.h>
#include <sys/wait.h>

#include "core/conformance/examiner.hpp"

namespace somas::conformance {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void cannot(const std::string& what, int error) {
  throw std::runtime_error("cannot start an examiner: " + what + ": " + std::strerror(error));
}

/// A descriptor that is closed; numbers of the examiner are kept free.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(::fcntl(number, F_DUPFD_CLOEXEC, 16)) {
    const int error = errno;
    ::close(number);
    if (number_ < 0) cannot("descriptors", error);
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }
  void close() { ::close(std::exchange(number_, -1)); }

 private:
  int number_;
};

int checked(int result, const char* what) {
  if (result < 0) cannot(what, errno);
  return result;
}

/// Memory that the examiner shares, mapped.
class SharedPage {
 public:
  SharedPage() : file_(checked(::memfd_create("examiner", MFD_CLOEXEC), "shared memory")) {
    checked(::ftruncate(file_.get(), sizeof(Page)), "shared memory");
    void* memory =
        ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
    if (memory == MAP_FAILED) cannot("shared memory", errno);
    page_ = static_cast<Page*>(memory);
  }
  ~SharedPage() { ::munmap(page_, sizeof(Page)); }
  SharedPage(const SharedPage&) = delete;
  SharedPage& operator=(const SharedPage&) = delete;
  [[nodiscard]] int file() const { return file_.get(); }
  [[nodiscard]] const Page* operator->() const { return page_; }

 private:
  Descriptor file_;
  Page* page_ = nullptr;
};

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

pid_t spawn(const std::filesystem::path& program, std::vector<std::string> words, int pipe,
            int page) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  // The standard output is for the report; what a plugin prints goes beside it.
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, pipe, examiner_pipe);
  ::posix_spawn_file_actions_adddup2(&actions, page, examiner_page);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, examiner_page + 1);
  words.insert(words.begin(), {"somas-host", examiner_command});
  pid_t child = 0;
  const int error =
      ::posix_spawn(&child, program.c_str(), &actions, nullptr, pointers_to(words).data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) cannot(program.string(), error);
  return child;
}

std::string text_of(const char* bytes, std::size_t size) { return {bytes, ::strnlen(bytes, size)}; }

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

/// One examiner, from its start to its end.
class Examiner {
 public:
  Examiner(const ExaminationOptions& options, const std::vector<std::string>& done)
      : options_(options) {
    int ends[2];
    checked(::pipe2(ends, O_CLOEXEC), "pipe");
    out_.emplace(ends[0]);
    Descriptor in(ends[1]);
    process_ = spawn(options.program,
                     words_of({.parent = ::getpid(),
                               .memory_mib = options.memory_mib,
                               .file = std::filesystem::absolute(options.file).string(),
                               .settings = options.settings,
                               .done = done}),
                     in.get(), page_.file());
  }
  ~Examiner() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Examiner(const Examiner&) = delete;
  Examiner& operator=(const Examiner&) = delete;

  /// Hands on its messages until it has nothing more to say.
  template <class Tell>
  void listen(const Tell& tell) {
    std::string arrived;
    Clock::time_point alive = Clock::now();
    std::uint64_t progress = 0;
    for (bool open = true; open;) {
      pollfd descriptor{.fd = out_->get(), .events = POLLIN, .revents = 0};
      if (::poll(&descriptor, 1, 50) > 0) open = read(arrived);
      for (std::size_t end; (end = arrived.find('\n')) != std::string::npos;) {
        tell(decode(std::string_view(arrived).substr(0, end)));
        arrived.erase(0, end + 1);
      }
      const std::uint64_t now = page_->site.progress.load(std::memory_order_relaxed);
      if (now != std::exchange(progress, now)) alive = Clock::now();
      if (!hung_ &&
          std::chrono::duration<double>(Clock::now() - alive).count() > options_.seconds) {
        hung_ = true;
        ::kill(process_, SIGKILL);
      }
    }
  }

  /// Why it ended before it was done, with a remedy.
  [[nodiscard]] std::pair<std::string, std::string> cause_of_death() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    const std::string debugger =
        "run it in a test of your own (somas/sdk/testing.hpp) in a debugger, or built with "
        "-fsanitize=address";
    if (hung_)
      return {"no end within " + seconds_text(options_.seconds) + place(),
              "see which of its loops has no end; for a call that takes longer: --seconds"};
    if (WIFSIGNALED(status)) {
      const int signal = WTERMSIG(status);
      const char* name = ::sigabbrev_np(signal);
      const std::string text = name != nullptr ? "SIG" + std::string(name) : std::to_string(signal);
      if (signal == SIGKILL)
        return {"killed (SIGKILL)" + place(),
                "somebody, or the system for want of memory: see the system's log"};
      return {"crashes (" + text + ")" + place(), debugger};
    }
    if (WEXITSTATUS(status) == examiner_no_memory)
      return {"needs more than " + std::to_string(options_.memory_mib) + " MiB of memory" + place(),
              "see what grows from call to call; for a plugin that needs so much: --memory"};
    return {"ends the process (exit code " + std::to_string(WEXITSTATUS(status)) + ")" + place(),
            "throw an exception; never call exit"};
  }

 private:
  bool read(std::string& arrived) {
    char piece[1 << 12];
    const ssize_t count = ::read(out_->get(), piece, sizeof piece);
    if (count > 0) arrived.append(piece, static_cast<std::size_t>(count));
    return count > 0 || (count < 0 && errno == EINTR);
  }

  /// " in act(stress) at step 3, with rate = 0".
  [[nodiscard]] std::string place() const {
    const model::CallSite& site = page_->site;
    std::string text;
    if (site.instance[0] != 0) {
      text += " in " + text_of(site.call, sizeof site.call);
      if (site.step != model::CallSite::no_step) text += " at step " + std::to_string(site.step);
    }
    const std::string detail = text_of(page_->detail, sizeof page_->detail);
    return detail.empty() ? text : text + ", with " + detail;
  }

  const ExaminationOptions& options_;
  std::optional<Descriptor> out_;
  SharedPage page_;
  pid_t process_ = 0;
  bool hung_ = false;
};

/// What is known of a file so far, whichever examiner found it.
class Supervisor {
 public:
  Supervisor(const ExaminationOptions& options, const Listener& tell)
      : options_(options), tell_(tell) {}

  Tally run() {
    while (!over_) {
      Examiner examiner(options_, done_);
      open_.reset();
      examiner.listen([&](const Message& message) { hear(message); });
      if (over_) break;
      const auto [text, remedy] = examiner.cause_of_death();
      // Outside of any law, another one would die, too.
      if (!open_) over_ = true;
      Finding finding = open_ ? *open_ : Finding{.section = section_, .law = "between the laws"};
      finding.verdict = Verdict::fail;
      finding.text = text;
      finding.remedy = remedy;
      conclude(finding);
    }
    return tally_;
  }

 private:
  void hear(const Message& message) {
    switch (message.kind) {
      case Message::Kind::library:
        if (!std::exchange(told_library_, true)) tell_(message);
        break;
      case Message::Kind::section:
        section_ = message.finding.section;
        if (told_sections_.insert(section_).second) tell_(message);
        break;
      case Message::Kind::begin:
        open_ = message.finding;
        break;
      case Message::Kind::end:
        open_.reset();
        conclude(message.finding);
        break;
      case Message::Kind::refused:
        throw RefusedSetting(message.text);
      case Message::Kind::over:
        over_ = true;
        break;
    }
  }

  void conclude(const Finding& finding) {
    done_.push_back(std::string(name_of(finding.verdict)) + ":" + finding.section + "/" +
                    finding.law);
    if (finding.verdict == Verdict::pass || finding.verdict == Verdict::info) ++tally_.passed;
    if (finding.verdict == Verdict::warn) ++tally_.warned;
    if (finding.verdict == Verdict::fail) ++tally_.failed;
    if (finding.verdict == Verdict::skip) ++tally_.skipped;
    tell_({.kind = Message::Kind::end, .finding = finding});
  }

  const ExaminationOptions& options_;
  const Listener& tell_;
  Tally tally_;
  std::vector<std::string> done_;
  std::optional<Finding> open_;
  std::string section_;
  std::set<std::string> told_sections_;
  bool told_library_ = false;
  bool over_ = false;
};

}  // namespace

Tally examine_plugin(const ExaminationOptions& options, const Listener& tell) {
  return Supervisor(options, tell).run();
}

}  // namespace somas::conformance
