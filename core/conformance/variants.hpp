// Parameters as somebody gives them, and at the ends of what they may be.
#pragma once

#include <string>
#include <vector>

#include "core/plugins/library.hpp"

namespace somas::conformance {

/// What the assignments "ID.parameter=value" make of the defaults of a class; those that name other
/// classes of `library` are left out. Throws experiment::InputError, also for what names no class.
[[nodiscard]] plugins::ParameterValue given_parameters(const plugins::Library& library,
                                                       const ClassInfo& info,
                                                       const std::vector<std::string>& assignments);

/// Parameters of which one is at an end of its range, or another of its words.
struct Variant {
  std::string text;  ///< "rate = 0"
  plugins::ParameterValue values;
};

/// `values` with each number and integer at its finite limits (just inside an open one), each
/// boolean and choice at every word, each list at its least length, one change at a time. What
/// breaks a relation is left out: the host refuses it.
[[nodiscard]] std::vector<Variant> variants_of(std::span<const ParameterInfo> fields,
                                               const plugins::ParameterValue& values);

/// Paths of the parameters without a doc: "patches.side", "states[].name".
[[nodiscard]] std::vector<std::string> undocumented_in(std::span<const ParameterInfo> fields);

}  // namespace somas::conformance
