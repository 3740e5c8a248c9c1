#include "core/run/task_key.hpp"

#include <bit>
#include <new>
#include <xxhash.h>

#include "core/run/files.hpp"

namespace somas::run {

struct Hasher::State {
  XXH3_state_t* xxh = XXH3_createState();
};

Hasher::Hasher() : state_(new State) {
  if (state_->xxh == nullptr) {
    delete state_;
    throw std::bad_alloc();
  }
  XXH3_128bits_reset(state_->xxh);
}

Hasher::~Hasher() {
  XXH3_freeState(state_->xxh);
  delete state_;
}

Hasher& Hasher::add(std::uint64_t value) {
  // Byte by byte, so that the order is the same everywhere.
  std::array<std::uint8_t, 8> bytes{};
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(value);
    value >>= 8;
  }
  XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
  return *this;
}

Hasher& Hasher::add(double value) { return add(std::bit_cast<std::uint64_t>(value)); }

Hasher& Hasher::add(std::span<const std::uint8_t> bytes) {
  add(static_cast<std::uint64_t>(bytes.size()));
  XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
  return *this;
}

Hasher& Hasher::add(std::string_view text) {
  return add(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

TaskKey Hasher::key() const {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_->xxh));
  TaskKey key{};
  static_assert(sizeof canonical.digest == sizeof key);
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = canonical.digest[i];
  return key;
}

TaskKey key_of(const experiment::Experiment& experiment) {
  Hasher hasher;
  hasher.add(std::string_view("somas-task/1")).add(experiment.simulation_yaml);
  hasher.add(hash_of_file("/proc/self/exe"));
  for (const experiment::Experiment::Library& library : experiment.libraries)
    hasher.add(library.plugin_id).add(hash_of_file(library.file));
  return hasher.key();
}

TaskKey key_of(const TaskKey& experiment, const evaluation::Task& task) {
  Hasher hasher;
  hasher.add(std::span<const std::uint8_t>(experiment));
  hasher.add(task.seed).add(static_cast<std::uint64_t>(task.roster.size()));
  for (const evaluation::Organism& organism : task.roster) {
    hasher.add(organism.key).add(organism.x).add(organism.y);
    hasher.add(std::span<const std::uint8_t>(organism.genome->controller));
    hasher.add(std::span<const std::uint8_t>(organism.genome->tree));
  }
  return hasher.key();
}

}  // namespace somas::run
