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

/// A state: its name for life, where it hangs, and its points by evolving skill.
struct TreeState {
  std::uint64_t key = 0;
  std::size_t parent = no_parent;  ///< an earlier state; no_parent for the first alone
  std::vector<double> points;

  friend bool operator==(const TreeState&, const TreeState&) = default;
};

/// The genes of a tree. States stand in preorder, children by ascending key, so that equal trees
/// are equal bytes.
struct TreeGenes {
  std::vector<std::uint64_t> skills;  ///< stable_key of the names, ascending
  std::vector<TreeState> states;

  [[nodiscard]] std::optional<std::size_t> find(std::uint64_t key) const;
  /// Levels from the root down to a state, both counted.
  [[nodiscard]] std::size_t depth(std::size_t state) const;
  [[nodiscard]] std::size_t depth() const;
  /// Appends a state below `parent`; returns its index.
  std::size_t add(std::uint64_t key, std::size_t parent, std::vector<double> points);
  /// Its children go to its parent. Precondition: not the root.
  void remove(std::size_t state);
  /// Restores the order after `add` and `remove`, and after parents have changed.
  void sort();
};

void encode(const TreeGenes& tree, Genes& genes);
/// Throws std::runtime_error, saying why, for bytes that are no tree.
[[nodiscard]] TreeGenes decode(GenesView genes);

}  // namespace somas::specialization
