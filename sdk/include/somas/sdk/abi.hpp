/// @file
/// The binary boundary: one exported symbol, a table of plain data behind it, and a note section
/// that a host can read from the file before it loads it. Plugin authors need none of this: see
/// plugin.hpp.
#pragma once

#include <cstdint>
#include <string_view>

#include "somas/sdk/log.hpp"
#include "somas/sdk/parameters.hpp"

/// Revision of the interface. What is built for a revision works with every host of that revision;
/// see "Compatibility" in the guide for plugin authors.
#define SOMAS_ABI_REVISION 1

/// @cond
#define SOMAS_STRINGIFY_(x) #x
#define SOMAS_STRINGIFY(x) SOMAS_STRINGIFY_(x)

#if defined(_GLIBCXX_USE_CXX11_ABI)
#define SOMAS_STRINGS_ "libstdc++ cxx11=" SOMAS_STRINGIFY(_GLIBCXX_USE_CXX11_ABI)
#elif defined(_LIBCPP_VERSION)
#define SOMAS_STRINGS_ "libc++"
#else
#define SOMAS_STRINGS_ "unknown library"
#endif
#if defined(_GLIBCXX_DEBUG)
#define SOMAS_CONTAINERS_ "debug"
#else
#define SOMAS_CONTAINERS_ "plain"
#endif
/// @endcond

/// What host and plugin must agree on for C++ classes to cross the boundary.
#define SOMAS_FINGERPRINT                                                       \
  "somas-abi " SOMAS_STRINGIFY(                                                 \
      SOMAS_ABI_REVISION) "; " SOMAS_STRINGS_ "; containers=" SOMAS_CONTAINERS_ \
                          "; pointer=" SOMAS_STRINGIFY(__SIZEOF_POINTER__)

namespace somas {

/// The kinds of plugin classes.
enum class PluginKind : std::uint32_t {
  environment = 1,     ///< an Environment
  specialization = 2,  ///< a Specialization
  controller = 3,      ///< a Controller
  fitness = 4,         ///< a Fitness
};

/// One plugin class. `create` may throw (ParameterError, std::exception); what it returns points to
/// the interface class of the kind and is destroyed by `destroy` alone.
struct ClassInfo {
  std::uint32_t size = sizeof(ClassInfo);     ///< bytes that the plugin knows of this struct
  PluginKind kind = PluginKind::environment;  ///< what `create` makes
  const char* id = "";                        ///< About::id
  const char* doc = "";                       ///< About::doc
  const ParameterInfo* parameters = nullptr;  ///< `parameter_count` of them, owned by the plugin
  std::uint64_t parameter_count = 0;          ///< of `parameters`
  void* (*create)(const Value* parameters) = nullptr;  ///< parameters: a group
  void (*destroy)(void* instance) = nullptr;           ///< takes what `create` returned; no throw
};

/// One library. `size` counts what the plugin knows: later SDKs of the same revision may append,
/// and a host reads what is there.
struct PluginInfo {
  std::uint32_t size = sizeof(PluginInfo);     ///< bytes that the plugin knows of this struct
  std::uint32_t abi = SOMAS_ABI_REVISION;      ///< the revision that it was built for
  const char* fingerprint = "";                ///< SOMAS_FINGERPRINT, as in the note
  const char* id = "";                         ///< of the library: "example.breeze"
  const char* version = "";                    ///< of the library: "1.0"
  const ClassInfo* classes = nullptr;          ///< `class_count` of them, owned by the plugin
  std::uint64_t class_count = 0;               ///< of `classes`
  void (*attach)(const Host* host) = nullptr;  ///< called once, after the table was accepted; may
                                               ///< be null. The host lives until the process ends.
};

/// The one symbol that a plugin exports. What it returns lives as long as the library.
using PluginEntry = const PluginInfo* (*)();
/// Name of that symbol.
inline constexpr const char* plugin_entry_name = "somas_plugin";
/// Name of the section that holds the PluginNote.
inline constexpr const char* plugin_note_section = ".note.somas";

/// ELF note: owner "SOMAS", type 1, description = the fingerprint, zero-padded.
struct PluginNote {
  std::uint32_t name_size = 6;                ///< with the NUL
  std::uint32_t description_size = 128;       ///< with the padding
  std::uint32_t type = 1;                     ///< 1: a fingerprint
  char name[8] = "SOMAS";                     ///< the owner, padded to a multiple of four
  char description[128] = SOMAS_FINGERPRINT;  ///< what host and plugin must agree on
};

}  // namespace somas
