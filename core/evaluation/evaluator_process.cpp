#include "core/evaluation/evaluator_process.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <new>
#include <unistd.h>

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include "somas/sdk/abi.hpp"

#include "core/evaluation/canary.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/evaluation/wire.hpp"

namespace somas::evaluation {
namespace {

using Clock = std::chrono::steady_clock;

/// Results are sent together when they come faster than this.
constexpr std::chrono::milliseconds longest_delay{5};

[[noreturn]] void leave(int code) { ::_exit(code); }

[[noreturn]] void leave_by_terminate() {
  // std::bad_alloc may have met a noexcept.
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    leave(evaluator_no_memory);
  } catch (...) {
  }
  std::abort();
}

// Dies with its parent; leaves signals of the terminal and the scheduler to the coordinator.
void settle(pid_t parent, std::uint64_t memory_mib) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) leave(evaluator_released);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGUSR1, SIGUSR2})
    std::signal(signal, SIG_IGN);
  std::set_terminate(leave_by_terminate);
  // At once, while it is known whose call asks for memory; and whoever goes on without it would
  // give results that hang on the machine.
  std::set_new_handler([] { leave(evaluator_no_memory); });

  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const rlimit memory{memory_mib << 20, memory_mib << 20};
  if (memory_mib != 0) ::setrlimit(RLIMIT_DATA, &memory);
  // When the machine's memory ends, better an evaluator than the coordinator.
  std::ofstream("/proc/self/oom_score_adj") << 500;
}

std::string machine_name() {
  std::string cpu = "unknown processor";
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) {
      cpu = line.substr(line.find(':') + 2);
      break;
    }
  return cpu + ", build " + SOMAS_FINGERPRINT;
}

class EvaluatorProcess {
 public:
  EvaluatorProcess(EvaluatorPage& page, unsigned world_threads)
      : page_(page), team_(world_threads) {}

  [[noreturn]] void serve() {
    for (std::string message;;) {
      page_.busy = false;
      receive(message);
      page_.busy = true;
      Reader in(message);
      switch (in.get<Tag>()) {
        case Tag::experiment:
          load(decode_experiment(in));
          break;
        case Tag::forget:
          experiments_.erase(in.get<std::uint32_t>());
          break;
        case Tag::tasks:
          evaluate(in);
          break;
        default:
          throw WireError();
      }
    }
  }

 private:
  void receive(std::string& message) {
    while (!take_frame(arrived_, message)) {
      char piece[1 << 16];
      const ssize_t count = ::read(evaluator_socket, piece, sizeof piece);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) leave(evaluator_released);
      arrived_.append(piece, static_cast<std::size_t>(count));
    }
  }

  static void send(const std::string& message) {
    const std::string frame = framed(message);
    for (std::size_t sent = 0; sent < frame.size();) {
      const ssize_t count = ::write(evaluator_socket, frame.data() + sent, frame.size() - sent);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) leave(evaluator_released);
      sent += static_cast<std::size_t>(count);
    }
  }

  void load(const ExperimentMessage& message) {
    try {
      // The text as a file of its own: what loads experiments reads files.
      const int file = ::memfd_create("resolved.yaml", MFD_CLOEXEC);
      const std::string& yaml = message.yaml;
      const bool written =
          file >= 0 && ::write(file, yaml.data(), yaml.size()) == static_cast<ssize_t>(yaml.size());
      if (!written) throw std::runtime_error("no room for the experiment");
      experiment::LoadOptions options;
      options.plugin_directories.assign(message.plugin_path.begin(), message.plugin_path.end());
      experiment::Experiment experiment =
          experiment::load("/proc/self/fd/" + std::to_string(file), options);
      ::close(file);
      const std::string hash = canary_hash(*experiment.ecosystem, message.canary);
      experiments_.insert_or_assign(message.id, std::move(experiment));
      send(encode(ReadyMessage{message.id, message.canary, hash, machine_name()}));
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      Writer out;
      out.put(Tag::not_ready).put(message.id).text(error.what());
      send(out.take());
    }
  }

  void evaluate(Reader in) {
    const experiment::Experiment& experiment = experiments_.at(in.get<std::uint32_t>());
    Clock::time_point begun = Clock::now(), sent = begun;
    Writer out;
    out.put(Tag::results);
    while (!in.done()) {
      const auto id = in.get<std::uint64_t>();
      const OwnedTask owned = decode_task(in);
      page_.task = id;
      const Result result = attempt(*experiment.ecosystem, owned.task, {}, nullptr, &team_).value();
      page_.task = 0;

      const Clock::time_point now = Clock::now();
      out.put(id).put(std::chrono::duration<double>(now - begun).count());
      encode(out, result);
      begun = now;
      const bool spent = result.failure.has_value();
      if (spent || in.done() || now - sent > longest_delay) {
        send(out.take());
        out.put(Tag::results);
        sent = now;
      }
      // Who knows what state the plugin is in.
      if (spent) leave(evaluator_spent);
    }
  }

  EvaluatorPage& page_;
  model::Team team_;
  std::string arrived_;
  std::map<std::uint32_t, experiment::Experiment> experiments_;
};

}  // namespace

void serve_evaluations(const std::vector<std::string>& arguments) {
  if (arguments.size() != 3) {
    std::fputs("somas-host: evaluators are started by a run, not by hand\n", stderr);
    std::exit(2);
  }
  settle(static_cast<pid_t>(std::strtol(arguments[0].c_str(), nullptr, 10)),
         std::strtoull(arguments[1].c_str(), nullptr, 10));
  void* memory =
      ::mmap(nullptr, sizeof(EvaluatorPage), PROT_READ | PROT_WRITE, MAP_SHARED, evaluator_page, 0);
  if (memory == MAP_FAILED) leave(evaluator_no_memory);
  // Its bytes are zeroes, which is a valid value.
  auto* page = static_cast<EvaluatorPage*>(memory);
  model::watched_site = &page->site;
  try {
    EvaluatorProcess(*page, static_cast<unsigned>(std::strtoul(arguments[2].c_str(), nullptr, 10)))
        .serve();
  } catch (const std::bad_alloc&) {
    leave(evaluator_no_memory);
  }
}

}  // namespace somas::evaluation
