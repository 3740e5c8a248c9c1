// The genome of a continuous-time recurrent neural network: a matrix of genes, a row per neuron.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/heritable.hpp"

#include "plugins/common/keys.hpp"

namespace somas::ctrnn {

/// Rows: the hidden neurons, then the output neurons in ascending order of keys. Columns: bias,
/// time constant, weights from the hidden neurons, weights from the inputs in ascending order of
/// keys (those of all states).
struct Network {
  std::uint32_t hidden = 0;
  common::Keys inputs;        ///< ascending
  common::Keys outputs;       ///< ascending
  std::vector<double> genes;  ///< row by row

  static constexpr std::size_t bias = 0;
  static constexpr std::size_t tau = 1;
  static constexpr std::size_t first_weight = 2;

  [[nodiscard]] std::size_t rows() const { return hidden + outputs.size(); }
  [[nodiscard]] std::size_t columns() const { return first_weight + hidden + inputs.size(); }
  [[nodiscard]] std::span<double> neuron(std::size_t row) {
    return std::span(genes).subspan(row * columns(), columns());
  }
  [[nodiscard]] std::span<const double> neuron(std::size_t row) const {
    return std::span(genes).subspan(row * columns(), columns());
  }

  bool operator==(const Network&) const = default;
};

/// Canonical bytes: the letters "RNN1"; the numbers of hidden neurons, inputs and outputs (32 bits
/// each); the input keys; the output keys; the genes. Integers and doubles are little-endian.
void encode(const Network& network, Genes& genes);

/// The inverse. Throws std::runtime_error on genes of another length than their counts say, keys
/// that do not ascend, numbers that are not finite and time constants below 1.
[[nodiscard]] Network decode(GenesView genes);

void write_json(const Network& network, JsonWriter& out);

/// The inverse. Throws as `decode` does.
[[nodiscard]] Network read_json(const JsonReader& in);

}  // namespace somas::ctrnn
