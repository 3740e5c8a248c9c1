// The best of a generation as a file: exact numbers, and all that is needed to live again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/evolution/heredity.hpp"
#include "core/evolution/population.hpp"
#include "core/experiment/experiment.hpp"
#include "core/run/json.hpp"
#include "core/run/life_record.hpp"

namespace somas::run {

/// Whose genes they are: a file of another controller is refused by name. Empty ids: not known, so
/// neither written nor compared.
struct GenomeOwners {
  experiment::PluginUse controller, specialization;
};
[[nodiscard]] GenomeOwners owners_of(const experiment::Experiment& experiment);

/// One of several organisms in a champion's world.
struct RosterSeat {
  std::uint64_t key = 1;
  double x = 0, y = 0;                ///< of the founder
  std::uint32_t population = 0;       ///< 1 or 2; 0: there is only one, or the hall of fame
  std::optional<std::uint64_t> id{};  ///< of an individual; none: fresh random genes
  model::Genome genome{};             ///< of the champion's own seat: unused
};

struct Champion {
  std::string experiment;
  std::uint64_t generation = 0;
  std::uint32_t population = 0;  ///< 1 or 2; 0: there is only one
  evolution::Individual individual;
  std::uint64_t seed = 0;  ///< of its first trial, which `life` tells
  LifeRecord life;
  std::vector<RosterSeat> roster{};  ///< of its first trial; empty: alone, at the origin, key 1
  std::size_t own_seat = 0;          ///< its place in the roster
  bool genes_match_bytes = true;     ///< when read: both forms of the genome agree
};

/// The simulation that the life tells; refers to the champion's genomes.
[[nodiscard]] evaluation::Task task_of(const Champion& champion);

/// The file's text. The genome stands there twice: as JSON, for people, and as bytes in
/// hexadecimal.
[[nodiscard]] std::string to_text(const Champion& champion, const evolution::Heredity& heredity,
                                  const GenomeOwners& owners = {});

/// Reads what to_text wrote. The JSON form of the genome counts (people edit it); where the bytes
/// say otherwise, genes_match_bytes is false. Throws UsageError that starts with `origin`.
[[nodiscard]] Champion parse_champion(std::string_view text, const std::string& origin,
                                      const evolution::Heredity& heredity,
                                      const GenomeOwners& owners = {});
/// What to say of a genome whose two forms disagree.
[[nodiscard]] std::string edited_warning(const std::string& origin);

/// The genome alone, as a JSON object.
[[nodiscard]] Json genome_to_json(const model::Genome& genome, const evolution::Heredity& heredity,
                                  const GenomeOwners& owners = {});

/// A roster as a JSON list: keys, places, who they are, genomes. The champion's own seat, if any,
/// has no genome: its file tells it elsewhere.
[[nodiscard]] Json roster_to_json(std::span<const RosterSeat> roster,
                                  const evolution::Heredity& heredity,
                                  const GenomeOwners& owners = {},
                                  std::optional<std::size_t> own = {});

struct SavedGenome {
  model::Genome genome;
  std::vector<std::string> warnings;  ///< edited by hand, made by another version of a plugin
};

/// The genome of a champion's file, or of a file that holds just the genome object.
[[nodiscard]] SavedGenome parse_genome(std::string_view text, const std::string& origin,
                                       const evolution::Heredity& heredity,
                                       const GenomeOwners& owners = {});

}  // namespace somas::run
