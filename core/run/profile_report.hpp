// What a profiled run tells: profile.json in its directory, and a table for people.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/model/profile.hpp"

namespace somas::run {

/// Times are seconds on the clock, summed over the threads; shares are of `seconds`.
struct ProfileReport {
  struct Part {
    std::string name;  ///< "mechanics"; of a plugin its instance
    std::string call;  ///< "act(stress)"; empty for phases
    double seconds = 0, share = 0;
    std::uint64_t calls = 0;  ///< 0 for phases
  };
  std::uint64_t simulations = 0, steps = 0;
  double cell_steps = 0;
  double seconds = 0;                ///< of all simulations
  double cell_steps_per_second = 0;  ///< of one thread
  std::uint64_t peak_memory = 0;     ///< of this process, bytes
  std::vector<Part> phases;          ///< in their order; together no more than `seconds`
  std::vector<Part> plugins;         ///< the longest first; their times are part of the phases'
};

[[nodiscard]] ProfileReport report_on(const model::Profile& profile);

/// Writes profile.json. Throws WriteError.
void write_profile(const std::filesystem::path& run, const ProfileReport& report);

/// A table of several lines.
[[nodiscard]] std::string to_text(const ProfileReport& report);

}  // namespace somas::run
