#include "plugins/environments/nutrients/nutrients.hpp"

namespace somas::environments {

namespace {

/// A size is given if, and only if, the region has such a size.
void check_size(const char* name, const std::optional<double>& size, const std::string& region,
                bool wanted) {
  if (wanted && !size) throw ParameterError(name, "region '" + region + "' needs '" + name + "'");
  if (!wanted && size) throw ParameterError(name, "region '" + region + "' has no '" + name + "'");
}

Region region_of(const Nutrients::Parameters& p) {
  if (p.region == "square") return {Region::Shape::square, *p.half_side};
  if (p.region == "disc") return {Region::Shape::disc, *p.radius};
  return {};
}

}  // namespace

Nutrients::Nutrients(const Parameters& parameters) : parameters_(parameters) {
  check_size("half_side", parameters.half_side, parameters.region, parameters.region == "square");
  check_size("radius", parameters.radius, parameters.region, parameters.region == "disc");
  if (parameters.initial && *parameters.initial > parameters.patches.capacity)
    throw ParameterError("initial", "'initial' is more than 'capacity'");
}

void Nutrients::declare(Declare& declare) {
  field_.declare(declare, parameters_.patches, region_of(parameters_));
  declare.acts_in(Phase::fields);
  declare.acts_in(Phase::sense);
}

void Nutrients::begin(World& world) const {
  field_.set(world, parameters_.initial.value_or(parameters_.patches.capacity));
}

void Nutrients::act(Phase phase, World& world) const {
  if (phase == Phase::fields) field_.regenerate(world);
  if (phase == Phase::sense) field_.sense(world);
}

}  // namespace somas::environments
