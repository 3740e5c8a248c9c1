// How recurrent networks are drawn, mutated, crossed and compared.
#pragma once

#include "somas/sdk/heritable.hpp"

#include "plugins/controllers/ctrnn/network.hpp"
#include "plugins/controllers/ctrnn/parameters.hpp"

namespace somas::ctrnn {

class Variation final : public Heritable {
 public:
  explicit Variation(const Parameters& parameters) : p_(parameters) {}

  /// Every gene uniform in its range.
  void random(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Hidden neurons keep their number: the first ones stay when the parameter `hidden` has changed.
  /// Weights from the inputs of a new state begin as those of the state above it. Genes outside
  /// their range are clamped.
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Adds normal deviates to a random subset of the genes, at least one, clamped to their ranges.
  void mutate(const Layout& layout, Rng& rng, Genes& genes) const override;
  /// Every neuron that both parents have comes from either 50/50, with its incoming weights;
  /// weights that this parent has no inputs for come from the other.
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override;
  /// Mean difference of the genes relative to their ranges, in [0, 1]; a gene that one of the two
  /// lacks counts 1.
  [[nodiscard]] double distance(GenesView first, GenesView second) const override;
  void to_json(GenesView genes, JsonWriter& out) const override;
  void from_json(const JsonReader& in, Genes& genes) const override;
  void check(const Layout& layout, GenesView genes) const override;

  /// The decoded genes; throws as `check` does.
  [[nodiscard]] Network fitting(const Layout& layout, GenesView genes) const;

 private:
  struct Range {
    double low;
    double high;
  };
  [[nodiscard]] Range range_of(std::size_t column) const;
  /// A network of the layout's ports, each gene that of `known` where it has one, else drawn.
  [[nodiscard]] Network network_for(const Layout& layout, const Network& known, Rng& rng) const;
  /// The layout's ports, no genes yet.
  [[nodiscard]] Network without_genes(const Layout& layout) const;
  /// The known gene, clamped to its range; drawn if there is none.
  [[nodiscard]] double gene_from(const double* known, std::size_t column, Rng& rng) const;
  void change(double& gene, std::size_t column, Rng& rng) const;

  Parameters p_;
};

}  // namespace somas::ctrnn
