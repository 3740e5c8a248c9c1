#include "core/plugins/project.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <stdlib.h>

#include "core/plugins/library.hpp"

namespace somas::plugins {
namespace {

namespace fs = std::filesystem;

// Targets that CMake keeps for itself, words that YAML or a template gives another meaning.
const std::set<std::string> reserved = {
    "all",         "clean", "depend",     "edit_cache", "environment", "experiment",
    "experiments", "false", "fitness",    "genes",      "help",        "install",
    "linear",      "no",    "none",       "null",       "off",         "on",
    "package",     "pair",  "parameters", "plugin",     "program",     "rebuild_cache",
    "somas",       "test",  "true",       "weights",    "yes",         "linear_program"};

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

struct Words {
  std::string kind, name, class_name, sources;

  [[nodiscard]] std::string filled(std::string text) const {
    // The tokens in @ first: a name may be part of nothing else then.
    replace_all(text, "@SDK_VERSION@", SOMAS_SDK_VERSION);
    replace_all(text, "@SOURCES@", sources);
    replace_all(text, "@KIND@", kind);
    replace_all(text, "my_plugin", name);
    replace_all(text, "MyPlugin", class_name);
    return text;
  }
};

std::string read_template(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in && !in.eof()) throw ProjectError(file.string() + " cannot be read");
  return text;
}

// The files of a template by name; a name is a template as well.
std::vector<fs::path> files_in(const fs::path& directory) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error))
    files.push_back(entry->path());
  if (error || files.empty())
    throw ProjectError("the templates are missing: " + directory.string() +
                       "; install SOMAS whole, or run the host where it was installed or built");
  std::sort(files.begin(), files.end());
  return files;
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw ProjectError(file.string() + " cannot be written: " + std::strerror(errno));
}

// Sources that a template has beside plugin.cpp.
std::string more_sources(const std::vector<fs::path>& files) {
  std::string sources;
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    if (name.ends_with(".cpp") && !name.ends_with("_test.cpp")) sources += " " + name;
  }
  return sources;
}

// A new directory beside `directory`, which becomes it when all is written.
class Scratch {
 public:
  explicit Scratch(const fs::path& directory) {
    std::string name = directory.string() + ".XXXXXX";
    if (::mkdtemp(name.data()) == nullptr)
      throw ProjectError(directory.string() + " cannot be made: " + std::strerror(errno));
    path_ = name;
    fs::permissions(path_, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                               fs::perms::others_read | fs::perms::others_exec);
  }
  ~Scratch() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  void become(const fs::path& directory) {
    std::error_code error;
    fs::rename(path_, directory, error);
    if (error) throw ProjectError(directory.string() + " cannot be made: " + error.message());
    path_.clear();
  }

 private:
  fs::path path_;
};

// The place of the project: absolute, without a slash at its end, its parent there.
fs::path place_for(const fs::path& directory) {
  if (directory.empty()) throw ProjectError("the directory's name is empty");
  fs::path place = fs::absolute(directory).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();
  std::error_code error;
  if (fs::exists(place, error) && !(fs::is_directory(place, error) && fs::is_empty(place, error)))
    throw ProjectError(directory.string() +
                       " exists already and is no empty directory; name another");
  fs::create_directories(place.parent_path(), error);
  if (error)
    throw ProjectError(place.parent_path().string() + " cannot be made: " + error.message());
  return place;
}

}  // namespace

void check_project_name(const std::string& name) {
  constexpr std::size_t longest = 64;
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  };
  const bool word = !name.empty() && name[0] >= 'a' && name[0] <= 'z' &&
                    std::all_of(name.begin(), name.end(), allowed) && name.back() != '_';
  if (!word || name.size() > longest || name.find("__") != std::string::npos)
    throw ProjectError(
        "'" + name +
        "' cannot be the name of a plugin; use lower_snake_case, at most 64 letters, "
        "digits and single _, a letter first: salt_marsh");
  if (reserved.contains(name) || name.ends_with("_test"))
    throw ProjectError("'" + name +
                       "' has a meaning of its own in such a project; choose another "
                       "name");
}

std::string class_name_of(const std::string& name) {
  std::string result;
  bool upper = true;
  for (const char c : name) {
    if (c != '_') result += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    upper = c == '_';
  }
  return result;
}

std::vector<fs::path> write_project(PluginKind kind, const std::string& name,
                                    const fs::path& directory, const fs::path& templates) {
  check_project_name(name);
  const fs::path place = place_for(directory);
  std::vector<fs::path> sources = files_in(templates / kind_name(kind));
  const Words words{kind_name(kind), name, class_name_of(name), more_sources(sources)};
  for (const fs::path& common : files_in(templates / "common")) sources.push_back(common);

  Scratch scratch(place);
  std::vector<fs::path> written;
  for (const fs::path& source : sources) {
    std::string file = words.filled(source.filename().string());
    if (file == "gitignore") file = ".gitignore";
    write_text(scratch.path() / file, words.filled(read_template(source)));
    written.emplace_back(file);
  }
  scratch.become(place);
  std::sort(written.begin(), written.end());
  return written;
}

}  // namespace somas::plugins
