// A tree of states as genes: a value that can be varied, and its canonical bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "somas/sdk/heritable.hpp"
#include "somas/sdk/world.hpp"

namespace somas::specialization {

inline constexpr std::size_t no_parent = static_cast<std::size_t>(-1);

/// A state: its name for life, where it hangs, its points by evolving skill, and its evolving
/// attributes.
struct TreeState {
  std::uint64_t key = 0;
  std::size_t parent = no_parent;  ///< an earlier state; no_parent for the first alone
  std::vector<double> points;
  std::vector<double> attributes{};

  friend bool operator==(const TreeState&, const TreeState&) = default;
};

/// How strongly cells of two states stick to each other; pairs not listed: the mean of both states.
struct AdhesionGene {
  std::uint64_t first = 0, second = 0;  ///< keys of states, first < second
  double strength = 0;

  [[nodiscard]] bool is_of(std::uint64_t a, std::uint64_t b) const {
    return (first == a && second == b) || (first == b && second == a);
  }
  friend bool operator==(const AdhesionGene&, const AdhesionGene&) = default;
};

/// The genes of a tree. States stand in preorder, children by ascending key, and pairs by ascending
/// keys, so that equal trees are equal bytes.
struct TreeGenes {
  std::vector<std::uint64_t> skills;        ///< stable_key of the names, ascending
  std::vector<std::uint64_t> attributes{};  ///< likewise
  std::vector<TreeState> states;
  std::vector<AdhesionGene> pairs{};

  [[nodiscard]] std::optional<std::size_t> find(std::uint64_t key) const;
  /// Levels from the root down to a state, both counted.
  [[nodiscard]] std::size_t depth(std::size_t state) const;
  [[nodiscard]] std::size_t depth() const;
  /// Appends a state; returns its index.
  std::size_t add(TreeState state);
  /// Its children go to its parent, its pairs are gone. Precondition: not the root.
  void remove(std::size_t state);
  /// What the pair says, if anything.
  [[nodiscard]] std::optional<double> adhesion(std::uint64_t a, std::uint64_t b) const;
  /// No strength: the mean again. Precondition: a != b.
  void set_adhesion(std::uint64_t a, std::uint64_t b, std::optional<double> strength);
  /// Restores the order after `add` and `remove`, and after parents have changed.
  void sort();
};

/// Integers and doubles are little-endian. A tree without attributes: 1; the numbers of skills and
/// states (32 bits each); the skills' keys; (key, parent, points) of each state. With attributes:
/// 2; the numbers of skills, states, attributes and pairs; the keys of skills and attributes; (key,
/// parent, points, attributes) of each state; (key, key, strength) of each pair.
void encode(const TreeGenes& tree, Genes& genes);
/// Throws std::runtime_error, saying why, for bytes that are no tree.
[[nodiscard]] TreeGenes decode(GenesView genes);

}  // namespace somas::specialization
