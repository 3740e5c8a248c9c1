#include "plugins/controllers/ctrnn/ctrnn.hpp"

#include <string>

#include "plugins/controllers/ctrnn/program.hpp"

namespace somas::ctrnn {
namespace {

const Parameters& checked(const Parameters& p) {
  if (p.tau_min < 1) throw ParameterError("tau_min", "must be 1 at least");
  if (p.tau_min > p.tau_max) throw ParameterError("tau_min", "must not exceed tau_max");
  if (p.hidden < 0 || p.hidden > most_hidden)
    throw ParameterError("hidden", "must be 0 to " + std::to_string(most_hidden));
  return p;
}

}  // namespace

Ctrnn::Ctrnn(const Parameters& parameters) : variation_(checked(parameters)) {}

std::unique_ptr<Program> Ctrnn::express(GenesView genes, const Layout& layout) const {
  return compile(variation_.fitting(layout, genes), layout);
}

}  // namespace somas::ctrnn
