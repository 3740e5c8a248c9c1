// The genome of a gene regulatory network and its two representations, bytes and JSON.
#pragma once

#include <vector>

#include "somas/sdk/heritable.hpp"

#include "plugins/common/keys.hpp"

namespace somas::grn {

/// Three tags in [0, 1] (docs/model.md section 6).
struct Protein {
  double id = 0;
  double enhancer = 0;
  double inhibitor = 0;

  bool operator==(const Protein&) const = default;
};

/// The proteins of the input ports or of the output ports: proteins[i] is that of keys[i].
struct PortProteins {
  common::Keys keys;  ///< ascending
  std::vector<Protein> proteins;

  bool operator==(const PortProteins&) const = default;
};

/// A decoded genome.
struct Network {
  double beta = 0;
  double delta = 0;
  PortProteins inputs;
  PortProteins outputs;
  std::vector<Protein> regulators;

  bool operator==(const Network&) const = default;
};

/// Canonical bytes: the letters "GRN1"; the numbers of inputs, outputs and regulators (32 bits
/// each); beta, delta; (key, id, enhancer, inhibitor) of each input, then of each output; (id,
/// enhancer, inhibitor) of each regulator. Integers and doubles are little-endian.
void encode(const Network& network, Genes& genes);

/// The inverse. Throws std::runtime_error on genes of another length than their counts say, keys
/// that do not ascend, tags outside [0, 1] and rates that are not finite.
[[nodiscard]] Network decode(GenesView genes);

void write_json(const Network& network, JsonWriter& out);

/// The inverse. Throws as `decode` does.
[[nodiscard]] Network read_json(const JsonReader& in);

}  // namespace somas::grn
