#include "plugins/controllers/grn/program.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "somas/sdk/math.hpp"

#include "plugins/controllers/grn/parameters.hpp"

namespace somas::grn {
namespace {

// ---- weights -----------------------------------------------------------------------------------

double affinity_of(Affinity affinity, double tag, double id) {
  const double difference = std::abs(tag - id);
  return affinity == Affinity::proximity ? 1.0 - difference : difference;
}

// W_ij = delta / N (exp(beta (u+_ij - u+max)) - exp(beta (u-_ij - u-max))), so that one product
// gives delta (g_i - h_i).
class Weights {
 public:
  Weights(const Network& network, std::span<const Protein> targets, Affinity affinity)
      : affinity_(affinity), beta_(network.beta) {
    const std::size_t proteins = network.inputs.proteins.size() + network.outputs.proteins.size() +
                                 network.regulators.size();
    scale_ = proteins > 0 ? network.delta / static_cast<double>(proteins) : 0.0;
    // The maxima are over every regulator of the genome, inputs of all states included.
    for (const Protein& target : targets) {
      widen(target, network.inputs.proteins);
      widen(target, network.regulators);
    }
  }

  [[nodiscard]] float operator()(const Protein& target, const Protein& regulator) const {
    const double enhancing = affinity_of(affinity_, target.enhancer, regulator.id);
    const double inhibiting = affinity_of(affinity_, target.inhibitor, regulator.id);
    return static_cast<float>(scale_ * (math::exp(beta_ * (enhancing - most_enhancing_)) -
                                        math::exp(beta_ * (inhibiting - most_inhibiting_))));
  }

 private:
  void widen(const Protein& target, std::span<const Protein> regulators) {
    for (const Protein& regulator : regulators) {
      most_enhancing_ =
          std::max(most_enhancing_, affinity_of(affinity_, target.enhancer, regulator.id));
      most_inhibiting_ =
          std::max(most_inhibiting_, affinity_of(affinity_, target.inhibitor, regulator.id));
    }
  }

  Affinity affinity_;
  double beta_;
  double scale_ = 0;
  double most_enhancing_ = 0;  // affinities are never negative
  double most_inhibiting_ = 0;
};

// The proteins of some ports by channel.
std::vector<Protein> by_channel(const PortProteins& known, std::span<const Port> ports,
                                std::size_t channels) {
  std::vector<Protein> proteins(channels);
  for (const Port& port : ports)
    proteins.at(port.channel) = known.proteins.at(*common::find_key(known.keys, port.key));
  return proteins;
}

std::vector<Port> inputs_of(const Layout& layout, std::size_t state) {
  std::vector<Port> ports;
  for (const Port& port : layout.inputs)
    if (port.state == state) ports.push_back(port);
  return ports;
}

// ---- one step ----------------------------------------------------------------------------------
// Plain loops over lanes that any compiler vectorises. A lane sees the same operations in the same
// order whatever its place, so neither the vector width nor the batch reaches the result.

constexpr std::uint32_t width = 64;  // cells of a block
constexpr std::uint32_t most_sources = most_input_channels + most_regulators;

// sums_k += weights[j][k] * sources[j] for the two targets k and `Count` sources j, in ascending j.
template <std::uint32_t Count>
inline void add_products(const float* weights, const float (*sources)[width], std::uint32_t lanes,
                         float* __restrict sums_0, float* __restrict sums_1) {
  for (std::uint32_t l = 0; l < lanes; ++l) {
    float sum_0 = sums_0[l];
    float sum_1 = sums_1[l];
    for (std::uint32_t j = 0; j < Count; ++j) {
      sum_0 += weights[2 * j] * sources[j][l];
      sum_1 += weights[2 * j + 1] * sources[j][l];
    }
    sums_0[l] = sum_0;
    sums_1[l] = sum_1;
  }
}

inline void add_products(std::uint32_t count, const float* weights, const float (*sources)[width],
                         std::uint32_t lanes, float* sums_0, float* sums_1) {
  switch (count) {
    case 4:
      return add_products<4>(weights, sources, lanes, sums_0, sums_1);
    case 3:
      return add_products<3>(weights, sources, lanes, sums_0, sums_1);
    case 2:
      return add_products<2>(weights, sources, lanes, sums_0, sums_1);
    default:
      return add_products<1>(weights, sources, lanes, sums_0, sums_1);
  }
}

inline float clamped(float c) { return c < 0.0f ? 0.0f : (c > 1.0f ? 1.0f : c); }

template <class T>
inline T* row(const Matrix<T>& matrix, std::uint32_t channel, std::uint32_t first) {
  return matrix.data + channel * matrix.stride + first;
}

// The lanes past `count` become 0.
inline void load(const float* from, std::uint32_t count, std::uint32_t padded, float* to) {
  std::copy_n(from, count, to);
  std::fill(to + count, to + padded, 0.0f);
}

class NetworkProgram final : public Program {
 public:
  NetworkProgram(const Network& network, const Layout& layout, Affinity affinity)
      : inputs_(layout.input_channels),
        outputs_(static_cast<std::uint32_t>(layout.outputs.size())),
        regulators_(static_cast<std::uint32_t>(network.regulators.size())) {
    std::vector<Protein> targets = by_channel(network.outputs, layout.outputs, outputs_);
    targets.insert(targets.end(), network.regulators.begin(), network.regulators.end());
    const Weights weights(network, targets, affinity);
    for (std::size_t state = 0; state < layout.states.size(); ++state) {
      std::vector<Protein> sources = by_channel(network.inputs, inputs_of(layout, state), inputs_);
      sources.insert(sources.end(), network.regulators.begin(), network.regulators.end());
      append_pairs(weights, targets, sources);
    }
  }

