#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "plugins/specialization/evolved_tree/variation.hpp"

namespace somas::specialization {

namespace {

/// Keys, with the names that are known beside them for people.
template <class Known>
void write_keys(const char* what, const std::vector<std::uint64_t>& keys, const Known& known,
                JsonWriter& out) {
  out.open_list(what);
  for (const std::uint64_t key : keys) {
    const auto at = std::ranges::find_if(known, [&](const auto& one) { return one.key == key; });
    out.open_object("");
    out.key64("key", key);
    out.text("name", at == known.end() ? "" : at->name);
    out.close();
  }
  out.close();
}

void write_numbers(const char* what, const std::vector<double>& numbers, JsonWriter& out) {
  out.open_list(what);
  for (const double number : numbers) out.number("", number);
  out.close();
}

std::vector<std::uint64_t> read_keys(const JsonReader& in) {
  std::vector<std::uint64_t> keys;
  for (std::size_t k = 0; k < in.size(); ++k) keys.push_back(in.item(k).member("key").key64());
  return keys;
}

std::vector<double> read_numbers(const JsonReader& in) {
  std::vector<double> numbers;
  for (std::size_t k = 0; k < in.size(); ++k) numbers.push_back(in.item(k).number());
  return numbers;
}

TreeState read_state(const JsonReader& in, const TreeGenes& tree) {
  const std::size_t place = tree.states.size();
  const std::int64_t parent = in.member("parent").integer();
  TreeState state{in.member("key").key64(),
                  parent < 0 ? no_parent : static_cast<std::size_t>(parent),
                  read_numbers(in.member("points"))};
  if (!tree.attributes.empty()) state.attributes = read_numbers(in.member("attributes"));
  if (state.points.size() != tree.skills.size() || parent < -1 || parent >= std::int64_t(place))
    throw std::runtime_error("state " + std::to_string(place) +
                             " needs an earlier parent and points in every skill");
  if (state.attributes.size() != tree.attributes.size())
    throw std::runtime_error("state " + std::to_string(place) +
                             " needs a value of every attribute");
  return state;
}

}  // namespace

void TreeVariation::to_json(GenesView genes, JsonWriter& out) const {
  const TreeGenes tree = decode(genes);
  const bool plain = tree.attributes.empty();
  write_keys("skills", tree.skills, skills_, out);
  if (!plain) write_keys("attributes", tree.attributes, attributes_, out);
  out.open_list("states");
  for (const TreeState& state : tree.states) {
    out.open_object("");
    out.key64("key", state.key);
    out.integer("parent", state.parent == no_parent ? -1 : static_cast<std::int64_t>(state.parent));
    write_numbers("points", state.points, out);
    if (!plain) write_numbers("attributes", state.attributes, out);
    out.close();
  }
  out.close();
  if (plain) return;
  out.open_list("adhesion_pairs");
  for (const AdhesionGene& pair : tree.pairs) {
    out.open_object("");
    out.key64("first", pair.first);
    out.key64("second", pair.second);
    out.number("strength", pair.strength);
    out.close();
  }
  out.close();
}

void TreeVariation::from_json(const JsonReader& in, Genes& genes) const {
  TreeGenes tree;
  tree.skills = read_keys(in.member("skills"));
  if (in.has("attributes")) tree.attributes = read_keys(in.member("attributes"));
  const JsonReader& states = in.member("states");
  for (std::size_t s = 0; s < states.size(); ++s) tree.add(read_state(states.item(s), tree));
  if (!tree.attributes.empty()) {
    const JsonReader& pairs = in.member("adhesion_pairs");
    for (std::size_t k = 0; k < pairs.size(); ++k)
      tree.pairs.push_back({pairs.item(k).member("first").key64(),
                            pairs.item(k).member("second").key64(),
                            pairs.item(k).member("strength").number()});
  }
  encode(tree, genes);
  static_cast<void>(decode(genes));
}

}  // namespace somas::specialization
