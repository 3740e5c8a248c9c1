// Variation of trees: what mutation and crossover make of the genes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "somas/sdk/specialization.hpp"

#include "plugins/specialization/evolved_tree/attributes.hpp"
#include "plugins/specialization/evolved_tree/genes.hpp"
#include "plugins/specialization/evolved_tree/parameters.hpp"

namespace somas::specialization {

/// A skill that evolves.
struct EvolvingSkill {
  std::string name;
  std::uint64_t key = 0;
  SkillSpec spec;
};

class TreeVariation final : public Heritable {
 public:
  /// Throws ParameterError as evolving_attributes does.
  explicit TreeVariation(const EvolvedTreeParameters& parameters)
      : p_(parameters), attributes_(evolving_attributes(parameters)) {}

  /// The skills that evolve are those with a price. Throws ParameterError when the budget does not
  /// even pay their minima.
  void declare(std::span<const SkillInfo> skills);
  [[nodiscard]] std::span<const EvolvingSkill> skills() const { return skills_; }
  [[nodiscard]] std::span<const EvolvingAttribute> attributes() const { return attributes_; }
  /// What points in an evolving skill (its place in `skills`) buy, within the skill's range. With
  /// B the budget less the least points of all skills, and s what is spent on this one above its
  /// least points: least + B (s / B)^returns / price.
  [[nodiscard]] double bought(std::size_t skill, double points) const;

  /// One state whose budget is spread evenly, its attributes as in a tree without evolving ones.
  void random(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Points and attributes that both know stay, within their ranges; new skills begin at their
  /// minimum, new attributes at their start. States too many or too deep are removed, the last
  /// first.
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// One of: moving points between two skills of a state; a new state below another, a copy of it
  /// but for one large move of points; a new state between another and its children; removing a
  /// state; spending a state's points anew; drawing one attribute of a state or the adhesion of a
  /// pair anew.
  void mutate(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// The first parent's tree; of each state that both have, the points and each attribute come from
  /// either. States that only the second has are grafted below a state that both have, each as
  /// likely as not. Adhesions of pairs come from either parent that has both states.
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override;
  /// Share of the budget that is spent otherwise (with attributes: its mean with their differences
  /// relative to their ranges), averaged over all states and pairs of both; a state or pair that
  /// one of the two lacks counts 1.
  [[nodiscard]] double distance(GenesView first, GenesView second) const override;
  void to_json(GenesView genes, JsonWriter& out) const override;
  void from_json(const JsonReader& in, Genes& genes) const override;
  void check(const Layout& layout, GenesView genes) const override;

  /// The decoded genes; throws as `check` does.
  [[nodiscard]] TreeGenes fitting(GenesView genes) const;

 private:
  [[nodiscard]] double spent(const std::vector<double>& points) const;
  void settle(std::vector<double>& points) const;
  [[nodiscard]] std::vector<double> conformed_attributes(const TreeGenes& known,
                                                         const TreeState& state) const;
  [[nodiscard]] std::vector<AdhesionGene> conformed_pairs(const TreeGenes& known) const;
  [[nodiscard]] bool attributes_fit(const TreeGenes& tree) const;
  [[nodiscard]] double state_distance(const TreeState& a, const TreeState& b) const;
  void move(std::vector<double>& points, double most, Rng& rng) const;
  void shift(TreeGenes& tree, Rng& rng) const;
  void redraw(TreeGenes& tree, Rng& rng) const;
  void redraw_attribute(TreeGenes& tree, Rng& rng) const;
  std::size_t add_copy(TreeGenes& tree, std::size_t parent, Rng& rng) const;
  void add(TreeGenes& tree, Rng& rng) const;
  void split(TreeGenes& tree, Rng& rng) const;
  void remove(TreeGenes& tree, Rng& rng) const;
  void graft(TreeGenes& tree, const TreeGenes& donor, Rng& rng) const;
  [[nodiscard]] bool fits(const TreeGenes& tree) const;
  [[nodiscard]] std::vector<std::size_t> open_parents(const TreeGenes& tree) const;
  [[nodiscard]] std::vector<std::size_t> divisible(const TreeGenes& tree) const;

  EvolvedTreeParameters p_;
  std::vector<EvolvingSkill> skills_;  ///< by ascending key
  double least_ = 0;                   ///< what the least points of all skills cost
  std::vector<EvolvingAttribute> attributes_;
};

}  // namespace somas::specialization
