// Genes that belong to ports are stored under the port's stable key, in ascending order of keys, so
// that they do not depend on the order in which a layout lists its ports.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "somas/sdk/layout.hpp"

namespace somas::common {

using Keys = std::vector<std::uint64_t>;

/// The ports' keys, ascending.
[[nodiscard]] inline Keys sorted_keys(std::span<const Port> ports) {
  Keys keys;
  keys.reserve(ports.size());
  for (const Port& port : ports) keys.push_back(port.key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// Where `key` stands among ascending keys.
[[nodiscard]] inline std::optional<std::size_t> find_key(std::span<const std::uint64_t> keys,
                                                         std::uint64_t key) {
  const auto at = std::lower_bound(keys.begin(), keys.end(), key);
  if (at == keys.end() || *at != key) return std::nullopt;
  return static_cast<std::size_t>(at - keys.begin());
}

/// A key as people read it in JSON: 16 hexadecimal digits.
[[nodiscard]] inline std::string key_text(std::uint64_t key) {
  std::string text(16, '0');
  for (std::size_t i = 0; i < 16; ++i) text[i] = "0123456789abcdef"[(key >> (60 - 4 * i)) & 15];
  return text;
}

/// Throws unless the keys ascend strictly. `what` is "input" or "output".
inline void require_ascending(std::span<const std::uint64_t> keys, const char* what) {
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i - 1] >= keys[i])
      throw std::runtime_error(std::string("the ") + what +
                               " keys of the genes do not ascend at key " + key_text(keys[i]));
}

/// Throws unless ascending keys are those of the ports, neither more nor fewer.
inline void require_ports(std::span<const std::uint64_t> keys, std::span<const Port> ports,
                          const char* what) {
  for (const Port& port : ports)
    if (!find_key(keys, port.key))
      throw std::runtime_error(std::string("the genes lack the ") + what + " port \"" +
                               std::string(port.name) + "\" (key " + key_text(port.key) + ")");
  const Keys known = sorted_keys(ports);
  for (const std::uint64_t key : keys)
    if (!find_key(known, key))
      throw std::runtime_error(std::string("the genes hold an ") + what + " for key " +
                               key_text(key) + ", which no port has");
}

}  // namespace somas::common
