// The most memory that this process has had resident since it was last asked to forget.
#pragma once

#include <fstream>
#include <string>

namespace somas::bench {

/// Where the kernel lets (Linux), else the peak since the start goes on counting.
inline void forget_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// Bytes; 0 where the kernel does not tell.
inline double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::stod(line.substr(6));
  return 0;
}

}  // namespace somas::bench
