// A heritable part that is easy to reason on: a chromosome is a list of bytes, one per output port
// of its layout (one alone without ports), and mutations count upwards.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "somas/sdk/heritable.hpp"

namespace somas::test {

class ToyHeritable final : public Heritable {
 public:
  static std::size_t length_for(const Layout& layout) {
    return layout.outputs.empty() ? 1 : layout.outputs.size();
  }

  void random(const Layout& layout, Rng& rng, Genes& genes) const override {
    genes.resize(length_for(layout));
    for (std::uint8_t& gene : genes) gene = static_cast<std::uint8_t>(rng.below(100));
  }
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override {
    const std::size_t length = length_for(layout);
    if (genes.size() > length) genes.resize(length);
    while (genes.size() < length) genes.push_back(static_cast<std::uint8_t>(rng.below(100)));
  }
  void mutate(const Layout&, Rng& rng, Genes& genes) const override {
    ++genes[rng.below(genes.size())];
  }
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override {
    const GenesView longer = first.size() > second.size() ? first : second;
    child.assign(longer.begin(), longer.end());
    for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i)
      child[i] = rng.chance(0.5) ? second[i] : first[i];
    conform(layout, rng, child);
  }
  [[nodiscard]] double distance(GenesView first, GenesView second) const override {
    double sum = 0;
    for (std::size_t i = 0; i < first.size(); ++i) sum += first[i] != second[i] ? 1 : 0;
    return sum;
  }
  void to_json(GenesView genes, JsonWriter& out) const override {
    out.open_list("bytes");
    for (const std::uint8_t gene : genes) out.integer("", gene);
    out.close();
  }
  void from_json(const JsonReader& in, Genes& genes) const override {
    const JsonReader& bytes = in.member("bytes");
    genes.clear();
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::int64_t value = bytes.item(i).integer();
      if (value < 0 || value > 255) throw std::runtime_error("a byte is 0 to 255");
      genes.push_back(static_cast<std::uint8_t>(value));
    }
  }
  void check(const Layout& layout, GenesView genes) const override {
    if (genes.size() != length_for(layout)) throw std::runtime_error("wrong number of genes");
  }
};

}  // namespace somas::test
