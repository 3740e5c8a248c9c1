#include "plugins/controllers/ctrnn/variation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace somas::ctrnn {
namespace {

using Places = std::vector<std::optional<std::size_t>>;

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

}  // namespace

Variation::Range Variation::range_of(std::size_t column) const {
  if (column == Network::bias) return {-p_.bias_limit, p_.bias_limit};
  if (column == Network::tau) return {p_.tau_min, p_.tau_max};
  return {-p_.weight_limit, p_.weight_limit};
}

Network Variation::network_for(const Layout& layout, const Network& known, Rng& rng) const {
  Network network;
  network.hidden = static_cast<std::uint32_t>(p_.hidden);
  network.inputs = common::sorted_keys(layout.inputs);
  network.outputs = common::sorted_keys(layout.outputs);
  const Places rows = matching_rows(network, known);
  const Places columns = matching_columns(network, known);
  for (const auto& row : rows)
    for (std::size_t column = 0; column < columns.size(); ++column) {
      const auto [low, high] = range_of(column);
      const bool have = row && columns[column];
      network.genes.push_back(have ? std::clamp(known.neuron(*row)[*columns[column]], low, high)
                                   : rng.uniform(low, high));
    }
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

void Variation::cross(const Layout&, GenesView first, GenesView second, Rng& rng,
                      Genes& child) const {
  Network network = decode(first);
  const Network other = decode(second);
  if (network.hidden != other.hidden || network.inputs != other.inputs ||
      network.outputs != other.outputs)
    throw std::runtime_error("two parents of different shape cannot be crossed");
  for (std::size_t row = 0; row < network.rows(); ++row)
    if (rng.chance(0.5)) std::ranges::copy(other.neuron(row), network.neuron(row).begin());
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
