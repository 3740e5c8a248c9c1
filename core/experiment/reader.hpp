// Strict reading of one YAML file into a Node tree.
#pragma once

#include <filesystem>
#include <string>

#include "core/experiment/node.hpp"

namespace somas::experiment {

inline constexpr std::size_t largest_file = 1 << 20;  ///< bytes
inline constexpr std::size_t deepest_nesting = 64;

/// The bytes of a file of YAML. Throws InputError: missing, no regular file, too large, not UTF-8
/// text.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);

/// What is wrong with an experiment's name; empty: nothing.
[[nodiscard]] std::string fault_in_name(const std::string& text);

/// Parses one YAML document. `origin` names it in messages. Beyond YAML's own rules it refuses
/// duplicate and non-text keys, anchors, aliases, tags, merge keys, several documents, and nesting
/// beyond deepest_nesting. Throws InputError.
[[nodiscard]] Node parse_yaml(const std::string& text, const std::string& origin);

/// Parses the value of an override, all of whose positions are that of the override.
[[nodiscard]] Node parse_value(const std::string& text, const Position& position);

}  // namespace somas::experiment
