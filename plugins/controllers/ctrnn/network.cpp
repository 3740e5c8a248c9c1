#include "plugins/controllers/ctrnn/network.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "plugins/common/bytes.hpp"
#include "plugins/controllers/ctrnn/parameters.hpp"

namespace somas::ctrnn {
namespace {

constexpr std::uint32_t signature = 0x314E4E52;  // "RNN1"
constexpr std::uint32_t most_ports = 0xFFFF;     // keeps the product of counts within 64 bits

void require_well_formed(const Network& network) {
  common::require_ascending(network.inputs, "input");
  common::require_ascending(network.outputs, "output");
  for (const double gene : network.genes)
    if (!std::isfinite(gene)) throw std::runtime_error("a weight, bias or tau is not finite");
  for (std::size_t row = 0; row < network.rows(); ++row)
    if (network.neuron(row)[Network::tau] < 1)
      throw std::runtime_error("the tau of a neuron is below 1");
}

void write_numbers(std::string_view key, std::span<const double> numbers, JsonWriter& out) {
  out.open_list(key);
  for (const double number : numbers) out.number("", number);
  out.close();
}

void write_neuron(std::span<const double> neuron, std::uint32_t hidden, JsonWriter& out) {
  out.number("bias", neuron[Network::bias]);
  out.number("tau", neuron[Network::tau]);
  write_numbers("from_hidden", neuron.subspan(Network::first_weight, hidden), out);
  write_numbers("from_inputs", neuron.subspan(Network::first_weight + hidden), out);
}

void read_numbers(const JsonReader& in, std::size_t count, const char* what,
                  std::vector<double>& genes) {
  if (in.size() != count)
    throw std::runtime_error("a neuron has " + std::to_string(in.size()) + " weights " + what +
                             " where the network has " + std::to_string(count));
  for (std::size_t i = 0; i < count; ++i) genes.push_back(in.item(i).number());
}

void read_neuron(const JsonReader& in, Network& network) {
  network.genes.push_back(in.member("bias").number());
  network.genes.push_back(in.member("tau").number());
  read_numbers(in.member("from_hidden"), network.hidden, "from_hidden", network.genes);
  read_numbers(in.member("from_inputs"), network.inputs.size(), "from_inputs", network.genes);
}

}  // namespace

void encode(const Network& network, Genes& genes) {
  common::ByteWriter out(genes);
  out.u32(signature);
  out.u32(network.hidden);
  out.u32(static_cast<std::uint32_t>(network.inputs.size()));
  out.u32(static_cast<std::uint32_t>(network.outputs.size()));
  for (const std::uint64_t key : network.inputs) out.u64(key);
  for (const std::uint64_t key : network.outputs) out.u64(key);
  for (const double gene : network.genes) out.number(gene);
}

Network decode(GenesView bytes) {
  common::ByteReader in(bytes);
  if (in.u32() != signature)
    throw std::runtime_error("the genes are not those of a recurrent neural network");
  Network network;
  network.hidden = in.u32();
  const std::uint32_t inputs = in.u32();
  const std::uint32_t outputs = in.u32();
  if (network.hidden > most_hidden || inputs > most_ports || outputs > most_ports)
    throw std::runtime_error("the genes count more neurons or ports than any network has");
  const std::uint64_t rows = std::uint64_t{network.hidden} + outputs;
  const std::uint64_t columns = Network::first_weight + std::uint64_t{network.hidden} + inputs;
  in.expect_remaining(8 * (std::uint64_t{inputs} + outputs + rows * columns));

  for (std::uint32_t i = 0; i < inputs; ++i) network.inputs.push_back(in.u64());
  for (std::uint32_t i = 0; i < outputs; ++i) network.outputs.push_back(in.u64());
  for (std::uint64_t i = 0; i < rows * columns; ++i) network.genes.push_back(in.number());
  require_well_formed(network);
  return network;
}

void write_json(const Network& network, JsonWriter& out) {
  out.open_list("inputs");
  for (const std::uint64_t key : network.inputs) out.key64("", key);
  out.close();
  out.open_list("hidden");
  for (std::size_t row = 0; row < network.hidden; ++row) {
    out.open_object("");
    write_neuron(network.neuron(row), network.hidden, out);
    out.close();
  }
  out.close();
  out.open_list("outputs");
  for (std::size_t i = 0; i < network.outputs.size(); ++i) {
    out.open_object("");
    out.key64("key", network.outputs[i]);
    write_neuron(network.neuron(network.hidden + i), network.hidden, out);
    out.close();
  }
  out.close();
}

Network read_json(const JsonReader& in) {
  const JsonReader& inputs = in.member("inputs");
  const JsonReader& hidden = in.member("hidden");
  const JsonReader& outputs = in.member("outputs");
  if (hidden.size() > most_hidden)
    throw std::runtime_error("a network has at most " + std::to_string(most_hidden) +
                             " hidden neurons");
  Network network;
  network.hidden = static_cast<std::uint32_t>(hidden.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) network.inputs.push_back(inputs.item(i).key64());
  for (std::size_t i = 0; i < hidden.size(); ++i) read_neuron(hidden.item(i), network);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    network.outputs.push_back(outputs.item(i).member("key").key64());
    read_neuron(outputs.item(i), network);
  }
  require_well_formed(network);
  return network;
}

}  // namespace somas::ctrnn
