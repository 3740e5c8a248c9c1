#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "core/evaluation/evaluator.hpp"
#include "core/evaluation/evaluator_process.hpp"
#include "core/evaluation/station.hpp"
#include "core/evaluation/wire.hpp"

namespace somas::evaluation {
namespace {

using Clock = std::chrono::steady_clock;

/// What an evaluator sees of our environment: enough to find libraries and scratch space.
constexpr const char* passed_on[] = {
    "PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS"};

std::vector<std::string> scrubbed_environment() {
  std::vector<std::string> environment = {"LC_ALL=C", "OMP_NUM_THREADS=1"};
  for (const char* name : passed_on)
    if (const char* value = std::getenv(name))
      environment.push_back(std::string(name) + "=" + value);
  return environment;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

[[noreturn]] void cannot(const std::string& what, int error) {
  throw EvaluatorsLost("cannot start an evaluator process: " + what + ": " + std::strerror(error));
}

/// A descriptor that is closed.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

/// The shared page, mapped.
class Page {
 public:
  Page() : file_(::memfd_create("evaluator", MFD_CLOEXEC)) {
    if (file_.get() < 0 || ::ftruncate(file_.get(), sizeof(EvaluatorPage)) != 0)
      cannot("shared memory", errno);
    void* memory =
        ::mmap(nullptr, sizeof(EvaluatorPage), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
    if (memory == MAP_FAILED) cannot("shared memory", errno);
    page_ = static_cast<EvaluatorPage*>(memory);
  }
  ~Page() { ::munmap(page_, sizeof(EvaluatorPage)); }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;
  [[nodiscard]] const EvaluatorPage& operator*() const { return *page_; }
  [[nodiscard]] const EvaluatorPage* operator->() const { return page_; }
  [[nodiscard]] int file() const { return file_.get(); }

 private:
  Descriptor file_;
  EvaluatorPage* page_ = nullptr;
};

class Spawning {
 public:
  Spawning() {
    ::posix_spawn_file_actions_init(&actions_);
    ::posix_spawnattr_init(&attributes_);
  }
  ~Spawning() {
    ::posix_spawn_file_actions_destroy(&actions_);
    ::posix_spawnattr_destroy(&attributes_);
  }
  Spawning(const Spawning&) = delete;
  Spawning& operator=(const Spawning&) = delete;

  pid_t spawn(const LocalOptions& options, int socket, int page) {
    ::posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    // The standard output is for results; what a plugin prints goes beside them.
    ::posix_spawn_file_actions_adddup2(&actions_, STDERR_FILENO, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions_, socket, evaluator_socket);
    ::posix_spawn_file_actions_adddup2(&actions_, page, evaluator_page);
    ::posix_spawn_file_actions_addclosefrom_np(&actions_, evaluator_page + 1);
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    ::posix_spawnattr_setsigdefault(&attributes_, &all);
    ::posix_spawnattr_setsigmask(&attributes_, &none);
    ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);

    std::vector<std::string> arguments = {
        "somas-host", evaluator_command, std::to_string(::getpid()),
        std::to_string(options.memory_mib), std::to_string(options.world_threads)};
    std::vector<std::string> environment = scrubbed_environment();
    pid_t child = 0;
    const int error = ::posix_spawn(&child, options.program.c_str(), &actions_, &attributes_,
                                    pointers_to(arguments).data(), pointers_to(environment).data());
    if (error != 0) cannot(options.program.string(), error);
    return child;
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

std::string signal_name(int signal) {
  const char* name = ::sigabbrev_np(signal);
  return name != nullptr ? "SIG" + std::string(name) : "signal " + std::to_string(signal);
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

bool is_crash(int signal) {
  for (const int crash : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS, SIGSYS, SIGTRAP})
    if (signal == crash) return true;
  return false;
}

/// An evaluator and all that we keep of it.
class Child {
 public:
  Child(const LocalOptions& options, std::uint64_t life) : life_(life) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) cannot("socket", errno);
    socket_ = Descriptor(ends[0]);
    const Descriptor theirs(ends[1]);
    // dup2 onto itself would keep close-on-exec: their number must be another.
    const Descriptor high(::fcntl(theirs.get(), F_DUPFD_CLOEXEC, 16));
    const Descriptor page(::fcntl(page_.file(), F_DUPFD_CLOEXEC, 16));
    if (high.get() < 0 || page.get() < 0) cannot("descriptors", errno);
    ::fcntl(socket_.get(), F_SETFL, O_NONBLOCK);
    process_ = Spawning().spawn(options, high.get(), page.get());
  }
  ~Child() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    reap();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(const std::string& message) {
    outgoing_ += framed(message);
    flush();
  }
  void flush() {
    while (!outgoing_.empty()) {
      const ssize_t count = ::send(socket_.get(), outgoing_.data(), outgoing_.size(), MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0 && errno != EAGAIN) outgoing_.clear();  // dead: reading will tell
      if (count < 0) return;
      outgoing_.erase(0, static_cast<std::size_t>(count));
    }
  }

  [[nodiscard]] pollfd descriptor() const {
    const auto events = static_cast<short>(outgoing_.empty() ? POLLIN : POLLIN | POLLOUT);
    return {.fd = socket_.get(), .events = events, .revents = 0};
  }
  [[nodiscard]] std::uint64_t life() const { return life_; }
  [[nodiscard]] bool busy() const { return page_->busy; }

  /// Messages that have arrived. False: that was the last of them, it is dead or dying.
  bool read(std::vector<std::string>& messages) {
    bool open = true;
    for (;;) {
      char piece[1 << 16];
      const ssize_t count = ::recv(socket_.get(), piece, sizeof piece, 0);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) open = count < 0 && errno == EAGAIN;
      if (count <= 0) break;
      arrived_.append(piece, static_cast<std::size_t>(count));
      if (static_cast<std::size_t>(count) < sizeof piece) break;
    }
    try {
      for (std::string message; take_frame(arrived_, message);)
        messages.push_back(std::move(message));
    } catch (const WireError&) {
      damaged_ = true;
      open = false;
    }
    return open;
  }

  /// Adds up the time without progress; true: it was too much, and it has been killed.
  bool watch(double seconds, double limit) {
    const std::uint64_t progress = page_->site.progress.load(std::memory_order_relaxed);
    const std::uint64_t task = page_->task;
    if (!page_->busy || progress != progress_ || task != task_) stuck_seconds_ = 0;
    progress_ = progress;
    task_ = task;
    stuck_seconds_ += page_->busy ? seconds : 0;
    if (stuck_seconds_ < limit) return false;
    hung_ = true;
    ::kill(process_, SIGKILL);
    return true;
  }

  /// Its end; it has closed its socket or has been killed.
  [[nodiscard]] Death end(double watchdog_seconds) {
    // How a process ends is settled before its descriptors are closed: this changes nothing then.
    ::kill(process_, SIGKILL);
    const int status = reap();

    Death death;
    death.task = page_->task;
    const model::CallSite& site = page_->site;
    if (site.instance[0] != 0) {
      death.plugin = text_of(site.instance) + ": " + text_of(site.call);
      if (site.step != model::CallSite::no_step) death.step = site.step;
    }
    if (WIFSIGNALED(status)) {
      const int signal = WTERMSIG(status);
      death.cause = signal_name(signal);
      if (is_crash(signal)) death.kind = Death::Kind::fault;
      if (signal == SIGKILL && hung_) {
        death.kind = Death::Kind::exhausted;
        death.cause = "no step of the simulation in " + seconds_text(watchdog_seconds);
      }
    } else if (WEXITSTATUS(status) == evaluator_spent) {
      death.kind = Death::Kind::spent;
    } else if (WEXITSTATUS(status) == evaluator_no_memory) {
      death.kind = Death::Kind::exhausted;
      death.cause = "out of memory";
    } else {
      // Somebody called exit.
      death.kind = Death::Kind::fault;
      death.cause = "exit with code " + std::to_string(WEXITSTATUS(status));
    }
    if (damaged_) {
      death.kind = Death::Kind::fault;
      death.cause = "damaged results";
    }
    return death;
  }

 private:
  template <std::size_t size>
  static std::string text_of(const char (&text)[size]) {
    return {text, ::strnlen(text, size)};
  }

  int reap() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return status;
  }

