// The best of a generation as a file: exact numbers, and all that is needed to live again.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/evolution/heredity.hpp"
#include "core/evolution/population.hpp"
#include "core/run/json.hpp"
#include "core/run/recording.hpp"

namespace somas::run {

struct Champion {
  std::string experiment;
  std::uint64_t generation = 0;
  evolution::Individual individual;
  std::uint64_t seed = 0;  ///< of its first trial, which `recording` tells
  Recording recording;
  bool genes_match_bytes = true;  ///< when read: both forms of the genome agree
};

/// The file's text. The genome stands there twice: as JSON, for people, and as bytes in
/// hexadecimal.
[[nodiscard]] std::string to_text(const Champion& champion, const evolution::Heredity& heredity);

/// Reads what to_text wrote. The JSON form of the genome counts (people edit it); where the bytes
/// say otherwise, genes_match_bytes is false. Throws UsageError that starts with `origin`.
[[nodiscard]] Champion parse_champion(std::string_view text, const std::string& origin,
                                      const evolution::Heredity& heredity);

/// The genome alone, as a JSON object.
[[nodiscard]] Json genome_to_json(const model::Genome& genome, const evolution::Heredity& heredity);

/// The genome of a champion's file, or of a file that holds just the genome object.
[[nodiscard]] model::Genome parse_genome(std::string_view text, const std::string& origin,
                                         const evolution::Heredity& heredity);

}  // namespace somas::run
