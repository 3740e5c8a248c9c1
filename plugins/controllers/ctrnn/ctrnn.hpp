// A continuous-time recurrent neural network (Beer 1995) on the ports that the paper's gene
// regulatory network uses: what a controller of another kind looks like.
#pragma once

#include <memory>

#include "somas/sdk/controller.hpp"

#include "plugins/controllers/ctrnn/parameters.hpp"
#include "plugins/controllers/ctrnn/variation.hpp"

namespace somas::ctrnn {

class Ctrnn final : public Controller {
 public:
  static constexpr About about{"ctrnn", "Continuous-time recurrent neural network"};
  using Parameters = ctrnn::Parameters;

  /// Throws ParameterError when tau_min exceeds tau_max or there are too many hidden neurons.
  explicit Ctrnn(const Parameters& parameters);

  [[nodiscard]] const Heritable& heritable() const override { return variation_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes,
                                                 const Layout& layout) const override;

 private:
  Variation variation_;
};

}  // namespace somas::ctrnn
