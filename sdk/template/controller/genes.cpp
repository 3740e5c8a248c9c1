#include "genes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace {

using somas::Genes;
using somas::GenesView;
using somas::Layout;
using somas::Rng;

constexpr std::size_t gene_size = 8 + 8 + 4;
constexpr float limit = 4;  // of a weight, up and down

void put(Genes& genes, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) genes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

std::uint64_t get(const std::uint8_t* from, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= std::uint64_t{from[i]} << 8 * i;
  return value;
}

bool is_weight(float weight) { return weight >= -limit && weight <= limit; }

// In ascending order, so that chance is drawn in an order that hangs on the keys alone.
std::vector<Pair> pairs_of(const Layout& layout) {
  std::vector<Pair> pairs;
  for (const somas::Port& output : layout.outputs) {
    pairs.emplace_back(output.key, 0);
    for (const somas::Port& input : layout.inputs) pairs.emplace_back(output.key, input.key);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

float drawn(Rng& rng) { return static_cast<float>(rng.uniform(-1, 1)); }

// Null where there is none.
const float* find(const Weights& weights, const Pair& pair) {
  const auto found = weights.find(pair);
  return found == weights.end() ? nullptr : &found->second;
}

}  // namespace

Weights decode(GenesView genes) {
  if (genes.size() % gene_size != 0) throw std::runtime_error("the genes are cut off");
  Weights weights;
  for (std::size_t at = 0; at < genes.size(); at += gene_size) {
    const std::uint8_t* gene = genes.data() + at;
    const Pair pair{get(gene, 8), get(gene + 8, 8)};
    const float weight = std::bit_cast<float>(static_cast<std::uint32_t>(get(gene + 16, 4)));
    if (!is_weight(weight)) throw std::runtime_error("a weight is out of its range");
    if (!weights.empty() && weights.rbegin()->first >= pair)
      throw std::runtime_error("the weights are not in order");
    weights.emplace_hint(weights.end(), pair, weight);
  }
  return weights;
}

void encode(const Weights& weights, Genes& genes) {
  genes.clear();
  for (const auto& [pair, weight] : weights) {
    put(genes, pair.first, 8);
    put(genes, pair.second, 8);
    put(genes, std::bit_cast<std::uint32_t>(weight), 4);
  }
}

void Linear::random(const Layout& layout, Rng& rng, Genes& genes) const {
  Weights weights;
  for (const Pair& pair : pairs_of(layout)) weights[pair] = drawn(rng);
  encode(weights, genes);
}

void Linear::conform(const Layout& layout, Rng& rng, Genes& genes) const {
  const Weights old = decode(genes);
  Weights weights;
  for (const Pair& pair : pairs_of(layout)) {
    const float* kept = find(old, pair);
    weights[pair] = kept != nullptr ? *kept : drawn(rng);
  }
  encode(weights, genes);
}

void Linear::mutate(const Layout&, Rng& rng, Genes& genes) const {
  Weights weights = decode(genes);
  if (weights.empty()) return;
  const auto chosen =
      std::next(weights.begin(), static_cast<std::ptrdiff_t>(rng.below(weights.size())));
  const float moved = chosen->second + static_cast<float>(step_ * rng.normal());
  chosen->second = std::clamp(moved, -limit, limit);
  encode(weights, genes);
}

void Linear::cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
                   Genes& child) const {
  const Weights ours = decode(first), theirs = decode(second);
  Weights weights;
  for (const Pair& pair : pairs_of(layout)) {
    // What both have comes from either, what one has from that one, what neither has is drawn.
    const float* a = find(ours, pair);
    const float* b = find(theirs, pair);
    if (a != nullptr && b != nullptr)
      weights[pair] = rng.chance(0.5) ? *a : *b;
    else if (a != nullptr || b != nullptr)
      weights[pair] = a != nullptr ? *a : *b;
    else
      weights[pair] = drawn(rng);
  }
  encode(weights, child);
}

double Linear::distance(GenesView first, GenesView second) const {
  // The mean difference of weights; one that a genome lacks counts as 0.
  const Weights a = decode(first), b = decode(second);
  Weights all = a;
  all.insert(b.begin(), b.end());
  double sum = 0;
  for (const auto& [pair, unused] : all) {
    const float* x = find(a, pair);
    const float* y = find(b, pair);
    sum += std::abs((x != nullptr ? double{*x} : 0) - (y != nullptr ? double{*y} : 0));
  }
  return all.empty() ? 0 : sum / static_cast<double>(all.size());
}

void Linear::to_json(GenesView genes, somas::JsonWriter& out) const {
  out.open_list("weights");
  for (const auto& [pair, weight] : decode(genes)) {
    out.open_object("");
    out.key64("output", pair.first);
    out.key64("input", pair.second);
    out.number("weight", weight);
    out.close();
  }
  out.close();
}

void Linear::from_json(const somas::JsonReader& in, Genes& genes) const {
  Weights weights;
  const somas::JsonReader& list = in.member("weights");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const somas::JsonReader& entry = list.item(i);
    const auto weight = static_cast<float>(entry.member("weight").number());
    if (!is_weight(weight)) throw std::runtime_error("a weight is out of its range");
    weights[{entry.member("output").key64(), entry.member("input").key64()}] = weight;
  }
  encode(weights, genes);
}

void Linear::check(const Layout& layout, GenesView genes) const {
  const std::vector<Pair> pairs = pairs_of(layout);
  const Weights weights = decode(genes);
  const bool fit =
      std::equal(pairs.begin(), pairs.end(), weights.begin(), weights.end(),
                 [](const Pair& pair, const auto& entry) { return pair == entry.first; });
  if (!fit) throw std::runtime_error("the genes belong to other ports");
}
