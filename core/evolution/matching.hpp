// Who meets whom (docs/model.md, section 7). Everything here is a pure function of its arguments:
// draws come from random streams named by seed, generation and trial.
#pragma once

#include <cstdint>
#include <vector>

#include "core/evolution/settings.hpp"

namespace somas::evolution {

/// Where an organism of a match comes from.
enum class Source : std::uint8_t { first, second, hall };

/// A place in a roster: who sits there, the key that names the organism's random streams, and where
/// its founder appears.
struct Seat {
  Source source = Source::first;
  std::size_t index = 0;  ///< in its population, or in the hall (see HallMember)
  std::uint64_t key = 1;
  double x = 0, y = 0;

  friend bool operator==(const Seat&, const Seat&) = default;
};

/// One simulation of a generation.
struct Match {
  std::vector<Seat> seats;
  std::uint32_t trial = 0;
  std::uint64_t seed = 0;  ///< of the simulation: the trial's

  friend bool operator==(const Match&, const Match&) = default;
};

/// The seat keys of a roster are 1, 2, ...; its founders stand as the corners of a regular polygon,
/// which is turned by an angle of its own in each trial.
[[nodiscard]] std::vector<Seat> seats_of(const Roster& roster, std::uint64_t seed,
                                         std::uint64_t generation, std::uint32_t trial);

/// All simulations of a generation. Every individual sits in `trials` of them, once in each trial.
///   solo: alone at the origin; by individual, then trial.
///   rosters: each trial deals the shuffled population out into rosters.
///   coevolution: each trial deals both populations out; half of each roster is of either, and who
///     of them gets which seat is drawn.
///   hall_of_fame: by individual, then trial; the others are the trial's hall members, and the seat
///     of the individual is drawn once for the trial, so that all face the same.
[[nodiscard]] std::vector<Match> matches(const Settings& settings, std::uint64_t seed,
                                         std::uint64_t generation);

/// A champion of an earlier generation; in generation 0, where there is none, fresh random genes
/// from a stream of this number.
struct HallMember {
  std::uint64_t number = 0;
  bool random = false;

  friend bool operator==(const HallMember&, const HallMember&) = default;
};

/// The hall of a generation, (size - 1) members for each trial, in order; empty in other modes.
[[nodiscard]] std::vector<HallMember> hall_of(const Settings& settings, std::uint64_t seed,
                                              std::uint64_t generation);

}  // namespace somas::evolution
