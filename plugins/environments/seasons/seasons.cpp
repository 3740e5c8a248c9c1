#include "plugins/environments/seasons/seasons.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "somas/sdk/math.hpp"

namespace somas::environments {

namespace {

std::string path(std::size_t cycle, const char* key) {
  return "cycles[" + std::to_string(cycle) + "]." + key;
}

std::string name_of(const Seasons::Cycle& cycle) {
  return "'" + cycle.environment + "." + cycle.parameter + "'";
}

/// A cycle that does nothing, or too much, was meant otherwise.
void check_values(const Seasons::Cycle& cycle, std::size_t index, const VariableSpec& spec) {
  if (spec.value == 0)
    throw ParameterError(path(index, "parameter"),
                         name_of(cycle) + " is 0 in this experiment, and 0 times anything is 0");
  const double least = cycle.shape == "ramp" ? 0 : -1;
  const double ends[] = {spec.value * (1 + cycle.amplitude * least),
                         spec.value * (1 + cycle.amplitude)};
  if (std::min(ends[0], ends[1]) < spec.minimum || std::max(ends[0], ends[1]) > spec.maximum)
    throw ParameterError(path(index, "amplitude"),
                         "with this amplitude " + name_of(cycle) + " would leave its range");
}

}  // namespace

double Seasons::Cycle::wave(std::uint64_t t) const {
  const auto start = static_cast<std::uint64_t>(from);
  const auto length = static_cast<std::uint64_t>(period);
  if (t < start) return 0;
  if (shape == "ramp")
    return std::min(1.0, static_cast<double>(t - start) / static_cast<double>(length));
  double u = static_cast<double>((t - start) % length) / static_cast<double>(length) + phase;
  u -= std::floor(u);
  if (shape == "square") return u < 0.5 ? 1 : -1;
  if (shape == "sine") return math::sincos(math::two_pi * u).sin;
  return u < 0.25 ? 4 * u : u < 0.75 ? 2 - 4 * u : 4 * u - 4;
}

Seasons::Seasons(const Parameters& parameters) : cycles_(parameters.cycles) {
  if (cycles_.empty()) throw ParameterError("cycles", "seasons need at least one cycle");
}

void Seasons::declare(Declare& declare) { declare.acts_in(Phase::parameters); }

void Seasons::connect(Connections& connections) {
  variables_.clear();
  for (std::size_t i = 0; i < cycles_.size(); ++i) {
    const Cycle& cycle = cycles_[i];
    try {
      variables_.push_back(connections.vary(cycle.environment, cycle.parameter));
    } catch (const std::runtime_error& error) {
      throw ParameterError(path(i, "parameter"), error.what());
    }
    check_values(cycle, i, variables_.back().spec);
  }
}

void Seasons::act(Phase, World& world) const {
  for (std::size_t i = 0; i < cycles_.size(); ++i) {
    const double factor = 1 + cycles_[i].amplitude * cycles_[i].wave(world.step());
    // Rounding must not carry it over an end of its range.
    const VariableSpec& spec = variables_[i].spec;
    world.set_parameter(variables_[i].id,
                        std::clamp(spec.value * factor, spec.minimum, spec.maximum));
  }
}

}  // namespace somas::environments
