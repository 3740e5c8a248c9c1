#include "core/plugins/installation.hpp"

#include <system_error>

namespace somas::plugins {

std::filesystem::path executable_file() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::filesystem::path() : program;
}

std::filesystem::path executable_directory() { return executable_file().parent_path(); }

std::filesystem::path prefix_directory() { return executable_directory().parent_path(); }

std::filesystem::path share_directory() { return prefix_directory() / "share/somas"; }

}  // namespace somas::plugins
