#include "plugins/controllers/ctrnn/program.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "somas/sdk/math.hpp"

#include "plugins/controllers/ctrnn/parameters.hpp"

namespace somas::ctrnn {
namespace {

constexpr std::uint32_t block = 64;  // cells computed at once

struct Neuron {
  float bias;
  float rate;  // 1 / tau
};

class NetworkProgram final : public Program {
 public:
  NetworkProgram(const Network& network, const Layout& layout)
      : hidden_(network.hidden), inputs_(layout.input_channels), states_(layout.states.size()) {
    for (std::size_t row = 0; row < network.hidden; ++row)
      append(network, network.neuron(row), layout);
    // Output neurons stand in ascending order of keys in the genes, by channel here.
    std::vector<std::size_t> rows(layout.outputs.size());
    for (const Port& port : layout.outputs)
      rows.at(port.channel) = hidden_ + common::find_key(network.outputs, port.key).value();
    for (const std::size_t row : rows) append(network, network.neuron(row), layout);
  }

  [[nodiscard]] std::uint32_t memory_per_cell() const override {
    return static_cast<std::uint32_t>(neurons_.size());
  }

  void step(const Batch& batch) const override {
    for (std::uint32_t first = 0; first < batch.count; first += block)
      step_block(batch, first, std::min(block, batch.count - first));
  }

 private:
  void append(const Network& network, std::span<const double> genes, const Layout& layout) {
    neurons_.push_back(
        {static_cast<float>(genes[Network::bias]), static_cast<float>(1.0 / genes[Network::tau])});
    for (std::size_t j = 0; j < network.hidden; ++j)
      hidden_weights_.push_back(static_cast<float>(genes[Network::first_weight + j]));
    std::vector<float> by_channel(states_ * inputs_);
    for (const Port& port : layout.inputs) {
      const std::size_t at = common::find_key(network.inputs, port.key).value();
      by_channel.at(port.state * inputs_ + port.channel) =
          static_cast<float>(genes[Network::first_weight + network.hidden + at]);
    }
    input_weights_.insert(input_weights_.end(), by_channel.begin(), by_channel.end());
  }

  void step_block(const Batch& batch, std::uint32_t first, std::uint32_t count) const {
    // All neurons see the hidden activations of the step before.
    float activation[most_hidden][block];
    for (std::uint32_t j = 0; j < hidden_; ++j) {
      const float* y = batch.memory.data + j * batch.memory.stride + first;
      for (std::uint32_t l = 0; l < count; ++l)
        activation[j][l] = math::logistic(y[l] + neurons_[j].bias);
    }

    for (std::uint32_t i = 0; i < neurons_.size(); ++i) {
      float drive[block] = {};
      const float* weights = input_weights_.data() + (i * states_ + batch.state) * inputs_;
      for (std::uint32_t k = 0; k < inputs_; ++k)
        add_scaled(weights[k], batch.in.data + k * batch.in.stride + first, count, drive);
      for (std::uint32_t j = 0; j < hidden_; ++j)
        add_scaled(hidden_weights_[i * hidden_ + j], activation[j], count, drive);

      float* y = batch.memory.data + i * batch.memory.stride + first;
      for (std::uint32_t l = 0; l < count; ++l) y[l] += neurons_[i].rate * (drive[l] - y[l]);
      if (i < hidden_) continue;
      float* out = batch.out.data + (i - hidden_) * batch.out.stride + first;
      for (std::uint32_t l = 0; l < count; ++l) out[l] = math::logistic(y[l] + neurons_[i].bias);
    }
  }

  static void add_scaled(float weight, const float* __restrict from, std::uint32_t count,
                         float* __restrict sums) {
    for (std::uint32_t l = 0; l < count; ++l) sums[l] += weight * from[l];
  }

  std::uint32_t hidden_;
  std::uint32_t inputs_;
  std::size_t states_;
  std::vector<Neuron> neurons_;        // hidden, then outputs by channel
  std::vector<float> hidden_weights_;  // [neuron][hidden]
  std::vector<float> input_weights_;   // [neuron][state][channel]
};

}  // namespace

std::unique_ptr<Program> compile(const Network& network, const Layout& layout) {
  return std::make_unique<NetworkProgram>(network, layout);
}

}  // namespace somas::ctrnn
