// The simulations of a generation: the matches of its mode, filled with genomes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/evolution/heredity.hpp"
#include "core/evolution/matching.hpp"
#include "core/evolution/population.hpp"
#include "core/run/champion.hpp"

namespace somas::run {

/// The best of an earlier generation, as the hall of fame keeps it.
struct FormerChampion {
  std::uint64_t id = 0;
  model::Genome genome;
};

class Contest {
 public:
  /// `populations`: as many as the mode has; they must outlive this. `former`: the champions of all
  /// earlier generations, read in mode hall_of_fame only. Throws model::PluginFailure.
  Contest(const evolution::Settings& settings, const evolution::Heredity& heredity,
          std::uint64_t seed, std::uint64_t generation,
          const std::vector<evolution::Population>& populations,
          const std::vector<FormerChampion>& former);

  [[nodiscard]] const std::vector<evolution::Match>& matches() const { return matches_; }
  /// A task per match; they refer to genomes of the populations and of this.
  [[nodiscard]] std::vector<evaluation::Task> tasks() const;

  /// Where an individual sits in a trial.
  struct Part {
    std::size_t match = 0, seat = 0;
  };
  [[nodiscard]] Part part(std::size_t population, std::size_t index, std::uint32_t trial) const {
    return parts_[population][index * trials_ + trial];
  }

  /// Everybody in a match, for a record; empty for an organism alone.
  [[nodiscard]] std::vector<RosterSeat> roster(std::size_t match) const;
  /// Ids of whom an individual met: those of a trial apart by spaces, trials by semicolons;
  /// "random" for fresh random genes, "POPULATION:ID" where there are two populations.
  [[nodiscard]] std::string opponents(std::size_t population, std::size_t index) const;

 private:
  struct HallEntry {
    std::uint64_t id = 0;
    bool random = false;
    model::Genome genome;
  };
  [[nodiscard]] const model::Genome& genome_of(const evolution::Seat& seat) const;
  [[nodiscard]] std::string name_of(const evolution::Seat& seat) const;

  const std::vector<evolution::Population>& populations_;
  std::uint32_t trials_;
  std::vector<evolution::Match> matches_;
  std::vector<HallEntry> hall_;
  std::vector<std::vector<Part>> parts_;  ///< by population, then index and trial
};

}  // namespace somas::run
