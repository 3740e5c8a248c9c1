// What can go wrong with a run, each with its own exit code.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

namespace somas::run {

/// The user asked for something that cannot be done (exit code 2).
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A plugin failed while the experiment ran (exit code 3).
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Results cannot be written: which file, and the system's reason (exit code 5).
class WriteError : public std::runtime_error {
 public:
  /// `error` is an errno.
  WriteError(const std::filesystem::path& path, int error);
  /// The same with a message of its own.
  WriteError(const std::string& message, std::filesystem::path path, int error)
      : std::runtime_error(message), path_(std::move(path)), error_(error) {}
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] int error() const { return error_; }

 private:
  std::filesystem::path path_;
  int error_;
};

}  // namespace somas::run
