// A plugin library in the process, its classes, and instances of them.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "somas/sdk/abi.hpp"
#include "somas/sdk/controller.hpp"
#include "somas/sdk/environment.hpp"
#include "somas/sdk/fitness.hpp"
#include "somas/sdk/specialization.hpp"

#include "core/plugins/elf.hpp"
#include "core/plugins/values.hpp"

namespace somas::plugins {

[[nodiscard]] std::string kind_name(PluginKind kind);  ///< "environment"

template <class Interface>
inline constexpr PluginKind kind_of =
    std::is_same_v<Interface, Environment>      ? PluginKind::environment
    : std::is_same_v<Interface, Specialization> ? PluginKind::specialization
    : std::is_same_v<Interface, Controller>     ? PluginKind::controller
                                                : PluginKind::fitness;

/// An accepted library. It stays loaded until the process ends.
class Library {
 public:
  /// Checks the file, loads it (once per file), and checks what it says of itself. Throws
  /// BadPlugin.
  [[nodiscard]] static std::shared_ptr<const Library> open(const std::filesystem::path& file);
  /// A library that is linked into this program, by what its somas_plugin() returns. The table is
  /// checked as a file's is; file() is the program. Throws BadPlugin.
  [[nodiscard]] static std::shared_ptr<const Library> linked_in(const PluginInfo* table);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& version() const { return version_; }
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }
  [[nodiscard]] std::span<const ClassInfo> classes() const { return classes_; }

 private:
  struct Handle;
  explicit Library(const std::filesystem::path& file);
  explicit Library(const PluginInfo* table);
  void accept(const PluginInfo* table);

  std::filesystem::path file_;
  std::shared_ptr<Handle> handle_;
  std::string id_, version_, fingerprint_;
  std::span<const ClassInfo> classes_;
};

/// A class of a library.
struct PluginClass {
  std::shared_ptr<const Library> library;
  const ClassInfo* info = nullptr;

  [[nodiscard]] std::string id() const { return info->id; }
  [[nodiscard]] std::span<const ParameterInfo> parameters() const {
    return {info->parameters, info->parameter_count};
  }

  /// A new instance, which keeps its library. `parameters` is a validated group. Precondition: the
  /// class is of the interface's kind. Lets pass whatever the plugin's constructor throws
  /// (ParameterError, any std::exception, or anything else).
  template <class Interface>
  [[nodiscard]] std::shared_ptr<Interface> create(const ParameterValue& parameters) const {
    auto* instance = static_cast<Interface*>(construct(kind_of<Interface>, parameters));
    return {instance,
            [keep = library, destroy = info->destroy](Interface* dying) { destroy(dying); }};
  }

 private:
  [[nodiscard]] void* construct(PluginKind kind, const ParameterValue& parameters) const;
};

}  // namespace somas::plugins
