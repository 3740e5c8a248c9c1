#include "plugins/controllers/ctrnn/variation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "plugins/common/inheritance.hpp"

namespace somas::ctrnn {
namespace {

using common::Places;

// For every row of `to`, the row of `from` that holds the same neuron.
Places matching_rows(const Network& to, const Network& from) {
  Places places;
  for (std::size_t i = 0; i < to.hidden; ++i)
    places.push_back(i < from.hidden ? std::optional(i) : std::nullopt);
  for (const std::uint64_t key : to.outputs) {
    const auto at = common::find_key(from.outputs, key);
    places.push_back(at ? std::optional(from.hidden + *at) : std::nullopt);
  }
  return places;
}

// For every column of `to`, the column of `from` that holds the same gene.
Places matching_columns(const Network& to, const Network& from) {
  Places places{Network::bias, Network::tau};
  for (std::size_t i = 0; i < to.hidden; ++i)
    places.push_back(i < from.hidden ? std::optional(Network::first_weight + i) : std::nullopt);
  for (const std::uint64_t key : to.inputs) {
    const auto at = common::find_key(from.inputs, key);
    places.push_back(at ? std::optional(Network::first_weight + from.hidden + *at) : std::nullopt);
  }
  return places;
}

// As matching_columns; inputs of a state that `from` lacks are those of the state above it.
Places inherited_columns(const Layout& layout, const Network& to, const Network& from) {
  Places places = matching_columns(to, from);
  const Places inputs = common::places_of_inputs(layout, from.inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i])
      places[Network::first_weight + to.hidden + i] =
          Network::first_weight + from.hidden + *inputs[i];
  return places;
}

// A parent seen from its child: which of the child's genes it has.
class Parent {
 public:
  Parent(const Layout& layout, const Network& child, const Network& parent)
      : parent_(parent),
        rows_(matching_rows(child, parent)),
        own_(matching_columns(child, parent)),
        inherited_(inherited_columns(layout, child, parent)) {}

  [[nodiscard]] bool has(std::size_t row) const { return rows_[row].has_value(); }
  /// Its own gene, or null.
  [[nodiscard]] const double* own(std::size_t row, std::size_t column) const {
    return find(row, own_[column]);
  }
  /// Its own gene, or that of the state above, or null.
  [[nodiscard]] const double* inherited(std::size_t row, std::size_t column) const {
    return find(row, inherited_[column]);
  }

 private:
  [[nodiscard]] const double* find(std::size_t row, std::optional<std::size_t> column) const {
    return rows_[row] && column ? &parent_.neuron(*rows_[row])[*column] : nullptr;
  }

  const Network& parent_;
  Places rows_, own_, inherited_;
};

// What the child has from a neuron of its parents, of which the first comes first; null: nothing.
const double* handed_down(const Parent& first, const Parent& second, std::size_t row,
                          std::size_t column) {
  const double* gene = first.own(row, column);
  if (gene == nullptr) gene = second.own(row, column);
  if (gene == nullptr) gene = first.inherited(row, column);
  return gene != nullptr ? gene : second.inherited(row, column);
}

}  // namespace

Variation::Range Variation::range_of(std::size_t column) const {
  if (column == Network::bias) return {-p_.bias_limit, p_.bias_limit};
  if (column == Network::tau) return {p_.tau_min, p_.tau_max};
  return {-p_.weight_limit, p_.weight_limit};
}

Network Variation::without_genes(const Layout& layout) const {
  Network network;
  network.hidden = static_cast<std::uint32_t>(p_.hidden);
  network.inputs = common::sorted_keys(layout.inputs);
  network.outputs = common::sorted_keys(layout.outputs);
  return network;
}

double Variation::gene_from(const double* known, std::size_t column, Rng& rng) const {
  const auto [low, high] = range_of(column);
  return known != nullptr ? std::clamp(*known, low, high) : rng.uniform(low, high);
}

