// Words in messages: "did you mean", lists, plurals.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace somas::plugins {

/// Edits (insert, delete, replace, swap neighbours) between two words; case counts for nothing.
[[nodiscard]] std::size_t edit_distance(std::string_view first, std::string_view second);

/// The candidate that `word` most likely means; empty when none is near. Ties: the first.
[[nodiscard]] std::string suggest(std::string_view word, std::span<const std::string> candidates);

/// "; did you mean 'x'?", or nothing.
[[nodiscard]] std::string did_you_mean(std::string_view word,
                                       std::span<const std::string> candidates);

/// "a, b, c"; `none` when there are none.
[[nodiscard]] std::string join(std::span<const std::string> words, std::string_view none = "none");

/// "1 generation", "2 generations".
[[nodiscard]] std::string plural(std::uint64_t count, std::string_view noun);

}  // namespace somas::plugins
