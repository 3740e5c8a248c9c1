// Places for evaluator processes on one machine, and what happens at them. A pool directs stations:
// its own machine's, and those that are reached over a network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <poll.h>
#include <string>
#include <variant>
#include <vector>

namespace somas::evaluation {

/// How an evaluator ended.
struct Death {
  enum class Kind : std::uint8_t {
    fault,      ///< a plugin crashed it
    killed,     ///< by somebody else
    exhausted,  ///< no memory, or no progress
    spent,      ///< it ended itself after a plugin threw
  };
  Kind kind = Kind::killed;
  std::string cause;                    ///< "SIGSEGV", "out of memory"
  std::string plugin;                   ///< instance and call; empty: in none
  std::optional<std::uint64_t> step{};  ///< of the simulation
  std::uint64_t task = 0;               ///< id of the one that ran; 0: none
};

/// What came from a place. `life` is the number that was given to its start.
struct Event {
  std::size_t place = 0;
  std::uint64_t life = 0;
  std::variant<std::string, Death> what;  ///< a message, or the end
};

class Station {
 public:
  virtual ~Station() = default;
  [[nodiscard]] virtual const std::string& name() const = 0;  ///< of the machine
  [[nodiscard]] virtual std::size_t places() const = 0;

  /// Starts a process at a place that has none. Throws EvaluatorsLost.
  virtual void start(std::size_t place, std::uint64_t life) = 0;
  /// Never blocks. A process that is dead does not get it; its death is an event.
  virtual void send(std::size_t place, const std::string& message) = 0;
  /// Kills the process of a place, if any, without an event.
  virtual void stop(std::size_t place) = 0;

  /// What to wait for, if there are descriptors that tell.
  virtual void wait_for(std::vector<pollfd>& descriptors) const = 0;
  /// How long to wait at most, in milliseconds; -1: for ever.
  [[nodiscard]] virtual int patience() const = 0;
  /// What has happened since. Never blocks. Throws EvaluatorsLost when the machine is lost.
  virtual void collect(std::vector<Event>& events) = 0;
};

struct LocalOptions {
  std::size_t places = 1;
  std::uint64_t memory_mib = 0;   ///< limit of an evaluator's data; 0: none
  double watchdog_seconds = 600;  ///< without a step of the simulation
  unsigned world_threads = 1;     ///< of an evaluator, that share a large world
  std::filesystem::path program = "/proc/self/exe";
};

/// Processes of this machine, children of the thread that calls: it must live as long.
[[nodiscard]] std::unique_ptr<Station> local_station(const LocalOptions& options);

/// Processors that this process may use, shared fairly with those that a launcher started beside
/// it.
[[nodiscard]] unsigned usable_processors();

}  // namespace somas::evaluation
