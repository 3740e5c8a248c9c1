#include "core/experiment/node.hpp"

#include <charconv>

namespace somas::experiment {
namespace {

// An element's index; `none` unless the text is a whole number.
constexpr std::size_t none = static_cast<std::size_t>(-1);

std::size_t index_of(std::string_view text) {
  std::size_t index = none;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  return error == std::errc() && end == text.data() + text.size() ? index : none;
}

std::string shortened(const std::string& text) {
  constexpr std::size_t longest = 60;
  return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

}  // namespace

const Node* Node::find(std::string_view name) const {
  if (kind != Kind::mapping) return nullptr;
  for (const Node& item : items)
    if (item.key == name) return &item;
  return nullptr;
}

Node* Node::find(std::string_view name) {
  return const_cast<Node*>(static_cast<const Node*>(this)->find(name));
}

void Node::erase(std::string_view name) {
  std::erase_if(items, [&](const Node& item) { return item.key == name; });
}

std::string Node::description() const {
  switch (kind) {
    case Kind::null:
      return "nothing (null)";
    case Kind::sequence:
      return "a list";
    case Kind::mapping:
      return "a mapping";
    case Kind::scalar:
      break;
  }
  return (quoted ? "the text '" : "'") + shortened(text) + "'";
}

std::vector<std::string> keys_of(const Node& mapping) {
  std::vector<std::string> keys;
  for (const Node& item : mapping.items) keys.push_back(item.key);
  return keys;
}

std::string indexed(const std::string& path, std::size_t index) {
  return std::string(path).append("[").append(std::to_string(index)).append("]");
}

std::vector<std::string> path_segments(std::string_view path) {
  std::vector<std::string> segments(1);
  for (const char c : path) {
    if (c == ']') continue;
    if (c == '.' || c == '[') {
      segments.emplace_back();
    } else {
      segments.back() += c;
    }
  }
  return segments;
}

Child child_of(const Node& parent, std::span<const std::string> segments) {
  if (segments.empty()) return {};
  if (parent.kind == Node::Kind::sequence) {
    const std::size_t index = index_of(segments[0]);
    if (index < parent.items.size()) return {&parent.items[index], 1};
    return {};
  }

  // The longest key first: "resistance.heat" is one key of a table.
  for (std::size_t count = segments.size(); count > 0; --count) {
    std::string key = segments[0];
    for (std::size_t i = 1; i < count; ++i) key += "." + segments[i];
    if (const Node* found = parent.find(key)) return {found, count};
  }
  return {};
}

const Node& nearest(const Node& root, std::string_view path) {
  const std::vector<std::string> all = path_segments(path);
  std::span<const std::string> rest = all;
  const Node* at = &root;
  while (!rest.empty()) {
    const Child child = child_of(*at, rest);
    if (child.node == nullptr) break;
    at = child.node;
    rest = rest.subspan(child.segments);
  }
  return *at;
}

}  // namespace somas::experiment
