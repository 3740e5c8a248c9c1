#include "plugins/specialization/evolved_tree/genes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plugins/common/bytes.hpp"

namespace somas::specialization {

namespace {

constexpr std::uint32_t plain_format = 1, attributes_format = 2;
constexpr std::uint32_t root_mark = 0xFFFFFFFFu;
constexpr std::uint32_t most = 4096;  // of skills, states, attributes or pairs, in any bytes

void require(bool fine, const char* what) {
  if (!fine) throw std::runtime_error(std::string("the genes of the tree: ") + what);
}

void check_states(const TreeGenes& tree) {
  for (std::size_t s = 0; s < tree.states.size(); ++s) {
    const TreeState& state = tree.states[s];
    require((s == 0) == (state.parent == no_parent), "one state, the first, is the root");
    require(s == 0 || state.parent < s, "a parent must stand before its child");
    require(tree.find(state.key) == s, "two states have one key");
    for (const double points : state.points)
      require(std::isfinite(points), "points must be finite numbers");
    for (const double value : state.attributes)
      require(std::isfinite(value), "attributes must be finite numbers");
  }
}

std::pair<std::uint64_t, std::uint64_t> keys_of(const AdhesionGene& pair) {
  return {pair.first, pair.second};
}

void check_pairs(const TreeGenes& tree) {
  for (const AdhesionGene& pair : tree.pairs) {
    require(pair.first < pair.second, "the keys of a pair are out of order");
    require(tree.find(pair.first) && tree.find(pair.second), "a pair names a state that is none");
    require(std::isfinite(pair.strength), "strengths must be finite numbers");
  }
  require(
      std::ranges::adjacent_find(tree.pairs, std::greater_equal<>(), keys_of) == tree.pairs.end(),
      "pairs are out of order");
}

void require_ascending(const std::vector<std::uint64_t>& keys, const char* what) {
  require(std::ranges::adjacent_find(keys, std::greater_equal<>()) == keys.end(), what);
}

}  // namespace

std::optional<std::size_t> TreeGenes::find(std::uint64_t key) const {
  for (std::size_t s = 0; s < states.size(); ++s)
    if (states[s].key == key) return s;
  return std::nullopt;
}

std::size_t TreeGenes::depth(std::size_t state) const {
  std::size_t levels = 1;
  for (; states[state].parent != no_parent; state = states[state].parent) ++levels;
  return levels;
}

std::size_t TreeGenes::depth() const {
  std::size_t deepest = 0;
  for (std::size_t s = 0; s < states.size(); ++s) deepest = std::max(deepest, depth(s));
  return deepest;
}

std::size_t TreeGenes::add(TreeState state) {
  states.push_back(std::move(state));
  return states.size() - 1;
}

void TreeGenes::remove(std::size_t state) {
  const std::size_t parent = states[state].parent;
  const std::uint64_t key = states[state].key;
  std::erase_if(pairs, [&](const AdhesionGene& p) { return p.first == key || p.second == key; });
  for (TreeState& other : states) {
    if (other.parent == state) other.parent = parent;
    if (other.parent != no_parent && other.parent > state) --other.parent;
  }
  states.erase(states.begin() + static_cast<std::ptrdiff_t>(state));
}

std::optional<double> TreeGenes::adhesion(std::uint64_t a, std::uint64_t b) const {
  for (const AdhesionGene& pair : pairs)
    if (pair.is_of(a, b)) return pair.strength;
  return std::nullopt;
}

void TreeGenes::set_adhesion(std::uint64_t a, std::uint64_t b, std::optional<double> strength) {
  std::erase_if(pairs, [&](const AdhesionGene& pair) { return pair.is_of(a, b); });
  if (!strength) return;
  pairs.push_back({std::min(a, b), std::max(a, b), *strength});
  std::ranges::sort(pairs, {}, keys_of);
}

void TreeGenes::sort() {
  std::vector<std::size_t> order, todo;
  for (std::size_t s = 0; s < states.size(); ++s)
    if (states[s].parent == no_parent) todo.push_back(s);
  while (!todo.empty()) {
    const std::size_t next = todo.back();
    todo.pop_back();
    order.push_back(next);
    // The last on the stack comes next: the child with the lowest key.
    const std::size_t first_child = todo.size();
    for (std::size_t s = 0; s < states.size(); ++s)
      if (states[s].parent == next) todo.push_back(s);
    std::sort(todo.begin() + static_cast<std::ptrdiff_t>(first_child), todo.end(),
              [&](std::size_t a, std::size_t b) { return states[a].key > states[b].key; });
  }
  std::vector<std::size_t> place(states.size(), no_parent);
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  std::vector<TreeState> sorted;
  for (const std::size_t s : order) {
    sorted.push_back(states[s]);
    if (states[s].parent != no_parent) sorted.back().parent = place[states[s].parent];
  }
  states = std::move(sorted);
}

void encode(const TreeGenes& tree, Genes& genes) {
  common::ByteWriter out(genes);
  const bool plain = tree.attributes.empty();
  out.u32(plain ? plain_format : attributes_format);
  out.u32(static_cast<std::uint32_t>(tree.skills.size()));
  out.u32(static_cast<std::uint32_t>(tree.states.size()));
  if (!plain) {
    out.u32(static_cast<std::uint32_t>(tree.attributes.size()));
    out.u32(static_cast<std::uint32_t>(tree.pairs.size()));
  }
  for (const std::uint64_t skill : tree.skills) out.u64(skill);
  for (const std::uint64_t attribute : tree.attributes) out.u64(attribute);
  for (const TreeState& state : tree.states) {
    out.u64(state.key);
    out.u32(state.parent == no_parent ? root_mark : static_cast<std::uint32_t>(state.parent));
    for (const double points : state.points) out.number(points);
    for (const double value : state.attributes) out.number(value);
  }
  for (const AdhesionGene& pair : tree.pairs) {
    out.u64(pair.first);
    out.u64(pair.second);
    out.number(pair.strength);
  }
}

TreeGenes decode(GenesView genes) {
  common::ByteReader in(genes);
  const std::uint32_t format = in.u32();
  require(format == plain_format || format == attributes_format, "their format is another one");
  const bool plain = format == plain_format;
  const std::uint32_t skills = in.u32(), states = in.u32();
  require(skills <= most && states <= most && states > 0, "they have no states, or too many");
  const std::uint32_t attributes = plain ? 0 : in.u32(), pairs = plain ? 0 : in.u32();
  require(attributes <= most && pairs <= most * most, "they have too many attributes or pairs");
  require(plain || attributes > 0, "without attributes their format is another one");
  in.expect_remaining(8ull * (skills + attributes) + 24ull * pairs +
                      states * (12ull + 8ull * (skills + attributes)));
  TreeGenes tree;
  for (std::uint32_t k = 0; k < skills; ++k) tree.skills.push_back(in.u64());
  for (std::uint32_t k = 0; k < attributes; ++k) tree.attributes.push_back(in.u64());
  require_ascending(tree.skills, "skills are out of order");
  require_ascending(tree.attributes, "attributes are out of order");
  for (std::uint32_t s = 0; s < states; ++s) {
    TreeState& state = tree.states.emplace_back();
    state.key = in.u64();
    const std::uint32_t parent = in.u32();
    state.parent = parent == root_mark ? no_parent : parent;
    for (std::uint32_t k = 0; k < skills; ++k) state.points.push_back(in.number());
    for (std::uint32_t k = 0; k < attributes; ++k) state.attributes.push_back(in.number());
  }
  for (std::uint32_t k = 0; k < pairs; ++k) {
    AdhesionGene& pair = tree.pairs.emplace_back();
    pair.first = in.u64();
    pair.second = in.u64();
    pair.strength = in.number();
  }
  check_states(tree);
  check_pairs(tree);
  TreeGenes sorted = tree;
  sorted.sort();
  require(sorted.states == tree.states, "states are out of order");
  return tree;
}

}  // namespace somas::specialization
