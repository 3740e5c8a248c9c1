// One tree out of several sources: a file, the files it extends, and overrides.
#pragma once

#include <filesystem>
#include <string>

#include "core/experiment/node.hpp"

namespace somas::experiment {

/// Lays `over` upon `base`: mappings merge, everything else replaces. A plugin's block whose
/// `plugin` differs is replaced as a whole; an environment, or a factor of the sweep, that is null
/// is removed. The experiment's `name` is not inherited.
void overlay(Node& base, Node over);

/// Reads `text`, the content of `file`, and everything it extends, nearest last. The result has no
/// `extends`. Throws InputError, also for a cycle.
[[nodiscard]] Node read_tree(const std::filesystem::path& file, const std::string& text);

/// "path.to.key=value" as --set gives it.
[[nodiscard]] Override set_by_hand(const std::string& assignment);

/// Applies "path.to.key=value" to the tree; keys that are missing are created, so that validation
/// names unknown ones. Throws InputError.
void apply_override(Node& root, const Override& given);

/// Whether the override chooses the plugin of a block: those come before all others.
[[nodiscard]] bool chooses_plugin(const std::string& assignment);

}  // namespace somas::experiment
