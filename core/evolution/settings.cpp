#include "core/evolution/settings.hpp"

#include <array>

namespace somas::evolution {
namespace {

constexpr std::array<std::string_view, 4> mode_names = {"solo", "rosters", "coevolution",
                                                        "hall_of_fame"};

std::string in_mode(const Settings& settings) {
  return "evolution.mode " + std::string(name_of(settings.mode));
}

// A key that differs from its default was meant to do something.
std::optional<SettingsFault> idle_key(const Settings& settings) {
  const Roster defaults;
  const std::string does_nothing = "has no meaning in " + in_mode(settings);
  if (settings.mode == Mode::solo && settings.roster.size != defaults.size)
    return SettingsFault{"roster.size", does_nothing +
                                            "; allowed modes: rosters, coevolution, "
                                            "hall_of_fame"};
  if (settings.mode == Mode::solo && settings.roster.distance != defaults.distance)
    return SettingsFault{"roster.distance", does_nothing +
                                                "; allowed modes: rosters, coevolution, "
                                                "hall_of_fame"};
  if (settings.mode != Mode::hall_of_fame && settings.roster.hall != defaults.hall)
    return SettingsFault{"roster.hall", does_nothing + "; allowed mode: hall_of_fame"};
  return std::nullopt;
}

}  // namespace

std::string_view name_of(Mode mode) { return mode_names[static_cast<std::size_t>(mode)]; }

std::optional<Mode> mode_named(std::string_view name) {
  for (std::size_t i = 0; i < mode_names.size(); ++i)
    if (mode_names[i] == name) return static_cast<Mode>(i);
  return std::nullopt;
}

std::string_view name_of(Hall hall) { return hall == Hall::even ? "even" : "random"; }

std::uint32_t population_count(const Settings& settings) {
  return settings.mode == Mode::coevolution ? 2 : 1;
}

std::optional<SettingsFault> fault_in(const Settings& settings) {
  if (auto fault = idle_key(settings)) return fault;
  if (settings.mode == Mode::solo || settings.mode == Mode::hall_of_fame) return std::nullopt;
  const std::uint32_t populations = population_count(settings);
  if (settings.roster.size % populations != 0)
    return SettingsFault{"roster.size", std::to_string(settings.roster.size) +
                                            " is odd; allowed in " + in_mode(settings) +
                                            ": even numbers, half from each population"};
  // Rosters are full, so that everybody plays as often and in as large a company.
  const std::uint32_t members = settings.roster.size / populations;
  if (settings.population % members != 0)
    return SettingsFault{"population",
                         std::to_string(settings.population) + " does not fill rosters of " +
                             std::to_string(settings.roster.size) + "; allowed in " +
                             in_mode(settings) + ": multiples of " + std::to_string(members)};
  return std::nullopt;
}

}  // namespace somas::evolution
