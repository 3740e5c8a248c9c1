// The bytes between a coordinator and its evaluators. Both ends are the same program on the same
// kind of machine: numbers travel as they lie in memory, so results arrive to the last bit.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/experiment/experiment.hpp"

namespace somas::evaluation {

/// Bytes that no sound peer sends.
class WireError : public std::runtime_error {
 public:
  WireError() : std::runtime_error("a message between coordinator and evaluator is damaged") {}
};

class Writer {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T> Writer& put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Writer& text(std::string_view text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  requires std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>
  [[nodiscard]] T get() {
    T value;
    std::memcpy(&value, piece(sizeof value).data(), sizeof value);
    return value;
  }
  [[nodiscard]] std::string_view text() { return piece(get<std::uint64_t>()); }
  [[nodiscard]] bool done() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view piece(std::uint64_t size) {
    if (size > rest_.size()) throw WireError();
    const std::string_view piece = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return piece;
  }
  std::string_view rest_;
};

/// The first byte of a message.
enum class Tag : std::uint8_t {
  // to an evaluator
  experiment,  ///< ExperimentMessage
  forget,      ///< u32 experiment
  tasks,       ///< u32 experiment, then tasks until the end: u64 id, task
  // from an evaluator
  ready,      ///< ReadyMessage
  not_ready,  ///< u32 experiment, text: why
  results,    ///< until the end: u64 id, f64 seconds, result
};

/// An experiment to be loaded, and which reference simulation is to be run.
struct ExperimentMessage {
  std::uint32_t id = 0;
  std::uint32_t canary = 0;
  std::string yaml;                      ///< resolved
  std::vector<std::string> plugin_path;  ///< absolute
};

/// What the reference simulation gave, and on what.
struct ReadyMessage {
  std::uint32_t id = 0;
  std::uint32_t canary = 0;
  std::string hash;
  std::string machine;  ///< "CPU NAME, build FINGERPRINT"
};

[[nodiscard]] ExperimentMessage message_of(const experiment::Experiment& experiment,
                                           std::uint32_t id);
[[nodiscard]] std::string encode(const ExperimentMessage& message);
[[nodiscard]] ExperimentMessage decode_experiment(Reader in);
[[nodiscard]] std::string encode(const ReadyMessage& message);
[[nodiscard]] ReadyMessage decode_ready(Reader in);

void encode(Writer& out, const Task& task);
/// A task together with the genomes that it refers to.
struct OwnedTask {
  std::vector<model::Genome> genomes;
  Task task;
};
[[nodiscard]] OwnedTask decode_task(Reader& in);

void encode(Writer& out, const Result& result);
[[nodiscard]] Result decode_result(Reader& in);

/// A message with its length before it, as it goes over a stream.
[[nodiscard]] std::string framed(std::string_view message);
/// Takes the first whole message off the front of what has arrived; false if there is none yet.
[[nodiscard]] bool take_frame(std::string& arrived, std::string& message);

}  // namespace somas::evaluation
