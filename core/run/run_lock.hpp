// One process at a time works on a run.
#pragma once

#include <filesystem>

#include "core/run/errors.hpp"

namespace somas::run {

/// Holds `run.lock` in a directory. The system lets go of it when the process ends, however it
/// ends; the file itself may stay then, and means nothing.
class RunLock {
 public:
  static constexpr const char* file_name = "run.lock";

  /// Throws UsageError, naming the other process, if the directory is in use; WriteError.
  explicit RunLock(const std::filesystem::path& directory);
  ~RunLock();
  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&&) = delete;
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace somas::run
