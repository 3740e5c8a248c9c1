// A linear controller: every output is a weighted sum of the inputs of the cell's state.
#pragma once

#include <somas/sdk/plugin.hpp>

#include "genes.hpp"

/// Expressed genes: by (state, output), the bias and then a weight for each input channel.
class LinearProgram final : public somas::Program {
 public:
  LinearProgram(const Weights& weights, const somas::Layout& layout);

  std::uint32_t memory_per_cell() const override { return 0; }
  void step(const somas::Batch& batch) const override;

 private:
  std::uint32_t inputs_, outputs_;
  std::vector<float> weights_;
};

class MyPlugin final : public somas::Controller {
 public:
  static constexpr somas::About about{"my_plugin", "Outputs are weighted sums of the inputs"};

  /// The initialisers are the defaults. The host checks the experiment against this list.
  struct Parameters {
    double mutation_step = 0.3;

    void describe(somas::Describe& d) {
      d("mutation_step", mutation_step, "Standard deviation of a mutated weight's change",
        {.minimum = 0, .maximum = 10});
    }
  };

  explicit MyPlugin(const Parameters& parameters) : heritable_(parameters.mutation_step) {}

  const somas::Heritable& heritable() const override { return heritable_; }
  std::unique_ptr<somas::Program> express(somas::GenesView genes,
                                          const somas::Layout& layout) const override {
    heritable_.check(layout, genes);
    return std::make_unique<LinearProgram>(decode(genes), layout);
  }

 private:
  Linear heritable_;
};
