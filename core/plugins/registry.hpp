// Which plugins there are: discovery of *.somas.so files, and look-up of classes by id.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/plugins/library.hpp"

namespace somas::plugins {

inline constexpr std::string_view plugin_suffix = ".somas.so";

/// A directory to look into, and who asked for it ("--plugin-path", "build tree").
struct SearchDirectory {
  std::filesystem::path directory;
  std::string source;
};

/// What follows the caller's own directories: SOMAS_PLUGIN_PATH (separated by colons), the install
/// directory and the build tree, both relative to the executable.
[[nodiscard]] std::vector<SearchDirectory> standard_search_path();

/// A file that was looked at.
struct Candidate {
  std::filesystem::path file;
  std::shared_ptr<const Library> library;  ///< null: rejected
  std::string reason;                      ///< why rejected
};

/// No usable class of that id and kind. what() is the whole story, without the place that asked.
class LookupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Registry {
 public:
  /// Looks through the directories in order, and through each by file name; loads what is sound.
  explicit Registry(std::vector<SearchDirectory> search_path);
  /// Has the classes of this library, and looks nowhere.
  [[nodiscard]] static Registry of(std::shared_ptr<const Library> library);

  /// The class. Throws LookupError: unknown (with search path, rejected files, ids and a
  /// suggestion), of another kind, or defined by two libraries.
  [[nodiscard]] PluginClass find(PluginKind kind, const std::string& id) const;
  /// The class of whatever kind. Throws LookupError.
  [[nodiscard]] PluginClass find(const std::string& id) const;

  [[nodiscard]] const std::vector<SearchDirectory>& search_path() const { return search_path_; }
  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }
  /// Ids of a kind, sorted.
  [[nodiscard]] std::vector<std::string> ids(PluginKind kind) const;
  /// All ids, sorted.
  [[nodiscard]] std::vector<std::string> ids() const;
  /// Ids that more than one library defines, with those files.
  [[nodiscard]] std::map<std::string, std::vector<std::filesystem::path>> duplicates() const;

 private:
  void look_into(const std::filesystem::path& directory);
  void collect_classes();
  [[nodiscard]] const std::vector<PluginClass>& unique(const std::string& id) const;
  [[nodiscard]] std::string missing(const std::string& what, const std::string& id,
                                    const std::vector<std::string>& known) const;

  std::vector<SearchDirectory> search_path_;
  std::vector<Candidate> candidates_;
  std::map<std::string, std::vector<PluginClass>> classes_;
};

}  // namespace somas::plugins