  [[nodiscard]] std::uint32_t memory_per_cell() const override { return targets(); }

  void step(const Batch& batch) const override {
    for (std::uint32_t first = 0; first < batch.count; first += width)
      step_block(batch, first, std::min(width, batch.count - first));
  }

 private:
  [[nodiscard]] std::uint32_t targets() const { return outputs_ + regulators_; }
  [[nodiscard]] std::uint32_t sources() const { return inputs_ + regulators_; }
  [[nodiscard]] std::size_t weights_per_state() const {
    return std::size_t{targets() + targets() % 2} * sources();
  }

  // Pairs of targets one after the other, in each the two weights of a source side by side. An odd
  // last target is paired with one that nothing regulates.
  void append_pairs(const Weights& weights, std::span<const Protein> targets,
                    std::span<const Protein> sources) {
    for (std::size_t i = 0; i < targets.size(); i += 2)
      for (const Protein& source : sources) {
        weights_.push_back(weights(targets[i], source));
        weights_.push_back(i + 1 < targets.size() ? weights(targets[i + 1], source) : 0.0f);
      }
  }

  void step_block(const Batch& batch, std::uint32_t first, std::uint32_t count) const {
    // Only regulators are both read and written: this copy is their old generation.
    float old[most_sources][width];
    const std::uint32_t padded = (count + 7) / 8 * 8;
    for (std::uint32_t c = 0; c < inputs_; ++c)
      load(row(batch.in, c, first), count, padded, old[c]);
    for (std::uint32_t r = 0; r < regulators_; ++r)
      load(row(batch.memory, outputs_ + r, first), count, padded, old[inputs_ + r]);

    const float* weights = weights_.data() + batch.state * weights_per_state();
    for (std::uint32_t i = 0; i < targets(); i += 2) {
      const bool both = i + 1 < targets();
      float c[2][width];
      load(row(batch.memory, i, first), count, padded, c[0]);
      load(row(batch.memory, both ? i + 1 : i, first), count, padded, c[1]);
      for (std::uint32_t j = 0; j < sources(); j += 4)
        add_products(std::min(sources() - j, 4u), weights + 2 * j, old + j, padded, c[0], c[1]);
      finish(batch, i, first, count, c[0]);
      if (both) finish(batch, i + 1, first, count, c[1]);
      weights += 2 * sources();
    }
  }

  // Outputs are reported before the clamp.
  void finish(const Batch& batch, std::uint32_t target, std::uint32_t first, std::uint32_t count,
              const float* c) const {
    if (target < outputs_) std::copy_n(c, count, row(batch.out, target, first));
    float* __restrict const memory = row(batch.memory, target, first);
    for (std::uint32_t l = 0; l < count; ++l) memory[l] = clamped(c[l]);
  }

  std::uint32_t inputs_;
  std::uint32_t outputs_;
  std::uint32_t regulators_;
  std::vector<float> weights_;
};

}  // namespace

std::unique_ptr<Program> compile(const Network& network, const Layout& layout, Affinity affinity) {
  if (layout.input_channels > most_input_channels)
    throw std::runtime_error("a gene regulatory network takes at most " +
                             std::to_string(most_input_channels) + " inputs a state, not " +
                             std::to_string(layout.input_channels));
  return std::make_unique<NetworkProgram>(network, layout, affinity);
}

}  // namespace somas::grn