Network Variation::network_for(const Layout& layout, const Network& known, Rng& rng) const {
  Network network = without_genes(layout);
  const Parent parent(layout, network, known);
  for (std::size_t row = 0; row < network.rows(); ++row)
    for (std::size_t column = 0; column < network.columns(); ++column)
      network.genes.push_back(gene_from(parent.inherited(row, column), column, rng));
  return network;
}

void Variation::random(const Layout& layout, Rng& rng, Genes& genes) const {
  encode(network_for(layout, {}, rng), genes);
}

void Variation::conform(const Layout& layout, Rng& rng, Genes& genes) const {
  encode(network_for(layout, decode(genes), rng), genes);
}

void Variation::change(double& gene, std::size_t column, Rng& rng) const {
  const auto [low, high] = range_of(column);
  gene = std::clamp(gene + p_.mutation_sigma * (high - low) * rng.normal(), low, high);
}

void Variation::mutate(const Layout&, Rng& rng, Genes& genes) const {
  Network network = decode(genes);
  if (network.genes.empty()) return;
  bool changed = false;
  for (std::size_t i = 0; i < network.genes.size(); ++i) {
    if (!rng.chance(p_.mutation_rate)) continue;
    change(network.genes[i], i % network.columns(), rng);
    changed = true;
  }
  if (!changed) {
    const auto i = static_cast<std::size_t>(rng.below(network.genes.size()));
    change(network.genes[i], i % network.columns(), rng);
  }
  encode(network, genes);
}

void Variation::cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
                      Genes& child) const {
  const Network a = decode(first), b = decode(second);
  Network network = without_genes(layout);
  const Parent mother(layout, network, a), father(layout, network, b);
  for (std::size_t row = 0; row < network.rows(); ++row) {
    const bool from_father = mother.has(row) && father.has(row) && rng.chance(0.5);
    const Parent& giver = from_father ? father : mother;
    const Parent& other = from_father ? mother : father;
    for (std::size_t column = 0; column < network.columns(); ++column)
      network.genes.push_back(gene_from(handed_down(giver, other, row, column), column, rng));
  }
  encode(network, child);
}

double Variation::distance(GenesView first, GenesView second) const {
  const Network a = decode(first);
  const Network b = decode(second);
  const Places rows = matching_rows(a, b);
  const Places columns = matching_columns(a, b);
  double sum = 0;
  std::size_t shared = 0;
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (std::size_t column = 0; column < columns.size(); ++column) {
      if (!rows[row] || !columns[column]) continue;
      const auto [low, high] = range_of(column);
      const double difference =
          std::abs(a.neuron(row)[column] - b.neuron(*rows[row])[*columns[column]]);
      if (difference > 0) sum += high > low ? std::min(difference / (high - low), 1.0) : 1.0;
      ++shared;
    }
  const std::size_t all = a.genes.size() + b.genes.size() - shared;
  return all > 0 ? (sum + static_cast<double>(all - shared)) / static_cast<double>(all) : 0.0;
}

void Variation::to_json(GenesView genes, JsonWriter& out) const { write_json(decode(genes), out); }

void Variation::from_json(const JsonReader& in, Genes& genes) const {
  encode(read_json(in), genes);
}

void Variation::check(const Layout& layout, GenesView genes) const {
  static_cast<void>(fitting(layout, genes));
}

Network Variation::fitting(const Layout& layout, GenesView genes) const {
  Network network = decode(genes);
  if (network.hidden != static_cast<std::uint32_t>(p_.hidden))
    throw std::runtime_error("the genes have " + std::to_string(network.hidden) +
                             " hidden neurons where " + std::to_string(p_.hidden) + " are set");
  common::require_ports(network.inputs, layout.inputs, "input");
  common::require_ports(network.outputs, layout.outputs, "output");
  for (std::size_t i = 0; i < network.genes.size(); ++i) {
    const auto [low, high] = range_of(i % network.columns());
    if (network.genes[i] < low || network.genes[i] > high)
      throw std::runtime_error("a weight, bias or tau is " + std::to_string(network.genes[i]) +
                               ", which is outside [" + std::to_string(low) + ", " +
                               std::to_string(high) + "]");
  }
  return network;
}

}  // namespace somas::ctrnn
