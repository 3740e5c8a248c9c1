// Genes as canonical little-endian bytes, whatever the machine's own order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "somas/sdk/heritable.hpp"

namespace somas::common {

/// Appends numbers to genes; what they held before is dropped.
class ByteWriter {
 public:
  /// There will be `bytes` of them, or a few more.
  explicit ByteWriter(Genes& genes, std::size_t bytes = 0) : genes_(genes) {
    genes_.clear();
    genes_.reserve(bytes);
  }

  void u32(std::uint32_t value) { append<4>(value); }
  void u64(std::uint64_t value) { append<8>(value); }
  void number(double value) { u64(std::bit_cast<std::uint64_t>(value)); }

 private:
  template <std::size_t Bytes>
  void append(std::uint64_t value) {
    const std::size_t at = genes_.size();
    genes_.resize(at + Bytes);
    for (std::size_t i = 0; i < Bytes; ++i)
      genes_[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }

  Genes& genes_;
};

/// Reads them back; std::runtime_error where the genes end too early or too late.
class ByteReader {
 public:
  explicit ByteReader(GenesView genes) : genes_(genes) {}

  std::uint32_t u32() { return static_cast<std::uint32_t>(take<4>()); }
  std::uint64_t u64() { return take<8>(); }
  double number() { return std::bit_cast<double>(u64()); }

  /// Requires exactly `bytes` more. Asked before anything is allocated for a count that was read.
  void expect_remaining(std::uint64_t bytes) const {
    const std::uint64_t left = genes_.size() - position_;
    if (left == bytes) return;
    throw std::runtime_error("the genes have " + std::to_string(left) + " bytes after their " +
                             "header where their counts ask for " + std::to_string(bytes));
  }

 private:
  template <std::size_t Bytes>
  std::uint64_t take() {
    if (genes_.size() - position_ < Bytes)
      throw std::runtime_error("the genes are truncated: they end after " +
                               std::to_string(genes_.size()) + " bytes");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < Bytes; ++i)
      value |= static_cast<std::uint64_t>(genes_[position_ + i]) << (8 * i);
    position_ += Bytes;
    return value;
  }

  GenesView genes_;
  std::size_t position_ = 0;
};

}  // namespace somas::common
