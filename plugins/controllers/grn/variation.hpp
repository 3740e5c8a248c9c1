// How gene regulatory networks are drawn, mutated, crossed and compared (docs/model.md section 7).
#pragma once

#include "somas/sdk/heritable.hpp"

#include "plugins/controllers/grn/network.hpp"
#include "plugins/controllers/grn/parameters.hpp"

namespace somas::grn {

/// 0.75 |id| + 0.125 |enhancer| + 0.125 |inhibitor| of the differences, in [0, 1].
[[nodiscard]] double protein_distance(const Protein& a, const Protein& b);

class Variation final : public Heritable {
 public:
  explicit Variation(const Parameters& parameters) : p_(parameters) {}

  void random(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Inputs of a new state begin as those of the state above it; other new ports are drawn. Rates
  /// outside their range are clamped, and regulators beyond the most allowed are dropped from the
  /// end, so that genomes of an experiment with other parameters fit as well.
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// 1 to max_edits edits, then beta and delta redrawn with probability rate_redraw each.
  void mutate(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Beta, delta and one by one the proteins of ports that both parents have are inherited 50/50;
  /// those of ports that one of them has come from that one. One parent, drawn at random,
  /// gives its regulators in their order, each that is paired replaced 50/50 by its partner.
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override;
  /// Mean over all proteins and the two rates, in [0, 1]: paired proteins (by key, regulators as in
  /// `cross`) by protein_distance, unpaired ones 1, rates relative to their range.
  [[nodiscard]] double distance(GenesView first, GenesView second) const override;
  void to_json(GenesView genes, JsonWriter& out) const override;
  void from_json(const JsonReader& in, Genes& genes) const override;
  void check(const Layout& layout, GenesView genes) const override;

  /// The decoded genes; throws as `check` does.
  [[nodiscard]] Network fitting(const Layout& layout, GenesView genes) const;

 private:
  Parameters p_;
};

}  // namespace somas::grn
