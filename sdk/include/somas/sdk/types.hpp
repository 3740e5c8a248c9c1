/// @file
/// Plain types that every SDK header shares: handles, channel-major matrices, names and errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

/// All that host and plugins have in common. What is in a nested namespace `detail` is no
/// interface.
namespace somas {

/// Handle of something declared (a skill, a grid, a hazard ...). Handles of one category count from
/// 0 in the order of declaration; handles of different categories are unrelated numbers.
using Id = std::uint32_t;

/// No handle; what a default-constructed handle is.
inline constexpr Id no_id = 0xFFFFFFFFu;

/// Channel-major view of host-owned memory: `channels` rows of `lanes` values, the rows `stride`
/// elements apart (stride >= lanes). A lane is a cell, so loops over lanes vectorise.
/// Valid only during the call that received it.
template <class T>
struct Matrix {
  T* data = nullptr;           ///< first value of channel 0; owned by the host
  std::uint32_t channels = 0;  ///< rows
  std::uint32_t lanes = 0;     ///< values of a row
  std::size_t stride = 0;      ///< elements from a row's first value to the next one's

  /// The lanes of channel `c`. Precondition: c < channels.
  [[nodiscard]] std::span<T> channel(std::uint32_t c) const { return {data + c * stride, lanes}; }
};

/// 64-bit FNV-1a of a name: the stable key of ports and states across processes and versions.
/// `seed` is what the hash goes on from: the hash of what comes before.
[[nodiscard]] constexpr std::uint64_t stable_key(std::string_view name,
                                                 std::uint64_t seed = 0xCBF29CE484222325ull) {
  std::uint64_t hash = seed;
  for (const char c : name) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001B3ull;
  }
  return hash;
}

/// What every plugin class says of itself: `static constexpr somas::About about{"id", "one line"};`
/// The id is lower_snake_case and unique among all plugins that a host finds.
struct About {
  const char* id;   ///< a literal; what an experiment calls the class
  const char* doc;  ///< a literal; one line, without a full stop
};

/// A parameter (or a combination of parameters) that cannot be used. Thrown by a plugin's
/// constructor or while wiring; the host turns it into file:line:column of the YAML key.
class ParameterError : public std::runtime_error {
 public:
  /// `path` names the parameter relative to the plugin's own block: "rate", "states[2].parent";
  /// `what` says what is wrong with it, and what would be right.
  ParameterError(std::string path, const std::string& what)
      : std::runtime_error(what), path_(std::move(path)) {}

  /// The parameter's name, as given.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace somas
