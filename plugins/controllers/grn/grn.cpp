#include "plugins/controllers/grn/grn.hpp"

#include <string>

namespace somas::grn {
namespace {

Affinity affinity_named(const std::string& name) {
  if (name == "proximity") return Affinity::proximity;
  if (name == "distance") return Affinity::distance;
  throw ParameterError("affinity", "must be proximity or distance, not \"" + name + "\"");
}

const Parameters& checked(const Parameters& p) {
  if (p.beta_min > p.beta_max) throw ParameterError("beta_min", "must not exceed beta_max");
  if (p.delta_min > p.delta_max) throw ParameterError("delta_min", "must not exceed delta_max");
  if (p.initial_regulators > p.max_regulators)
    throw ParameterError("initial_regulators", "must not exceed max_regulators");
  if (p.max_regulators > most_regulators)
    throw ParameterError("max_regulators", "must not exceed " + std::to_string(most_regulators));
  return p;
}

}  // namespace

Grn::Grn(const Parameters& parameters)
    : affinity_(affinity_named(parameters.affinity)), variation_(checked(parameters)) {}

std::unique_ptr<Program> Grn::express(GenesView genes, const Layout& layout) const {
  return compile(variation_.fitting(layout, genes), layout, affinity_);
}

}  // namespace somas::grn
