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
// Cells are lanes, and a lane sees the same operations in the same order whatever its place:
// neither the vector width nor the batch reaches the result.

constexpr std::uint32_t width = 64;  // cells of a block
constexpr std::uint32_t most_sources = most_input_channels + most_regulators;

// A tile of sums stays in registers: so many targets, and two vectors of cells.
constexpr std::uint32_t tile_targets = 4;
using Lanes = float __attribute__((vector_size(32), aligned(alignof(float)), may_alias));
constexpr std::uint32_t vector_cells = sizeof(Lanes) / sizeof(float);
constexpr std::uint32_t tile_cells = 2 * vector_cells;

inline const Lanes& lanes_at(const float& first) { return reinterpret_cast<const Lanes&>(first); }
inline Lanes& lanes_at(float& first) { return reinterpret_cast<Lanes&>(first); }
// By reference: how a vector so wide is returned differs between instruction sets.
inline void clamp(const Lanes& c, Lanes& clamped) {
  const Lanes zero{}, one = zero + 1.0f;
  clamped = c < zero ? zero : (c > one ? one : c);
}

// What a tile reads and writes, row by row `stride` apart, from its first cell on.
struct TileRows {
  float* memory;
  std::size_t memory_stride;
  float* out;
  std::size_t out_stride;
};

// c_k += weights[j][k] * sources[j] for the first `Present` targets of a tile and all sources, in
// ascending j. The first `outputs` of them are reported, before the clamp to [0, 1].
template <std::uint32_t Present>
inline void step_tile(const float* weights, const float (*sources)[width], std::uint32_t count,
                      std::uint32_t l, std::uint32_t outputs, const TileRows& rows) {
  Lanes low[Present], high[Present];
  for (std::uint32_t k = 0; k < Present; ++k) {
    low[k] = lanes_at(rows.memory[k * rows.memory_stride]);
    high[k] = lanes_at(rows.memory[k * rows.memory_stride + vector_cells]);
  }
  for (std::uint32_t j = 0; j < count; ++j) {
    const Lanes source_low = lanes_at(sources[j][l]);
    const Lanes source_high = lanes_at(sources[j][l + vector_cells]);
    for (std::uint32_t k = 0; k < Present; ++k) {
      const float weight = weights[tile_targets * j + k];
      low[k] += weight * source_low;
      high[k] += weight * source_high;
    }
  }
  for (std::uint32_t k = 0; k < Present; ++k) {
    if (k < outputs) {
      lanes_at(rows.out[k * rows.out_stride]) = low[k];
      lanes_at(rows.out[k * rows.out_stride + vector_cells]) = high[k];
    }
    clamp(low[k], lanes_at(rows.memory[k * rows.memory_stride]));
    clamp(high[k], lanes_at(rows.memory[k * rows.memory_stride + vector_cells]));
  }
}

inline void step_tile(std::uint32_t present, const float* weights, const float (*sources)[width],
                      std::uint32_t count, std::uint32_t l, std::uint32_t outputs,
                      const TileRows& rows) {
  switch (present) {
    case 1:
      return step_tile<1>(weights, sources, count, l, outputs, rows);
    case 2:
      return step_tile<2>(weights, sources, count, l, outputs, rows);
    case 3:
      return step_tile<3>(weights, sources, count, l, outputs, rows);
    default:
      return step_tile<4>(weights, sources, count, l, outputs, rows);
  }
}

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
      append_tiles(weights, targets, sources);
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
  [[nodiscard]] std::uint32_t tiles() const {
    return (targets() + tile_targets - 1) / tile_targets;
  }
  [[nodiscard]] std::size_t weights_per_state() const {
    return std::size_t{tiles()} * tile_targets * sources();
  }

  // Tile after tile, in each the weights of a source side by side. The last one is filled up with
  // targets that nothing regulates.
  void append_tiles(const Weights& weights, std::span<const Protein> targets,
                    std::span<const Protein> sources) {
    for (std::size_t i = 0; i < targets.size(); i += tile_targets)
      for (const Protein& source : sources)
        for (std::size_t k = i; k < i + tile_targets; ++k)
          weights_.push_back(k < targets.size() ? weights(targets[k], source) : 0.0f);
  }

  void step_block(const Batch& batch, std::uint32_t first, std::uint32_t count) const {
    // Only regulators are both read and written: this copy is their old generation.
    float old[most_sources][width];
    const std::uint32_t padded = (count + tile_cells - 1) / tile_cells * tile_cells;
    for (std::uint32_t c = 0; c < inputs_; ++c)
      load(row(batch.in, c, first), count, padded, old[c]);
    for (std::uint32_t r = 0; r < regulators_; ++r)
      load(row(batch.memory, outputs_ + r, first), count, padded, old[inputs_ + r]);

    const float* weights = weights_.data() + batch.state * weights_per_state();
    for (std::uint32_t i = 0; i < targets(); i += tile_targets) {
      for (std::uint32_t l = 0; l < padded; l += tile_cells)
        step_cells(batch, weights, old, i, first, l, std::min(count - l, tile_cells));
      weights += tile_targets * sources();
    }
  }

  // Of the targets from `i` on, for `count` cells from `first` + `l` on.
  void step_cells(const Batch& batch, const float* weights, const float (*old)[width],
                  std::uint32_t i, std::uint32_t first, std::uint32_t l,
                  std::uint32_t count) const {
    const std::uint32_t present = std::min(targets() - i, tile_targets);
    const std::uint32_t outputs = std::min(outputs_ - std::min(i, outputs_), present);
    float* memory = row(batch.memory, i, first + l);
    float* out = outputs > 0 ? row(batch.out, i, first + l) : nullptr;
    if (count == tile_cells)
      return step_tile(present, weights, old, sources(), l, outputs,
                       {memory, batch.memory.stride, out, batch.out.stride});
    // What lies beyond the batch is others': work on a copy.
    float c[tile_targets][tile_cells], reported[tile_targets][tile_cells];
    for (std::uint32_t k = 0; k < present; ++k)
      load(memory + k * batch.memory.stride, count, tile_cells, c[k]);
    step_tile(present, weights, old, sources(), l, outputs,
              {c[0], tile_cells, reported[0], tile_cells});
    for (std::uint32_t k = 0; k < present; ++k)
      std::copy_n(c[k], count, memory + k * batch.memory.stride);
    for (std::uint32_t k = 0; k < outputs; ++k)
      std::copy_n(reported[k], count, out + k * batch.out.stride);
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
