// Evolved tree: a specialization tree that is part of the genome.
//
// It begins as one state whose budget of points is spread evenly over all skills that have a price.
// Mutation moves points between skills, adds, splits and removes states and, where the experiment
// says so, draws crawling, adhesion and thresholds of states anew. A state keeps its key for
// life, so that the controller keeps what it learned for a state when others come and go.
#pragma once

#include <span>
#include <vector>

#include "somas/sdk/parameters.hpp"
#include "somas/sdk/specialization.hpp"

#include "plugins/specialization/evolved_tree/variation.hpp"

namespace somas::specialization {

class EvolvedTree final : public Specialization {
 public:
  static constexpr About about{"evolved_tree",
                               "A specialization tree that evolves, under a budget"};
  using Parameters = EvolvedTreeParameters;

  explicit EvolvedTree(const Parameters& parameters)
      : parameters_(parameters), variation_(parameters) {}
  void declare(std::span<const SkillInfo> skills) override { variation_.declare(skills); }
  [[nodiscard]] const Heritable* heritable() const override { return &variation_; }
  /// Skills without a price have their fallback. States are called "root" and "s" with their key.
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override;

 private:
  [[nodiscard]] std::vector<double> values_of(const TreeState& state,
                                              std::span<const SkillInfo> skills) const;

  Parameters parameters_;
  TreeVariation variation_;
};

}  // namespace somas::specialization
