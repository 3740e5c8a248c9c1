// How many random worlds the tests of the reference compare.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace somas::reference {

struct Seeds {
  std::uint64_t first = 0, end = 0;

  [[nodiscard]] std::uint64_t count() const { return end - first; }
};

/// 0 to `usual` - 1, unless SOMAS_REFERENCE_SEEDS says otherwise: "1000", as many instead;
/// "5000-6000", those from 5000 to 5999.
inline Seeds seeds_asked_for(std::uint64_t usual) {
  const char* text = std::getenv("SOMAS_REFERENCE_SEEDS");
  if (text == nullptr) return {0, usual};
  char* rest = nullptr;
  const std::uint64_t number = std::strtoull(text, &rest, 10);
  if (*rest != '-') return {0, number};
  return {number, std::strtoull(rest + 1, nullptr, 10)};
}

}  // namespace somas::reference
