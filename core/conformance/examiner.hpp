// The examiner: the process that loads a plugin under examination and looks at it, law by law. It
// may die of it; whoever started it goes on with another one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace somas::conformance {

/// What an examiner is told on its command line.
struct Assignment {
  int parent = 0;                ///< id of the process that it must not outlive
  std::uint64_t memory_mib = 0;  ///< most memory; 0: no limit
  std::string file;
  std::vector<std::string> settings;  ///< "ID.parameter=value"
  std::vector<std::string> done;      ///< "pass:SECTION/LAW", "FAIL:...": not to be looked at again
};

[[nodiscard]] std::vector<std::string> words_of(const Assignment& assignment);

/// Looks at all that is not done, and ends the process. `words` as words_of makes them.
[[noreturn]] void examine(const std::vector<std::string>& words);

}  // namespace somas::conformance
