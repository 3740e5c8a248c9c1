#include "core/plugins/suggest.hpp"

#include <algorithm>

namespace somas::plugins {
namespace {

// Longer words are not misspelt keys, and the distance is quadratic.
constexpr std::size_t longest_word = 64;

char folded(char c) {
  if (c >= 'A' && c <= 'Z') return static_cast<char>(c - 'A' + 'a');
  return c == '-' || c == ' ' ? '_' : c;
}

// How many edits still look like a slip.
std::size_t tolerance(std::size_t length) { return std::max<std::size_t>(1, length / 3); }

}  // namespace

std::size_t edit_distance(std::string_view first, std::string_view second) {
  // Rows of the table for the prefixes of `first` of length i - 2, i - 1 and i.
  std::vector<std::size_t> before(second.size() + 1), last(second.size() + 1),
      row(second.size() + 1);
  for (std::size_t j = 0; j <= second.size(); ++j) row[j] = j;

  for (std::size_t i = 1; i <= first.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= second.size(); ++j) {
      const char a = folded(first[i - 1]), b = folded(second[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a == b ? 0 : 1)});
      const bool swapped =
          i > 1 && j > 1 && a == folded(second[j - 2]) && folded(first[i - 2]) == b;
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[second.size()];
}

std::string suggest(std::string_view word, std::span<const std::string> candidates) {
  if (word.empty() || word.size() > longest_word) return {};

  const std::string* best = nullptr;
  std::size_t best_distance = longest_word;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > longest_word) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance > tolerance(std::max(word.size(), candidate.size()))) continue;
    if (best != nullptr && distance >= best_distance) continue;
    best = &candidate;
    best_distance = distance;
  }
  if (best != nullptr) return *best;

  // A part of a name: 'aggression' for 'particle_aggression'.
  if (word.size() < 4) return {};
  for (const std::string& candidate : candidates)
    if (candidate.find(word) != std::string::npos) return candidate;
  return {};
}

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
  const std::string found = suggest(word, candidates);
  return found.empty() ? "" : "; did you mean '" + found + "'?";
}

std::string join(std::span<const std::string> words, std::string_view none) {
  if (words.empty()) return std::string(none);
  std::string text = words[0];
  for (const std::string& word : words.subspan(1)) text += ", " + word;
  return text;
}

std::string plural(std::uint64_t count, std::string_view noun) {
  return std::to_string(count).append(" ").append(noun).append(count == 1 ? "" : "s");
}

}  // namespace somas::plugins
