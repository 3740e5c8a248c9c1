// The examination of a plugin file, in processes of their own: whatever the plugin does to them is
// a line of the report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/conformance/report.hpp"

namespace somas::conformance {

struct ExaminationOptions {
  std::filesystem::path program;      ///< somas-host
  std::filesystem::path file;         ///< the plugin
  std::vector<std::string> settings;  ///< "ID.parameter=value", in order
  double seconds = 20;                ///< longest that one call may take
  std::uint64_t memory_mib = 2048;    ///< most memory; 0: no limit
};

/// A setting that cannot be: what() says which, and what is allowed.
class RefusedSetting : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Lines of each verdict.
struct Tally {
  unsigned passed = 0, warned = 0, failed = 0, skipped = 0;
};

/// Called with every message of kind library, section (each once) and end, in order.
using Listener = std::function<void(const Message&)>;

/// Looks at a plugin file. Throws RefusedSetting, or std::runtime_error where no process can be
/// started.
Tally examine_plugin(const ExaminationOptions& options, const Listener& tell);

}  // namespace somas::conformance
