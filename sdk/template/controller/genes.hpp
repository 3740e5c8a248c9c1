// What evolves: a weight for every pair of an output and an input, and one for the output alone.
#pragma once

#include <somas/sdk/plugin.hpp>

/// Weights by the keys of (output, input); input 0 is the output's bias. Keys are stable, so that a
/// weight survives when other ports come and go.
using Pair = std::pair<std::uint64_t, std::uint64_t>;
using Weights = std::map<Pair, float>;

/// Genes are canonical: equal weights are equal bytes. Throws for bytes that are no weights.
[[nodiscard]] Weights decode(somas::GenesView genes);
void encode(const Weights& weights, somas::Genes& genes);

/// The laws of each function stand in somas/sdk/heritable.hpp.
class Linear final : public somas::Heritable {
 public:
  explicit Linear(double step) : step_(step) {}

  void random(const somas::Layout& layout, somas::Rng& rng, somas::Genes& genes) const override;
  void conform(const somas::Layout& layout, somas::Rng& rng, somas::Genes& genes) const override;
  void mutate(const somas::Layout& layout, somas::Rng& rng, somas::Genes& genes) const override;
  void cross(const somas::Layout& layout, somas::GenesView first, somas::GenesView second,
             somas::Rng& rng, somas::Genes& child) const override;
  double distance(somas::GenesView first, somas::GenesView second) const override;
  void to_json(somas::GenesView genes, somas::JsonWriter& out) const override;
  void from_json(const somas::JsonReader& in, somas::Genes& genes) const override;
  void check(const somas::Layout& layout, somas::GenesView genes) const override;

 private:
  double step_;  ///< of a mutation
};
