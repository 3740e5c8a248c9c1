// A YAML document as a tree that remembers where everything stands.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/experiment.hpp"

namespace somas::experiment {

/// A value, with its key where it stands in a mapping.
struct Node {
  enum class Kind { null, scalar, sequence, mapping };

  Kind kind = Kind::null;
  bool quoted = false;      ///< scalars: in quotes, or a block of text; so a text, never a number
  bool patch = false;       ///< mappings from an override: list indices to new elements
  std::string text;         ///< scalars
  std::string key;          ///< within a mapping
  Position position;        ///< of the value
  Position key_position;    ///< of the key, else of the value
  std::vector<Node> items;  ///< elements of a sequence, entries of a mapping (unique keys)

  [[nodiscard]] const Node* find(std::string_view name) const;
  [[nodiscard]] Node* find(std::string_view name);
  void erase(std::string_view name);

  /// "the text 'x'", "a list", "a mapping", "nothing": for messages.
  [[nodiscard]] std::string description() const;
};

/// The keys of a mapping, in order.
[[nodiscard]] std::vector<std::string> keys_of(const Node& mapping);

/// "a.b[2]" from "a.b" and 2.
[[nodiscard]] std::string indexed(const std::string& path, std::size_t index);

/// The parts of "a.b[2].c" or "a.b.2.c".
[[nodiscard]] std::vector<std::string> path_segments(std::string_view path);

/// The child that the first segments name, and how many they are; a key may contain dots.
struct Child {
  const Node* node = nullptr;
  std::size_t segments = 0;
};
[[nodiscard]] Child child_of(const Node& parent, std::span<const std::string> segments);

/// The node at `path` below `root`, or the nearest that encloses it.
[[nodiscard]] const Node& nearest(const Node& root, std::string_view path);

}  // namespace somas::experiment