  std::uint64_t life_;
  Page page_;
  Descriptor socket_;
  pid_t process_ = 0;
  std::string arrived_, outgoing_;
  std::uint64_t progress_ = 0, task_ = 0;
  double stuck_seconds_ = 0;
  bool hung_ = false, damaged_ = false;
};

std::string host_name() {
  char name[256] = "this machine";
  ::gethostname(name, sizeof name - 1);
  return name;
}

class LocalStation final : public Station {
 public:
  explicit LocalStation(const LocalOptions& options)
      : options_(options), children_(options.places) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::size_t places() const override { return children_.size(); }

  void start(std::size_t place, std::uint64_t life) override {
    children_[place] = std::make_unique<Child>(options_, life);
  }
  void send(std::size_t place, const std::string& message) override {
    if (children_[place]) children_[place]->send(message);
  }
  void stop(std::size_t place) override { children_[place].reset(); }

  void wait_for(std::vector<pollfd>& descriptors) const override {
    for (const auto& child : children_)
      if (child) descriptors.push_back(child->descriptor());
  }

  [[nodiscard]] int patience() const override {
    const bool any = std::any_of(children_.begin(), children_.end(),
                                 [](const auto& child) { return child != nullptr; });
    return any ? static_cast<int>(1000 * tick()) : -1;
  }

