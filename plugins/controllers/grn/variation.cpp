#include "plugins/controllers/grn/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "plugins/common/inheritance.hpp"

namespace somas::grn {
namespace {

Protein random_protein(Rng& rng) {
  Protein protein;
  protein.id = rng.uniform();
  protein.enhancer = rng.uniform();
  protein.inhibitor = rng.uniform();
  return protein;
}

// ---- conform -----------------------------------------------------------------------------------

// One protein per port in the order of keys: that of `known` where it has a place, else a new one.
PortProteins proteins_for(std::span<const Port> ports, const common::Places& places,
                          const PortProteins& known, Rng& rng) {
  PortProteins result{common::sorted_keys(ports), {}};
  result.proteins.reserve(places.size());
  for (const auto& at : places)
    result.proteins.push_back(at ? known.proteins[*at] : random_protein(rng));
  return result;
}

PortProteins inputs_for(const Layout& layout, const PortProteins& known, Rng& rng) {
  return proteins_for(layout.inputs, common::places_of_inputs(layout, known.keys), known, rng);
}

PortProteins outputs_for(const Layout& layout, const PortProteins& known, Rng& rng) {
  return proteins_for(layout.outputs, common::places_of_outputs(layout, known.keys), known, rng);
}

// ---- mutation ----------------------------------------------------------------------------------

void modify(Network& network, std::uint64_t proteins, Rng& rng) {
  std::uint64_t index = rng.below(proteins);
  for (auto* part : {&network.inputs.proteins, &network.outputs.proteins, &network.regulators}) {
    if (index >= part->size()) {
      index -= part->size();
      continue;
    }
    Protein& protein = (*part)[index];
    const std::array tags{&protein.id, &protein.enhancer, &protein.inhibitor};
    *tags[rng.below(tags.size())] = rng.uniform();
    return;
  }
}

void erase(Network& network, Rng& rng) {
  const std::uint64_t index = rng.below(network.regulators.size());
  network.regulators.erase(network.regulators.begin() + static_cast<std::ptrdiff_t>(index));
}

// One of the three edits with equal probability; one that is impossible is drawn again.
void edit(Network& network, std::uint64_t max_regulators, Rng& rng) {
  const std::uint64_t regulators = network.regulators.size();
  const std::uint64_t proteins =
      network.inputs.proteins.size() + network.outputs.proteins.size() + regulators;
  const bool room = regulators < max_regulators;
  if (proteins == 0 && !room) return;

  for (;;) {
    const std::uint64_t kind = rng.below(3);
    if (kind == 0 && proteins > 0) return modify(network, proteins, rng);
    if (kind == 1 && room) return network.regulators.push_back(random_protein(rng));
    if (kind == 2 && regulators > 0) return erase(network, rng);
  }
}

// ---- crossover and distance --------------------------------------------------------------------

struct Pair {
  double distance;
  std::size_t first;
  std::size_t second;
};

// Greedy one-to-one pairs of regulators under the threshold, nearest first, ties by index. Equal
// ones pair under any threshold, so that a genome is always at distance 0 from itself.
std::vector<Pair> paired(const std::vector<Protein>& first, const std::vector<Protein>& second,
                         double threshold) {
  std::vector<Pair> candidates;
  for (std::size_t i = 0; i < first.size(); ++i)
    for (std::size_t j = 0; j < second.size(); ++j)
      if (const double d = protein_distance(first[i], second[j]); d < threshold || d == 0)
        candidates.push_back({d, i, j});
  std::sort(candidates.begin(), candidates.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.first, a.second) < std::tie(b.distance, b.first, b.second);
  });

  std::vector<bool> first_taken(first.size());
  std::vector<bool> second_taken(second.size());
  std::erase_if(candidates, [&](const Pair& pair) {
    if (first_taken[pair.first] || second_taken[pair.second]) return true;
    first_taken[pair.first] = second_taken[pair.second] = true;
    return false;
  });
  return candidates;
}

// All ports that either parent has, 50/50 where both have them.
PortProteins cross_ports(const PortProteins& first, const PortProteins& second, Rng& rng) {
  PortProteins all;
  all.keys.reserve(std::max(first.keys.size(), second.keys.size()));
  std::ranges::set_union(first.keys, second.keys, std::back_inserter(all.keys));
  all.proteins.reserve(all.keys.size());
  for (const std::uint64_t key : all.keys) {
    const auto here = common::find_key(first.keys, key), there = common::find_key(second.keys, key);
    const bool from_second = here && there ? rng.chance(0.5) : there.has_value();
    all.proteins.push_back(from_second ? second.proteins[*there] : first.proteins[*here]);
  }
  return all;
}

std::vector<Protein> cross_regulators(const std::vector<Protein>& first,
                                      const std::vector<Protein>& second, double threshold,
                                      Rng& rng) {
  const bool swap = rng.chance(0.5);
  const std::vector<Protein>& carrier = swap ? second : first;
  const std::vector<Protein>& other = swap ? first : second;
  std::vector<const Protein*> partner(carrier.size(), nullptr);
  for (const Pair& pair : paired(carrier, other, threshold))
    partner[pair.first] = &other[pair.second];

  std::vector<Protein> child = carrier;
  for (std::size_t i = 0; i < child.size(); ++i)
    if (partner[i] != nullptr && rng.chance(0.5)) child[i] = *partner[i];
  return child;
}

