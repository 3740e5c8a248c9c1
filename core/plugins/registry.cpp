#include "core/plugins/registry.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/plugins/installation.hpp"
#include "core/plugins/suggest.hpp"

namespace somas::plugins {
namespace {

// The directory's plugin files by name; nothing where there is no such directory.
std::vector<std::filesystem::path> plugin_files(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().filename().string().ends_with(plugin_suffix)) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string with_article(const std::string& noun) {
  return (noun.starts_with("e") ? "an " : "a ") + noun;
}

}  // namespace

std::vector<SearchDirectory> standard_search_path() {
  std::vector<SearchDirectory> path;
  if (const char* variable = std::getenv("SOMAS_PLUGIN_PATH")) {
    std::string_view rest = variable;
    while (!rest.empty()) {
      const std::string_view part = rest.substr(0, rest.find(':'));
      rest.remove_prefix(std::min(rest.size(), part.size() + 1));
      if (!part.empty()) path.push_back({part, "SOMAS_PLUGIN_PATH"});
    }
  }
  const std::filesystem::path here = executable_directory();
  if (here.empty()) return path;
  path.push_back({(here / "../lib/somas/plugins").lexically_normal(), "installation"});
  path.push_back({(here / "../plugins").lexically_normal(), "build tree"});
  return path;
}

Registry::Registry(std::vector<SearchDirectory> search_path)
    : search_path_(std::move(search_path)) {
  for (const SearchDirectory& place : search_path_) look_into(place.directory);
  collect_classes();
}

Registry Registry::of(std::shared_ptr<const Library> library) {
  Registry registry{std::vector<SearchDirectory>{}};
  registry.candidates_.push_back({library->file(), library, {}});
  registry.collect_classes();
  return registry;
}

void Registry::collect_classes() {
  for (const Candidate& candidate : candidates_) {
    if (candidate.library == nullptr) continue;
    for (const ClassInfo& info : candidate.library->classes())
      classes_[info.id].push_back({candidate.library, &info});
  }
}

void Registry::look_into(const std::filesystem::path& directory) {
  for (const std::filesystem::path& file : plugin_files(directory)) {
    // One file may be reached by several ways.
    std::error_code error;
    const bool known = std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& c) {
      return std::filesystem::equivalent(c.file, file, error);
    });
    if (known) continue;

    Candidate candidate{file, nullptr, {}};
    try {
      candidate.library = Library::open(file);
    } catch (const BadPlugin& bad) {
      candidate.reason = bad.what();
    }
    candidates_.push_back(std::move(candidate));
  }
}

const std::vector<PluginClass>& Registry::unique(const std::string& id) const {
  static const std::vector<PluginClass> none;
  const auto entry = classes_.find(id);
  if (entry == classes_.end()) return none;
  const std::vector<PluginClass>& found = entry->second;
  if (found.size() > 1)
    throw LookupError("two plugins define '" + id + "': " + found[0].library->file().string() +
                      " and " + found[1].library->file().string() +
                      "; remove one of them, or its directory from the search path");
  return found;
}

PluginClass Registry::find(PluginKind kind, const std::string& id) const {
  const std::vector<PluginClass>& found = unique(id);
  if (found.empty()) throw LookupError(missing(kind_name(kind), id, ids(kind)));
  if (found[0].info->kind != kind)
    throw LookupError("'" + id + "' is " + with_article(kind_name(found[0].info->kind)) + ", not " +
                      with_article(kind_name(kind)) + "; available: " + join(ids(kind)));
  return found[0];
}

PluginClass Registry::find(const std::string& id) const {
  const std::vector<PluginClass>& found = unique(id);
  if (found.empty()) throw LookupError(missing("plugin", id, ids()));
  return found[0];
}

std::string Registry::missing(const std::string& what, const std::string& id,
                              const std::vector<std::string>& known) const {
  std::string text = "no " + what + " '" + id + "'; available: " + join(known) +
                     did_you_mean(id, known) + "\n  searched:";
  for (const SearchDirectory& place : search_path_) {
    std::error_code error;
    const bool exists = std::filesystem::is_directory(place.directory, error);
    text += "\n    " + place.directory.string() + " (" + place.source +
            (exists ? ")" : ", does not exist)");
  }
  if (search_path_.empty()) text += " nowhere";
  for (const Candidate& candidate : candidates_)
    if (candidate.library == nullptr)
      text += "\n  rejected: " + candidate.file.string() + ": " + candidate.reason;
  return text;
}

std::vector<std::string> Registry::ids(PluginKind kind) const {
  std::vector<std::string> found;
  for (const auto& [id, classes] : classes_)
    if (classes[0].info->kind == kind) found.push_back(id);
  return found;
}

std::vector<std::string> Registry::ids() const {
  std::vector<std::string> found;
  for (const auto& [id, classes] : classes_) found.push_back(id);
  return found;
}

std::map<std::string, std::vector<std::filesystem::path>> Registry::duplicates() const {
  std::map<std::string, std::vector<std::filesystem::path>> found;
  for (const auto& [id, classes] : classes_)
    if (classes.size() > 1)
      for (const PluginClass& one : classes) found[id].push_back(one.library->file());
  return found;
}

}  // namespace somas::plugins
