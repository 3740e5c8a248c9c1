#include <algorithm>

#include "my_plugin.hpp"

LinearProgram::LinearProgram(const Weights& weights, const somas::Layout& layout)
    : inputs_(layout.input_channels),
      outputs_(static_cast<std::uint32_t>(layout.outputs.size())),
      weights_(layout.states.size() * outputs_ * (inputs_ + 1)) {
  for (const somas::Port& output : layout.outputs) {
    for (std::size_t state = 0; state < layout.states.size(); ++state)
      weights_[(state * outputs_ + output.channel) * (inputs_ + 1)] = weights.at({output.key, 0});
    for (const somas::Port& input : layout.inputs)
      weights_[(input.state * outputs_ + output.channel) * (inputs_ + 1) + 1 + input.channel] =
          weights.at({output.key, input.key});
  }
}

void LinearProgram::step(const somas::Batch& batch) const {
  // All cells of one state: the inner loops run over cells, so that they vectorise.
  for (std::uint32_t o = 0; o < outputs_; ++o) {
    const float* weight = weights_.data() + (batch.state * outputs_ + o) * (inputs_ + 1);
    const std::span<float> out = batch.out.channel(o);
    std::fill(out.begin(), out.end(), weight[0]);
    for (std::uint32_t i = 0; i < inputs_; ++i) {
      const std::span<const float> in = batch.in.channel(i);
      for (std::size_t cell = 0; cell < out.size(); ++cell) out[cell] += weight[1 + i] * in[cell];
    }
  }
}
