// What a file says of itself before anything in it runs: is it a plugin for this host?
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace somas::plugins {

/// Why a file is no usable plugin, in plain words and with a remedy. what() does not name the file.
class BadPlugin : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads, bounds-checked, the fingerprint in the SOMAS note of a shared library. Throws BadPlugin
/// unless the file is a complete ELF shared library for this machine with such a note.
[[nodiscard]] std::string read_fingerprint(const std::filesystem::path& file);

/// Names of the symbols that a shared library takes from others, sorted; bounds-checked. Throws
/// BadPlugin unless the file is a complete ELF shared library for this machine.
[[nodiscard]] std::vector<std::string> imported_functions(const std::filesystem::path& file);

/// Throws BadPlugin unless `fingerprint` is the one this host was built with.
void check_fingerprint(const std::string& fingerprint);

}  // namespace somas::plugins
