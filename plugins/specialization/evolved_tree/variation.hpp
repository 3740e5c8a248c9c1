// Variation of trees: what mutation and crossover make of the genes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "somas/sdk/specialization.hpp"

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
  explicit TreeVariation(const EvolvedTreeParameters& parameters) : p_(parameters) {}

  /// The skills that evolve are those with a price. Throws ParameterError when the budget does not
  /// even pay their minima.
  void declare(std::span<const SkillInfo> skills);
  [[nodiscard]] std::span<const EvolvingSkill> skills() const { return skills_; }

  /// One state whose budget is spread evenly.
  void random(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Points of skills that both know stay; new skills begin at their minimum. States too many or
  /// too deep are removed, the last first.
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// One of: moving points between two skills of a state; a new state below another, with its
  /// points but for one large move; a new state between another and its children; removing a state.
  void mutate(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// The first parent's tree; the points of each state that both have come from either. States that
  /// only the second has are grafted below a state that both have, each as likely as not.
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override;
  /// Share of the budget that is spent otherwise, averaged over all states of both; a state that
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
  void move(std::vector<double>& points, double most, Rng& rng) const;
  void shift(TreeGenes& tree, Rng& rng) const;
  void add(TreeGenes& tree, Rng& rng) const;
  void split(TreeGenes& tree, Rng& rng) const;
  void remove(TreeGenes& tree, Rng& rng) const;
  void graft(TreeGenes& tree, const TreeGenes& donor, Rng& rng) const;
  [[nodiscard]] bool fits(const TreeGenes& tree) const;
  [[nodiscard]] std::vector<std::size_t> open_parents(const TreeGenes& tree) const;
  [[nodiscard]] std::vector<std::size_t> divisible(const TreeGenes& tree) const;

  EvolvedTreeParameters p_;
  std::vector<EvolvingSkill> skills_;  ///< by ascending key
};

}  // namespace somas::specialization
