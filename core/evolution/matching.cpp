#include "core/evolution/matching.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "somas/sdk/math.hpp"
#include "somas/sdk/rng.hpp"

#include "core/evolution/reproduction.hpp"

namespace somas::evolution {
namespace {

void shuffle(std::vector<std::size_t>& items, Rng& rng) {
  for (std::size_t left = items.size(); left > 1; --left)
    std::swap(items[left - 1], items[rng.below(left)]);
}

std::vector<std::size_t> shuffled(std::size_t count, Rng rng) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  shuffle(order, rng);
  return order;
}

std::vector<Match> solo(const Settings& settings, std::uint64_t seed, std::uint64_t generation) {
  std::vector<Match> all;
  for (std::size_t i = 0; i < settings.population; ++i)
    for (std::uint32_t trial = 0; trial < settings.trials; ++trial)
      all.push_back({{{.index = i}}, trial, trial_seed(seed, generation, trial)});
  return all;
}

void sit(std::vector<Seat>& seats, std::size_t seat, Source source, std::size_t index) {
  seats[seat].source = source;
  seats[seat].index = index;
}

// The shuffled populations are dealt out roster after roster.
void deal(const Settings& settings, std::uint64_t seed, std::uint64_t generation,
          std::uint32_t trial, std::vector<Match>& all) {
  const std::uint32_t populations = population_count(settings);
  const std::size_t members = settings.roster.size / populations;
  std::vector<std::vector<std::size_t>> hands;
  for (std::uint32_t p = 0; p < populations; ++p)
    hands.push_back(shuffled(settings.population,
                             Rng(seed, p, generation, stable_key("roster.members"), trial)));
  const std::vector<Seat> empty = seats_of(settings.roster, seed, generation, trial);
  Rng seating(seed, 0, generation, stable_key("roster.seats"), trial);
  std::vector<std::size_t> order(settings.roster.size);
  for (std::size_t first = 0; first < settings.population; first += members) {
    Match match{empty, trial, trial_seed(seed, generation, trial)};
    std::iota(order.begin(), order.end(), std::size_t{0});
    shuffle(order, seating);
    for (std::size_t k = 0; k < order.size(); ++k) {
      const std::size_t population = k / members;
      sit(match.seats, order[k], static_cast<Source>(population),
          hands[population][first + k % members]);
    }
    all.push_back(std::move(match));
  }
}

std::vector<Match> against_hall(const Settings& settings, std::uint64_t seed,
                                std::uint64_t generation) {
  const std::size_t others = settings.roster.size - 1;
  std::vector<Match> by_trial;
  std::vector<std::size_t> own_seat;
  for (std::uint32_t trial = 0; trial < settings.trials; ++trial) {
    Match match{seats_of(settings.roster, seed, generation, trial), trial,
                trial_seed(seed, generation, trial)};
    own_seat.push_back(
        Rng(seed, 0, generation, stable_key("roster.seats"), trial).below(settings.roster.size));
    for (std::size_t k = 0; k < others; ++k)
      sit(match.seats, k < own_seat[trial] ? k : k + 1, Source::hall, trial * others + k);
    by_trial.push_back(std::move(match));
  }
  std::vector<Match> all;
  for (std::size_t i = 0; i < settings.population; ++i)
    for (std::uint32_t trial = 0; trial < settings.trials; ++trial) {
      all.push_back(by_trial[trial]);
      sit(all.back().seats, own_seat[trial], Source::first, i);
    }
  return all;
}

}  // namespace

std::vector<Seat> seats_of(const Roster& roster, std::uint64_t seed, std::uint64_t generation,
                           std::uint32_t trial) {
  Rng rng(seed, 0, generation, stable_key("roster.angle"), trial);
  const double turn = rng.uniform();
  std::vector<Seat> seats(roster.size);
  for (std::uint32_t k = 0; k < roster.size; ++k) {
    const double part = turn + static_cast<double>(k) / roster.size;
    const math::SinCos angle = math::sincos(math::two_pi * (part < 1 ? part : part - 1));
    seats[k] = {.key = k + 1u, .x = roster.distance * angle.cos, .y = roster.distance * angle.sin};
  }
  return seats;
}

std::vector<Match> matches(const Settings& settings, std::uint64_t seed, std::uint64_t generation) {
  if (settings.mode == Mode::solo) return solo(settings, seed, generation);
  if (settings.mode == Mode::hall_of_fame) return against_hall(settings, seed, generation);
  std::vector<Match> all;
  for (std::uint32_t trial = 0; trial < settings.trials; ++trial)
    deal(settings, seed, generation, trial, all);
  return all;
}

std::vector<HallMember> hall_of(const Settings& settings, std::uint64_t seed,
                                std::uint64_t generation) {
  if (settings.mode != Mode::hall_of_fame) return {};
  const std::uint64_t count = std::uint64_t{settings.trials} * (settings.roster.size - 1);
  std::vector<HallMember> hall;
  Rng rng(seed, 0, generation, stable_key("roster.hall"), 0);
  for (std::uint64_t k = 0; k < count; ++k) {
    if (generation == 0)
      hall.push_back({k, true});
    else if (settings.roster.hall == Hall::random)
      hall.push_back({rng.below(generation), false});
    else  // the ends of `count` equal parts of 0 .. generation - 1
      hall.push_back({std::max<std::uint64_t>((k + 1) * generation / count, 1) - 1, false});
  }
  return hall;
}

}  // namespace somas::evolution
