/// @file
/// Specialization trees: which states a cell can take, and what each state is good at.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/heritable.hpp"
#include "somas/sdk/world.hpp"

namespace somas {

/// A skill as trees see it: declared by the model or by an environment.
struct SkillInfo {
  std::string_view name;  ///< "capacity", "resistance.red"
  SkillSpec spec;         ///< its range, its default, its cost
};

/// One state (model, section 5).
struct StateSpec {
  std::string_view name;            ///< unique within the tree
  std::uint64_t key = 0;            ///< stable; 0: derived from the name
  std::uint16_t parent = no_state;  ///< index of an earlier state; no_state for the first alone
  double mass = 1;                  ///< > 0
  double radius = 1;                ///< > 0, in units of length
  double stiffness = 10;            ///< of the collision spring
  double adhesion = 3;              ///< strength of the adhesion spring
  double adhesion_range = 1.2;      ///< activation distance / (r1 + r2), >= 1
  std::span<const double> skills;   ///< a value per SkillInfo, in that order

  /// Force with which a cell crawls along the gradient of a morphogen of its organism: up when
  /// positive, down when negative. Alone it approaches the speed motility / drag.
  double motility = 0;
  std::uint32_t motility_signal = 0;  ///< which morphogen, below TreeSink::morphogens()

  /// Strength of the adhesion spring to the cells of each earlier state, by its index. NaN, or
  /// beyond the end: the mean of both states' adhesion.
  std::span<const double> adhesion_with{};

  /// Least outputs, in [0, 1]: an action whose output, clamped to [0, 1], is below is not chosen.
  double quiescence_threshold = 0;
  double division_threshold = 0;        ///< the same for dividing
  double specialization_threshold = 0;  ///< out of this state, into any other
  double apoptosis_threshold = 0;       ///< the same for dying
};

/// Takes the states in an order in which parents come before children; copies what it is given.
class TreeSink : public Extensible {
 public:
  /// Throws for a state that cannot be; let it pass.
  virtual void add(const StateSpec& state) = 0;
  /// How many morphogens the world has. A sink that is no world's knows no limit.
  [[nodiscard]] virtual std::uint32_t morphogens() const { return no_id; }
};

/// A plugin class has `about`, `Parameters` and a constructor from them. Life: constructor ->
/// declare, once -> grow: a fixed tree while loading, and again for the record of a life; one that
/// evolves for every genome, from several threads at once.
class Specialization : public Extensible {
 public:
  /// Once, before anything else: what skills there are. The views are valid during the call.
  virtual void declare(std::span<const SkillInfo>) {}
  /// The part that evolves; null for a fixed tree. Owned by this instance.
  [[nodiscard]] virtual const Heritable* heritable() const { return nullptr; }
  /// Emits into `tree` what the genes encode (empty for a fixed tree). `skills` lists what may be
  /// set, in the order of StateSpec::skills. All are valid during the call. Throws ParameterError
  /// for a tree that cannot be.
  virtual void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const = 0;
};

}  // namespace somas
