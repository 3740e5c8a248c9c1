#include "core/report/anatomy.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "somas/sdk/rng.hpp"

#include "core/plugins/suggest.hpp"

namespace somas::report {
namespace {

/// Distance of every cell from the centroid of its cluster.
std::vector<double> distances(const model::WorldState& world, const Clusters& clusters) {
  const model::CellStore& cells = world.cells;
  std::vector<double> x(clusters.count), y(clusters.count), members(clusters.count);
  for (const std::uint32_t i : cells.order) {
    x[clusters.label[i]] += cells.x[i];
    y[clusters.label[i]] += cells.y[i];
    members[clusters.label[i]] += 1;
  }
  std::vector<double> distance(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    const std::uint32_t c = clusters.label[i];
    const double dx = cells.x[i] - x[c] / members[c], dy = cells.y[i] - y[c] / members[c];
    distance[i] = std::sqrt(dx * dx + dy * dy);
  }
  return distance;
}

/// The states, shuffled among the cells of each cluster.
std::vector<std::uint16_t> shuffle_states(const model::CellStore& cells, const Clusters& clusters,
                                          Rng rng) {
  std::vector<std::vector<std::uint32_t>> members(clusters.count);
  for (const std::uint32_t i : cells.order) members[clusters.label[i]].push_back(i);
  std::vector<std::uint16_t> states = cells.state;
  for (const std::vector<std::uint32_t>& cluster : members)
    for (std::size_t left = cluster.size(); left > 1; --left)
      std::swap(states[cluster[left - 1]], states[cluster[rng.below(left)]]);
  return states;
}

std::string formatted(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

Clusters clusters_of(const model::WorldState& world) {
  constexpr std::uint32_t none = 0xFFFFFFFFu;
  Clusters clusters;
  clusters.label.assign(world.cells.size(), none);
  std::vector<std::uint32_t> open;
  for (const std::uint32_t first : world.cells.order) {
    if (clusters.label[first] != none) continue;
    // Flood from the cluster's first cell.
    clusters.label[first] = clusters.count;
    open.assign(1, first);
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      for (const std::uint32_t j : world.contacts.of(i)) {
        if (clusters.label[j] != none) continue;
        clusters.label[j] = clusters.count;
        open.push_back(j);
      }
    }
    ++clusters.count;
  }
  return clusters;
}

PairCount count_farther(std::span<const double> distance, std::span<const std::uint32_t> cluster,
                        std::span<const std::uint16_t> state, std::uint16_t outer,
                        std::uint16_t inner) {
  // By cluster, then distance: the inner cells met so far are those that lie nearer.
  std::vector<std::uint32_t> order(distance.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return cluster[a] != cluster[b] ? cluster[a] < cluster[b] : distance[a] < distance[b];
  });
  PairCount count;
  for (std::size_t begin = 0; begin < order.size();) {
    double nearer = 0, farther = 0, outers = 0;
    std::size_t end = begin;
    while (end < order.size() && cluster[order[end]] == cluster[order[begin]]) {
      // Cells at the same distance tie.
      double tied_outer = 0, tied_inner = 0;
      const double at = distance[order[end]];
      for (; end < order.size() && cluster[order[end]] == cluster[order[begin]] &&
             distance[order[end]] == at;
           ++end) {
        tied_outer += state[order[end]] == outer ? 1 : 0;
        tied_inner += state[order[end]] == inner ? 1 : 0;
      }
      farther += tied_outer * (nearer + 0.5 * tied_inner);
      nearer += tied_inner;
      outers += tied_outer;
    }
    count.farther += farther;
    count.pairs += outers * nearer;
    begin = end;
  }
  return count;
}

void Anatomy::observe(const model::Simulation& simulation) {
  if (states_.empty()) describe(simulation);
  const model::WorldState& world = simulation.state();
  const model::CellStore& cells = world.cells;
  const model::OrganismState& organism = world.organisms.front();
  const Clusters clusters = clusters_of(world);
  const std::vector<double> distance = distances(world, clusters);

  Step now;
  now.step = world.step - 1;
  now.cells.assign(states_.size(), 0);
  now.distance.assign(states_.size(), 0.0);
  now.clusters = clusters.count;
  std::vector<std::uint32_t> members(clusters.count);
  for (const std::uint32_t i : cells.order) {
    ++now.cells[cells.state[i]];
    now.distance[cells.state[i]] += distance[i];
    now.largest = std::max(now.largest, ++members[clusters.label[i]]);
    now.x += cells.x[i];
    now.y += cells.y[i];
    now.energy += cells.energy[i];
    now.ambrosia += cells.ambrosia[i];
  }
  const double count = std::max(1.0, static_cast<double>(cells.size()));
  now.x /= count;
  now.y /= count;
  for (std::size_t s = 0; s < states_.size(); ++s)
    if (now.cells[s] > 0) now.distance[s] /= now.cells[s];
  now.deaths = organism.deaths;
  divisions_ = organism.outcome.divisions;
  specializations_ = organism.outcome.specializations;
  steps_.push_back(std::move(now));
  compare(world, clusters, distance);
}

void Anatomy::describe(const model::Simulation& simulation) {
  const model::OrganismState& organism = simulation.state().organisms.front();
  const std::vector<model::State>& states = organism.phenotype->tree->states;
  for (const model::State& state : states) states_.push_back(state.name);
  causes_ = simulation.ecosystem().schema().causes;
  const auto count = static_cast<std::uint16_t>(states.size());
  for (std::uint16_t s = 1; s < count; ++s)
    pairs_.push_back({.outer = s, .inner = states[s].parent});
}

void Anatomy::compare(const model::WorldState& world, const Clusters& clusters,
                      std::span<const double> distance) {
  const model::CellStore& cells = world.cells;
  for (PairSum& pair : pairs_) {
    if (steps_.back().cells[pair.outer] < least_outer_cells) continue;
    const PairCount seen =
        count_farther(distance, clusters.label, cells.state, pair.outer, pair.inner);
    if (seen.pairs == 0) continue;
    ++pair.steps;
    pair.observed += seen.farther / seen.pairs;
    for (std::uint32_t k = 0; k < shufflings; ++k) {
      const std::vector<std::uint16_t> states = shuffle_states(
          cells, clusters, Rng(world.seed, k, world.step, stable_key("report.shuffle"), 0));
      const PairCount chance =
          count_farther(distance, clusters.label, states, pair.outer, pair.inner);
      // A shuffle keeps every cluster's numbers, so there are as many pairs.
      pair.shuffled[k] += chance.farther / chance.pairs;
    }
  }
}

std::vector<Segregation> Anatomy::segregation() const {
  std::vector<Segregation> all;
  for (const PairSum& pair : pairs_) {
    Segregation s{.outer = pair.outer, .inner = pair.inner, .steps = pair.steps};
    if (pair.steps > 0) {
      const auto steps = static_cast<double>(pair.steps);
      const auto [low, high] = std::minmax_element(pair.shuffled.begin(), pair.shuffled.end());
      s.observed = pair.observed / steps;
      s.shuffled =
          std::accumulate(pair.shuffled.begin(), pair.shuffled.end(), 0.0) / (steps * shufflings);
      s.shuffled_low = *low / steps;
      s.shuffled_high = *high / steps;
    }
    all.push_back(s);
  }
  return all;
}

std::string Anatomy::to_text() const {
  std::string text;
  for (const Segregation& s : segregation()) {
    const std::string &outer = states_[s.outer], &inner = states_[s.inner];
    if (s.steps == 0) {
      text += "  " + outer + " outside " + inner +
              formatted(": never %u %s cells to compare\n", least_outer_cells, outer.c_str());
      continue;
    }
    text +=
        "  " + outer + " outside " + inner + formatted(": P = %.3f over ", s.observed) +
        plugins::plural(s.steps, "step") +
        formatted("; shuffled %.3f (%.3f to %.3f)\n", s.shuffled, s.shuffled_low, s.shuffled_high);
  }
  if (steps_.empty()) return text;

  double farthest = 0;
  std::uint32_t most_clusters = 0;
  for (const Step& step : steps_) {
    if (step.clusters > 0)
      farthest = std::max(farthest, std::sqrt(step.x * step.x + step.y * step.y));
    most_clusters = std::max(most_clusters, step.clusters);
  }
  text += "  at most " + plugins::plural(most_clusters, "cluster") +
          formatted("; centroid at most %.1f from the centre\n", farthest);
  text += "  " + plugins::plural(divisions_, "division") + ", " +
          plugins::plural(specializations_, "specialization") + "; deaths:";
  for (std::size_t c = 0; c < causes_.size(); ++c)
    text += formatted(" %llu ", static_cast<unsigned long long>(steps_.back().deaths[c])) +
            causes_[c] + (c + 1 < causes_.size() ? "," : "\n");
  return text;
}

std::string Anatomy::to_csv() const {
  std::string text = "step";
  for (const std::string& state : states_) text += ",cells_" + state;
  for (const std::string& state : states_) text += ",distance_" + state;
  text += ",clusters,largest_cluster,centroid_x,centroid_y,energy,ambrosia";
  for (const std::string& cause : causes_) text += ",deaths_" + cause;
  text += "\n";
  for (const Step& step : steps_) {
    text += std::to_string(step.step);
    for (const std::uint32_t cells : step.cells) text += "," + std::to_string(cells);
    for (const double distance : step.distance) text += formatted(",%.6g", distance);
    text += formatted(",%u,%u,%.6g,%.6g,%.6g,%.6g", step.clusters, step.largest, step.x, step.y,
                      step.energy, step.ambrosia);
    for (const std::uint64_t deaths : step.deaths) text += "," + std::to_string(deaths);
    text += "\n";
  }
  return text;
}

}  // namespace somas::report
