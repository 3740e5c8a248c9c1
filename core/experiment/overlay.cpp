#include "core/experiment/overlay.hpp"

#include <algorithm>
#include <vector>

#include "core/experiment/reader.hpp"
#include "core/plugins/installation.hpp"
#include "core/plugins/suggest.hpp"

namespace somas::experiment {
namespace {

using Segments = std::span<const std::string>;

// ---- layers ------------------------------------------------------------------------------------

// Where a mapping stands decides what a merge means there.
enum class Place { root, environments, sweep, block, plain };

Place below(Place level, const std::string& key) {
  if (level == Place::environments) return Place::block;
  if (level != Place::root) return Place::plain;
  if (key == "environments") return Place::environments;
  if (key == "sweep") return Place::sweep;
  const bool is_block = key == "specialization" || key == "controller" || key == "fitness";
  return is_block ? Place::block : Place::plain;
}

// The plugin that a block names; an environment's own name stands for it.
std::string plugin_of(const Node& block) {
  const Node* plugin = block.find("plugin");
  return plugin != nullptr ? plugin->text : block.key;
}

bool replaces_plugin(const Node& base, const Node& over) {
  return over.find("plugin") != nullptr && plugin_of(base) != plugin_of(over);
}

void merge(Node& base, Node over, Place level) {
  base.position = over.position;
  base.key_position = over.key_position;
  for (Node& entry : over.items) {
    Node* inherited = base.find(entry.key);
    const Place entry_level = below(level, entry.key);
    const bool both_map = inherited != nullptr && inherited->kind == Node::Kind::mapping &&
                          entry.kind == Node::Kind::mapping;
    if (inherited == nullptr) {
      base.items.push_back(std::move(entry));
    } else if ((level == Place::environments || level == Place::sweep) &&
               entry.kind == Node::Kind::null) {
      base.erase(entry.key);
    } else if (both_map && !(entry_level == Place::block && replaces_plugin(*inherited, entry))) {
      merge(*inherited, std::move(entry), entry_level);
    } else {
      *inherited = std::move(entry);
    }
  }
}

// ---- extends -----------------------------------------------------------------------------------

// A file on the way from the experiment to its last base.
struct Link {
  std::filesystem::path real;
  std::string name;
};

std::string chain_text(const std::vector<Link>& chain, const std::string& last) {
  std::string text;
  for (const Link& link : chain) text += link.name + " -> ";
  return text + last;
}

// A name alone that is not beside the file: an experiment that comes with SOMAS.
std::filesystem::path base_of(const std::filesystem::path& file,
                              const std::filesystem::path& name) {
  const std::filesystem::path beside = (file.parent_path() / name).lexically_normal();
  const std::filesystem::path bundled = plugins::share_directory() / "experiments" / name;
  std::error_code error;
  const bool take_bundled = !name.has_parent_path() && !std::filesystem::exists(beside, error) &&
                            std::filesystem::exists(bundled, error);
  return take_bundled ? bundled : beside;
}

Node read_layer(const std::filesystem::path& file, const std::string& text,
                std::vector<Link>& chain) {
  Node root = parse_yaml(text, file.string());
  if (root.kind == Node::Kind::null) throw InputError(root.position, "the file is empty");
  if (root.kind != Node::Kind::mapping)
    throw InputError(root.position,
                     "an experiment is a mapping of keys, found " + root.description());
  const Node* extends = root.find("extends");
  if (extends == nullptr) return root;
  if (extends->kind != Node::Kind::scalar || extends->text.empty())
    throw InputError(extends->position,
                     "extends: expected a file's name, found " + extends->description());

  // The base, unless it is on the way here already.
  const std::filesystem::path base_file = base_of(file, extends->text);
  std::error_code error;
  chain.push_back({std::filesystem::weakly_canonical(file, error), file.string()});
  const std::filesystem::path real = std::filesystem::weakly_canonical(base_file, error);
  const auto on_the_way = [&](const Link& link) { return link.real == real; };
  if (std::any_of(chain.begin(), chain.end(), on_the_way))
    throw InputError(extends->position,
                     "extends: a cycle: " + chain_text(chain, base_file.string()));
  std::string base_text;
  try {
    base_text = read_text(base_file);
  } catch (const InputError& failure) {
    // A file that cannot be read has no lines: blame the one that asks for it.
    if (failure.position().line != 0) throw;
    throw InputError(extends->position, std::string("extends: ") + failure.what());
  }

  Node base = read_layer(base_file, base_text, chain);
  base.erase("name");
  root.erase("extends");
  overlay(base, std::move(root));
  return base;
}

// ---- overrides ---------------------------------------------------------------------------------

struct Assignment {
  std::string path;
  std::string value;
};

Assignment split(const Override& given) {
  const std::size_t equals = given.text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError(given.position, "expected path.to.key=value");
  return {given.text.substr(0, equals), given.text.substr(equals + 1)};
}

bool is_index(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

// Whether the segments lead to the `plugin` of a block.
bool names_plugin(Segments path) {
  if (path.empty() || path.back() != "plugin") return false;
  if (path.size() == 3) return path[0] == "environments";
  return path.size() == 2 && below(Place::root, path[0]) == Place::block;
}

[[noreturn]] void no_way(const Node& at, const std::string& so_far, const Position& position,
                         const std::string& segment) {
  if (at.kind == Node::Kind::sequence) {
    const std::string range =
        at.items.empty() ? "" : " (0 to " + std::to_string(at.items.size() - 1) + ")";
    throw InputError(position, so_far + ": a list of " +
                                   plugins::plural(at.items.size(), "element") + range + ", '" +
                                   segment + "' is none of them");
  }
  throw InputError(
      position, so_far + ": is " + at.description() + ", there is no '" + segment + "' below it");
}

// A new child for the segment; a number that finds no list is an index into the default.
Node& add_child(Node& at, const std::string& segment, const Position& position) {
  if (is_index(segment) && at.items.empty()) at.patch = true;
  at.kind = Node::Kind::mapping;
  Node child;
  child.key = segment;
  child.position = child.key_position = position;
  return at.items.emplace_back(std::move(child));
}

// Another plugin has other parameters.
void clear_for_plugin(Node& root, Segments path, const std::string& plugin) {
  Node* block = &root;
  for (const std::string& segment : path.first(path.size() - 1))
    if (block != nullptr) block = block->find(segment);
  if (block == nullptr || plugin_of(*block) == plugin) return;
  std::erase_if(block->items, [](const Node& item) { return item.key != "plugin"; });
}

[[noreturn]] void unknown_environment(const Node& environments, const std::string& name,
                                      const Position& position) {
  std::vector<std::string> known = keys_of(environments);
  std::erase(known, name);
  throw InputError(position, "environments." + name + ": there is no such environment; have: " +
                                 plugins::join(known) + plugins::did_you_mean(name, known));
}

}  // namespace

void overlay(Node& base, Node over) { merge(base, std::move(over), Place::root); }

Node read_tree(const std::filesystem::path& file, const std::string& text) {
  std::vector<Link> chain;
  return read_layer(file, text, chain);
}

bool chooses_plugin(const std::string& assignment) {
  const std::vector<std::string> segments =
      path_segments(assignment.substr(0, assignment.find('=')));
  return names_plugin(segments);
}

Override set_by_hand(const std::string& assignment) {
  const Position position{"--set " + assignment, 0, 0};
  return {assignment, position, position};
}

void apply_override(Node& root, const Override& given) {
  const Assignment assignment = split(given);
  const Position& position = given.key_position;
  const std::vector<std::string> segments = path_segments(assignment.path);
  if (std::any_of(segments.begin(), segments.end(), [](const auto& s) { return s.empty(); }))
    throw InputError(position, assignment.path + ": a part of the path is empty");
  if (segments[0] == "extends")
    throw InputError(position,
                     "extends: cannot be set here; write it into a file, and run that one");
  if (segments[0] == "sweep")
    throw InputError(position, "sweep: cannot be set here; use --sweep KEY=VALUE,VALUE,...");
  Node value = parse_value(assignment.value, given.position);

  if (names_plugin(segments)) clear_for_plugin(root, segments, value.text);

  // Down as far as the tree goes, and on by creating what is missing.
  Node* at = &root;
  Node* parent = nullptr;
  bool is_new = false;
  std::string so_far;
  for (Segments rest = segments; !rest.empty();) {
    const Child child = child_of(*at, rest);
    const std::size_t count = child.node != nullptr ? child.segments : 1;
    const bool closed = at->kind == Node::Kind::sequence || at->kind == Node::Kind::scalar;
    if (child.node == nullptr && closed) no_way(*at, so_far, position, rest[0]);
    parent = at;
    is_new = child.node == nullptr;
    at = child.node != nullptr ? const_cast<Node*>(child.node) : &add_child(*at, rest[0], position);
    for (const std::string& segment : rest.first(count))
      so_far += (so_far.empty() ? "" : ".") + segment;
    rest = rest.subspan(count);
  }

  // A null environment is none.
  if (segments.size() == 2 && segments[0] == "environments" && value.kind == Node::Kind::null) {
    if (is_new) unknown_environment(*parent, segments[1], position);
    parent->erase(segments[1]);
    return;
  }
  value.key = at->key;
  value.key_position = position;
  *at = std::move(value);
}

}  // namespace somas::experiment
