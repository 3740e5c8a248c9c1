// The paper's controller: a gene regulatory network of input, output and regulatory proteins whose
// tags, speed and selectivity evolve (docs/model.md sections 6 and 7).
#pragma once

#include <memory>

#include "somas/sdk/controller.hpp"

#include "plugins/controllers/grn/parameters.hpp"
#include "plugins/controllers/grn/program.hpp"
#include "plugins/controllers/grn/variation.hpp"

namespace somas::grn {

class Grn final : public Controller {
 public:
  static constexpr About about{"grn", "Gene regulatory network with evolving protein tags"};
  using Parameters = grn::Parameters;

  /// Throws ParameterError on limits that contradict each other.
  explicit Grn(const Parameters& parameters);

  [[nodiscard]] const Heritable& heritable() const override { return variation_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes,
                                                 const Layout& layout) const override;

 private:
  Affinity affinity_;
  Variation variation_;
};

}  // namespace somas::grn
