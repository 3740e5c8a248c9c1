#include "core/plugins/library.hpp"

#include <cassert>
#include <map>
#include <mutex>

#include <boost/dll/shared_library.hpp>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "core/plugins/check.hpp"
#include "core/plugins/installation.hpp"
#include "core/plugins/services.hpp"

namespace somas::plugins {
namespace {

#if defined(__SSE__)
// The control bits; the low six are sticky exception flags that any arithmetic sets.
unsigned float_mode() { return _mm_getcsr() & ~0x3Fu; }
void set_float_mode(unsigned mode) { _mm_setcsr((_mm_getcsr() & 0x3Fu) | mode); }
#else
unsigned float_mode() { return 0; }
void set_float_mode(unsigned) {}
#endif

// Boost's text is "... (dlerror system message: TEXT): misleading errno".
std::string loader_message(std::string_view text, const std::filesystem::path& file) {
  constexpr std::string_view before = "dlerror system message: ";
  if (const auto start = text.find(before); start != std::string_view::npos)
    text.remove_prefix(start + before.size());
  if (const auto end = text.rfind("): "); end != std::string_view::npos) text = text.substr(0, end);
  const std::string name = file.string() + ": ";
  if (text.starts_with(name)) text.remove_prefix(name.size());
  return std::string(text);
}

const PluginInfo* call_entry(boost::dll::shared_library& library) {
  if (!library.has(plugin_entry_name))
    throw BadPlugin(std::string("has no symbol ") + plugin_entry_name +
                    ": built without SOMAS_PLUGIN, or not with somas_add_plugin; rebuild it so");
  try {
    return library.get<const PluginInfo*()>(plugin_entry_name)();
  } catch (const std::exception& error) {
    throw BadPlugin(std::string("describing its parameters failed: ") + error.what() +
                    "; this is a fault of the plugin");
  } catch (...) {
    throw BadPlugin(
        "describing its parameters failed with something that is no std::exception; "
        "this is a fault of the plugin");
  }
}

}  // namespace

struct Library::Handle {
  boost::dll::shared_library library;
};

std::string kind_name(PluginKind kind) {
  switch (kind) {
    case PluginKind::environment:
      return "environment";
    case PluginKind::specialization:
      return "specialization";
    case PluginKind::controller:
      return "controller";
    case PluginKind::fitness:
      return "fitness";
  }
  return "unknown kind";
}

Library::Library(const std::filesystem::path& file)
    : file_(file), fingerprint_(read_fingerprint(file)) {
  check_fingerprint(fingerprint_);

  // A handle is never closed, not even of a refused library: its code may be registered somewhere.
  static auto& handles = *new std::vector<std::shared_ptr<Handle>>;
  handle_ = handles.emplace_back(std::make_shared<Handle>());

  // Code built with -ffast-math switches the whole process to flush-to-zero while it is loaded.
  const unsigned mode = float_mode();
  try {
    handle_->library.load(file,
                          boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  } catch (const std::exception& error) {
    set_float_mode(mode);
    throw BadPlugin("the system's loader refuses it: " + loader_message(error.what(), file) +
                    "; build it with somas_add_plugin, which finds such faults at the link");
  }
  const bool changed = float_mode() != mode;
  set_float_mode(mode);
  if (changed)
    throw BadPlugin(
        "changes the floating-point mode of the whole process when loaded (built with -ffast-math "
        "or -Ofast?); rebuild it without");

  accept(call_entry(handle_->library));
}

Library::Library(const PluginInfo* table) : file_(executable_file()) {
  accept(table);
  fingerprint_ = table->fingerprint;
}

void Library::accept(const PluginInfo* table) {
  check_table(table);
  id_ = table->id;
  version_ = table->version;
  classes_ = {table->classes, table->class_count};

  // Never freed: the library stays loaded, and may speak at any time.
  if (table->attach != nullptr) table->attach(new HostServices(id_));
}

std::shared_ptr<const Library> Library::open(const std::filesystem::path& file) {
  // The verdict of a file is kept, so that a refused one is not loaded again.
  struct Verdict {
    std::shared_ptr<const Library> library;
    std::string reason;
  };
  static std::mutex mutex;
  static auto& verdicts = *new std::map<std::filesystem::path, Verdict>;

  const std::lock_guard lock(mutex);
  std::error_code error;
  std::filesystem::path real = std::filesystem::canonical(file, error);
  if (error) throw BadPlugin("no such file");
  const auto [entry, is_new] = verdicts.try_emplace(real);
  Verdict& verdict = entry->second;
  if (is_new) {
    try {
      verdict.library = std::shared_ptr<const Library>(new Library(real));
    } catch (const BadPlugin& bad) {
      verdict.reason = bad.what();
    }
  }
  if (verdict.library == nullptr) throw BadPlugin(verdict.reason);
  return verdict.library;
}

std::shared_ptr<const Library> Library::linked_in(const PluginInfo* table) {
  return std::shared_ptr<const Library>(new Library(table));
}

void* PluginClass::construct(PluginKind kind, const ParameterValue& parameters) const {
  assert(info->kind == kind);
  static_cast<void>(kind);
  const PackedValue packed(parameters);
  return info->create(&packed.value());
}

}  // namespace somas::plugins
