#include "plugins/controllers/grn/network.hpp"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "plugins/common/bytes.hpp"

namespace somas::grn {
namespace {

constexpr std::uint32_t signature = 0x314E5247;  // "GRN1"
constexpr std::uint64_t header_bytes = 4 * 4 + 2 * 8;
constexpr std::uint64_t protein_bytes = 3 * 8;
constexpr std::uint64_t port_protein_bytes = 8 + protein_bytes;

void put(common::ByteWriter& out, const Protein& protein) {
  out.number(protein.id);
  out.number(protein.enhancer);
  out.number(protein.inhibitor);
}

void put(common::ByteWriter& out, const PortProteins& ports) {
  for (std::size_t i = 0; i < ports.keys.size(); ++i) {
    out.u64(ports.keys[i]);
    put(out, ports.proteins[i]);
  }
}

Protein get_protein(common::ByteReader& in) {
  Protein protein;
  protein.id = in.number();
  protein.enhancer = in.number();
  protein.inhibitor = in.number();
  return protein;
}

PortProteins get_ports(common::ByteReader& in, std::uint32_t count) {
  PortProteins ports;
  ports.keys.reserve(count);
  ports.proteins.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    ports.keys.push_back(in.u64());
    ports.proteins.push_back(get_protein(in));
  }
  return ports;
}

// Written so that NaN fails.
bool in_unit_interval(double tag) { return tag >= 0 && tag <= 1; }

void require_tags(const std::vector<Protein>& proteins, const char* what) {
  for (const Protein& p : proteins)
    if (!in_unit_interval(p.id) || !in_unit_interval(p.enhancer) || !in_unit_interval(p.inhibitor))
      throw std::runtime_error(std::string("a tag of ") + what + " protein is outside [0, 1]");
}

void require_well_formed(const Network& network) {
  if (!std::isfinite(network.beta)) throw std::runtime_error("beta is not finite");
  if (!std::isfinite(network.delta)) throw std::runtime_error("delta is not finite");
  common::require_ascending(network.inputs.keys, "input");
  common::require_ascending(network.outputs.keys, "output");
  require_tags(network.inputs.proteins, "an input");
  require_tags(network.outputs.proteins, "an output");
  require_tags(network.regulators, "a regulatory");
}

void write_tags(const Protein& protein, JsonWriter& out) {
  out.number("id", protein.id);
  out.number("enhancer", protein.enhancer);
  out.number("inhibitor", protein.inhibitor);
}

void write_ports(std::string_view name, const PortProteins& ports, JsonWriter& out) {
  out.open_list(name);
  for (std::size_t i = 0; i < ports.keys.size(); ++i) {
    out.open_object("");
    out.key64("key", ports.keys[i]);
    write_tags(ports.proteins[i], out);
    out.close();
  }
  out.close();
}

Protein read_tags(const JsonReader& in) {
  return {in.member("id").number(), in.member("enhancer").number(),
          in.member("inhibitor").number()};
}

PortProteins read_ports(const JsonReader& in) {
  PortProteins ports;
  for (std::size_t i = 0; i < in.size(); ++i) {
    ports.keys.push_back(in.item(i).member("key").key64());
    ports.proteins.push_back(read_tags(in.item(i)));
  }
  return ports;
}

}  // namespace

void encode(const Network& network, Genes& genes) {
  common::ByteWriter out(
      genes, header_bytes +
                 port_protein_bytes * (network.inputs.keys.size() + network.outputs.keys.size()) +
                 protein_bytes * network.regulators.size());
  out.u32(signature);
  out.u32(static_cast<std::uint32_t>(network.inputs.keys.size()));
  out.u32(static_cast<std::uint32_t>(network.outputs.keys.size()));
  out.u32(static_cast<std::uint32_t>(network.regulators.size()));
  out.number(network.beta);
  out.number(network.delta);
  put(out, network.inputs);
  put(out, network.outputs);
  for (const Protein& protein : network.regulators) put(out, protein);
}

Network decode(GenesView genes) {
  common::ByteReader in(genes);
  if (in.u32() != signature)
    throw std::runtime_error("the genes are not those of a gene regulatory network");
  const std::uint32_t inputs = in.u32();
  const std::uint32_t outputs = in.u32();
  const std::uint32_t regulators = in.u32();
  in.expect_remaining(2 * 8 + port_protein_bytes * (std::uint64_t{inputs} + outputs) +
                      protein_bytes * regulators);

  Network network;
  network.beta = in.number();
  network.delta = in.number();
  network.inputs = get_ports(in, inputs);
  network.outputs = get_ports(in, outputs);
  network.regulators.reserve(regulators);
  for (std::uint32_t i = 0; i < regulators; ++i) network.regulators.push_back(get_protein(in));
  require_well_formed(network);
  return network;
}

void write_json(const Network& network, JsonWriter& out) {
  out.number("beta", network.beta);
  out.number("delta", network.delta);
  write_ports("inputs", network.inputs, out);
  write_ports("outputs", network.outputs, out);
  out.open_list("regulators");
  for (const Protein& protein : network.regulators) {
    out.open_object("");
    write_tags(protein, out);
    out.close();
  }
  out.close();
}

Network read_json(const JsonReader& in) {
  Network network;
  network.beta = in.member("beta").number();
  network.delta = in.member("delta").number();
  network.inputs = read_ports(in.member("inputs"));
  network.outputs = read_ports(in.member("outputs"));
  const JsonReader& regulators = in.member("regulators");
  for (std::size_t i = 0; i < regulators.size(); ++i)
    network.regulators.push_back(read_tags(regulators.item(i)));
  require_well_formed(network);
  return network;
}

}  // namespace somas::grn
