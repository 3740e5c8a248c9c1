// What a plugin class declares, found by making an instance and asking it.
#pragma once

#include <string>

#include "core/plugins/library.hpp"

namespace somas::plugins {

/// Markdown for the class's reference: phases, skills, sensors, resources and all else that an
/// environment declares, the objective of a fitness, whether a tree evolves. Parameters have their
/// defaults, required ones examples; a class that refuses these is said to. Empty for a controller,
/// which declares nothing. Runs code of the plugin.
[[nodiscard]] std::string declarations(const PluginClass& described);

}  // namespace somas::plugins
