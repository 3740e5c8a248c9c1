// What names an evaluation: two tasks of one key have one result.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/evaluation/evaluator.hpp"
#include "core/experiment/experiment.hpp"

namespace somas::run {

/// XXH3-128, big-endian.
using TaskKey = std::array<std::uint8_t, 16>;

/// Of all that decides the results of an experiment's tasks beside the tasks themselves: world and
/// plugins with their parameters, the plugins' files, the host.
[[nodiscard]] TaskKey key_of(const experiment::Experiment& experiment);

/// Of a task: the above, its seed, and keys, places and genomes of its roster.
[[nodiscard]] TaskKey key_of(const TaskKey& experiment, const evaluation::Task& task);

/// Collects bytes for a key.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;

  Hasher& add(std::uint64_t value);
  Hasher& add(double value);
  /// With its length.
  Hasher& add(std::span<const std::uint8_t> bytes);
  Hasher& add(std::string_view text);
  [[nodiscard]] TaskKey key() const;

 private:
  struct State;
  State* state_;
};

}  // namespace somas::run