  void collect(std::vector<Event>& events) override {
    const double seconds = since_last();
    for (std::size_t place = 0; place < children_.size(); ++place) {
      if (!children_[place]) continue;
      Child& child = *children_[place];
      child.flush();
      std::vector<std::string> messages;
      bool alive = child.read(messages);
      for (std::string& message : messages)
        events.push_back({place, child.life(), std::move(message)});
      if (alive && messages.empty() && child.watch(seconds, options_.watchdog_seconds))
        alive = false;
      if (alive) continue;
      events.push_back({place, child.life(), child.end(options_.watchdog_seconds)});
      children_[place].reset();
    }
  }

 private:
  [[nodiscard]] double tick() const { return std::min(1.0, options_.watchdog_seconds / 4); }

  // A machine that slept, or a run that was suspended, is not a simulation that hangs: what counts
  // is the time that we were there to see.
  double since_last() {
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double> since = now - std::exchange(last_, now);
    return std::min(since.count(), 2 * tick());
  }

  LocalOptions options_;
  std::string name_ = host_name();
  std::vector<std::unique_ptr<Child>> children_;
  Clock::time_point last_ = Clock::now();
};

unsigned number_in(const char* variable) {
  const char* text = std::getenv(variable);
  return text != nullptr ? static_cast<unsigned>(std::strtoul(text, nullptr, 10)) : 0;
}

}  // namespace

std::unique_ptr<Station> local_station(const LocalOptions& options) {
  return std::make_unique<LocalStation>(options);
}

unsigned usable_processors() {
  const unsigned all = std::max(1u, std::thread::hardware_concurrency());
  cpu_set_t set;
  CPU_ZERO(&set);
  unsigned mine = all;
  if (::sched_getaffinity(0, sizeof set, &set) == 0) mine = std::max(1, CPU_COUNT(&set));
  // A launcher that binds has shared them out already.
  const auto configured = static_cast<unsigned>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
  const unsigned ranks_here = std::max(1u, number_in("OMPI_COMM_WORLD_LOCAL_SIZE"));
  return mine < configured ? mine : std::max(1u, mine / ranks_here);
}

}  // namespace somas::evaluation
