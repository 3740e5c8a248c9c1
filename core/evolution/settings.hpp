// Parameters of the genetic algorithm (docs/model.md, section 7).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace somas::evolution {

/// Whom an individual meets in its simulations.
enum class Mode : std::uint8_t {
  solo,          ///< nobody
  rosters,       ///< others of its population
  coevolution,   ///< others of its population and as many of a second one
  hall_of_fame,  ///< champions of earlier generations
};

/// How a hall of fame is drawn from the champions of earlier generations.
enum class Hall : std::uint8_t {
  even,    ///< evenly over all of them, the newest among them
  random,  ///< each as likely, with replacement
};

/// "solo", "rosters", "coevolution", "hall_of_fame"; "even", "random".
[[nodiscard]] std::string_view name_of(Mode mode);
[[nodiscard]] std::optional<Mode> mode_named(std::string_view name);
[[nodiscard]] std::string_view name_of(Hall hall);

struct Roster {
  std::uint32_t size = 2;  ///< organisms of a simulation
  double distance = 12;    ///< of the founders from the centre
  Hall hall = Hall::even;
};

struct Settings {
  Mode mode = Mode::solo;
  std::uint32_t population = 400;
  std::uint32_t generations = 120;
  std::uint32_t tournament = 4;  ///< drawn with replacement
  double elite_fraction = 0.02;  ///< elites = max(1, floor(fraction * population))
  double crossover = 0.5;        ///< probability that a child has two parents
  double mutation = 0.8;         ///< probability that a child is mutated
  std::uint32_t trials = 1;      ///< simulations averaged per evaluation
  Roster roster{};               ///< in all modes but solo
};

/// 2 in mode coevolution, else 1.
[[nodiscard]] std::uint32_t population_count(const Settings& settings);

/// What is wrong with settings of which each alone is in its range.
struct SettingsFault {
  std::string key;      ///< below `evolution`: "population", "roster.size"
  std::string message;  ///< what is wrong, and what is allowed
};
[[nodiscard]] std::optional<SettingsFault> fault_in(const Settings& settings);

}  // namespace somas::evolution
