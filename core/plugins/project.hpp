// A new plugin project outside this tree, from the templates of the SDK.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "somas/sdk/abi.hpp"

namespace somas::plugins {

/// The project cannot be written; what() says why and what to do.
class ProjectError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether a plugin may be called so: it becomes an id, a class, files and a target of CMake.
/// Throws ProjectError.
void check_project_name(const std::string& name);

/// "salt_marsh" -> "SaltMarsh".
[[nodiscard]] std::string class_name_of(const std::string& name);

/// Writes the project of a plugin `name` into `directory`, which must be absent or empty; whole or
/// not at all. `templates` is the SDK's template directory. Returns the files, relative to it,
/// sorted. Throws ProjectError.
std::vector<std::filesystem::path> write_project(PluginKind kind, const std::string& name,
                                                 const std::filesystem::path& directory,
                                                 const std::filesystem::path& templates);

}  // namespace somas::plugins