// A sum of differences and of what was compared.
struct Difference {
  double sum = 0;
  std::size_t count = 0;

  void add(double difference) {
    sum += difference;
    ++count;
  }
  void add_rate(double a, double b, double range) {
    add(range > 0 ? std::min(std::abs(a - b) / range, 1.0) : (a == b ? 0.0 : 1.0));
  }
  void add_ports(const PortProteins& a, const PortProteins& b) {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < a.keys.size(); ++i) {
      const auto at = common::find_key(b.keys, a.keys[i]);
      add(at ? protein_distance(a.proteins[i], b.proteins[*at]) : 1.0);
      if (at) ++shared;
    }
    for (std::size_t i = shared; i < b.keys.size(); ++i) add(1.0);
  }
  void add_regulators(const std::vector<Protein>& a, const std::vector<Protein>& b,
                      double threshold) {
    const std::vector<Pair> pairs = paired(a, b, threshold);
    for (const Pair& pair : pairs) add(pair.distance);
    for (std::size_t i = 2 * pairs.size(); i < a.size() + b.size(); ++i) add(1.0);
  }
};

// ---- fit ---------------------------------------------------------------------------------------

void require_rate(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::runtime_error(std::string(name) + " is " + std::to_string(value) +
                           ", which is outside [" + std::to_string(low) + ", " +
                           std::to_string(high) + "]");
}

}  // namespace

double protein_distance(const Protein& a, const Protein& b) {
  return 0.75 * std::abs(a.id - b.id) + 0.125 * std::abs(a.enhancer - b.enhancer) +
         0.125 * std::abs(a.inhibitor - b.inhibitor);
}

void Variation::random(const Layout& layout, Rng& rng, Genes& genes) const {
  Network network;
  network.beta = rng.uniform(p_.beta_min, p_.beta_max);
  network.delta = rng.uniform(p_.delta_min, p_.delta_max);
  network.inputs = inputs_for(layout, {}, rng);
  network.outputs = outputs_for(layout, {}, rng);
  for (std::int64_t i = 0; i < p_.initial_regulators; ++i)
    network.regulators.push_back(random_protein(rng));
  encode(network, genes);
}

void Variation::conform(const Layout& layout, Rng& rng, Genes& genes) const {
  Network network = decode(genes);
  network.beta = std::clamp(network.beta, p_.beta_min, p_.beta_max);
  network.delta = std::clamp(network.delta, p_.delta_min, p_.delta_max);
  network.inputs = inputs_for(layout, network.inputs, rng);
  network.outputs = outputs_for(layout, network.outputs, rng);
  const auto most = static_cast<std::size_t>(p_.max_regulators);
  network.regulators.resize(std::min(network.regulators.size(), most));
  encode(network, genes);
}

void Variation::mutate(const Layout&, Rng& rng, Genes& genes) const {
  Network network = decode(genes);
  const std::uint64_t edits = 1 + rng.below(static_cast<std::uint64_t>(p_.max_edits));
  for (std::uint64_t i = 0; i < edits; ++i)
    edit(network, static_cast<std::uint64_t>(p_.max_regulators), rng);
  if (rng.chance(p_.rate_redraw)) network.beta = rng.uniform(p_.beta_min, p_.beta_max);
  if (rng.chance(p_.rate_redraw)) network.delta = rng.uniform(p_.delta_min, p_.delta_max);
  encode(network, genes);
}

void Variation::cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
                      Genes& child) const {
  const Network a = decode(first);
  const Network b = decode(second);
  Network c;
  c.beta = rng.chance(0.5) ? b.beta : a.beta;
  c.delta = rng.chance(0.5) ? b.delta : a.delta;
  c.inputs = inputs_for(layout, cross_ports(a.inputs, b.inputs, rng), rng);
  c.outputs = outputs_for(layout, cross_ports(a.outputs, b.outputs, rng), rng);
  c.regulators = cross_regulators(a.regulators, b.regulators, p_.crossover_threshold, rng);
  encode(c, child);
}

double Variation::distance(GenesView first, GenesView second) const {
  // Ties between pairs go by index and sums round by order: one order makes it symmetric.
  if (std::lexicographical_compare(second.begin(), second.end(), first.begin(), first.end()))
    std::swap(first, second);
  const Network a = decode(first);
  const Network b = decode(second);
  Difference difference;
  difference.add_rate(a.beta, b.beta, p_.beta_max - p_.beta_min);
  difference.add_rate(a.delta, b.delta, p_.delta_max - p_.delta_min);
  difference.add_ports(a.inputs, b.inputs);
  difference.add_ports(a.outputs, b.outputs);
  difference.add_regulators(a.regulators, b.regulators, p_.crossover_threshold);
  return difference.sum / static_cast<double>(difference.count);
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
  require_rate("beta", network.beta, p_.beta_min, p_.beta_max);
  require_rate("delta", network.delta, p_.delta_min, p_.delta_max);
  common::require_ports(network.inputs.keys, layout.inputs, "input");
  common::require_ports(network.outputs.keys, layout.outputs, "output");
  if (network.regulators.size() > static_cast<std::size_t>(p_.max_regulators))
    throw std::runtime_error("the genes have " + std::to_string(network.regulators.size()) +
                             " regulators where at most " + std::to_string(p_.max_regulators) +
                             " are allowed");
  return network;
}

}  // namespace somas::grn
