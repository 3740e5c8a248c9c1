#include "core/evolution/matching.hpp"

#include <cmath>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/evolution/reproduction.hpp"

namespace somas::evolution {
namespace {

using testing::HasSubstr;

Settings settings_of(Mode mode, std::uint32_t population, std::uint32_t size,
                     std::uint32_t trials) {
  Settings settings;
  settings.mode = mode;
  settings.population = population;
  settings.trials = trials;
  settings.roster.size = size;
  return settings;
}

const std::vector<Settings> all_modes = {
    settings_of(Mode::solo, 12, 2, 3),         settings_of(Mode::rosters, 12, 2, 3),
    settings_of(Mode::rosters, 12, 4, 1),      settings_of(Mode::coevolution, 12, 2, 2),
    settings_of(Mode::coevolution, 12, 6, 3),  settings_of(Mode::hall_of_fame, 11, 2, 3),
    settings_of(Mode::hall_of_fame, 11, 4, 2),
};

using Who = std::pair<Source, std::size_t>;

TEST(Matches, HaveEveryIndividualOnceInEachTrial) {
  for (const Settings& settings : all_modes)
    for (std::uint64_t generation = 0; generation < 5; ++generation) {
      std::map<std::pair<Who, std::uint32_t>, int> times;
      for (const Match& match : matches(settings, 7, generation))
        for (const Seat& seat : match.seats)
          if (seat.source != Source::hall) ++times[{{seat.source, seat.index}, match.trial}];
      EXPECT_EQ(times.size(),
                std::size_t{settings.population} * settings.trials * population_count(settings));
      for (const auto& [who, count] : times) EXPECT_EQ(count, 1);
    }
}

TEST(Matches, NeverSetAnyoneAgainstItself) {
  for (const Settings& settings : all_modes)
    for (const Match& match : matches(settings, 3, 2)) {
      std::set<Who> members;
      std::set<std::uint64_t> keys;
      for (const Seat& seat : match.seats) {
        EXPECT_TRUE(members.insert({seat.source, seat.index}).second);
        EXPECT_TRUE(keys.insert(seat.key).second);
      }
    }
}

TEST(Matches, FillEveryRoster) {
  for (const Settings& settings : all_modes)
    for (const Match& match : matches(settings, 3, 2)) {
      EXPECT_EQ(match.seats.size(), settings.mode == Mode::solo ? 1 : settings.roster.size);
      EXPECT_EQ(match.seed, trial_seed(3, 2, match.trial)) << "all of a trial face one seed";
      std::map<Source, std::size_t> of;
      for (const Seat& seat : match.seats) ++of[seat.source];
      if (settings.mode == Mode::coevolution) {
        EXPECT_EQ(of[Source::first], of[Source::second]);
      }
      if (settings.mode == Mode::hall_of_fame) {
        EXPECT_EQ(of[Source::first], 1u);
      }
    }
}

TEST(Matches, AreAFunctionOfSeedAndGeneration) {
  for (const Settings& settings : all_modes) {
    EXPECT_EQ(matches(settings, 3, 2), matches(settings, 3, 2));
    EXPECT_NE(matches(settings, 3, 2), matches(settings, 4, 2));
    EXPECT_NE(matches(settings, 3, 2), matches(settings, 3, 3));
  }
}

TEST(Matches, OfOneAloneAreAtTheOriginByIndividualThenTrial) {
  const std::vector<Match> all = matches(settings_of(Mode::solo, 3, 2, 2), 1, 0);
  ASSERT_EQ(all.size(), 6u);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].seats, (std::vector<Seat>{{.index = k / 2, .key = 1, .x = 0, .y = 0}}));
    EXPECT_EQ(all[k].trial, k % 2);
  }
}

TEST(Matches, OfRostersMixAnewInEachTrial) {
  // Over many generations everybody meets everybody, about as often.
  const Settings settings = settings_of(Mode::rosters, 6, 2, 1);
  std::map<std::set<std::size_t>, int> met;
  for (std::uint64_t generation = 0; generation < 1500; ++generation)
    for (const Match& match : matches(settings, 5, generation))
      ++met[{match.seats[0].index, match.seats[1].index}];
  EXPECT_EQ(met.size(), 15u);
  // 4500 matches of 15 pairs: 300 each, standard deviation below 18.
  for (const auto& [pair, count] : met) EXPECT_NEAR(count, 300, 90);
}

TEST(Matches, FavourNoIndexWithASeat) {
  for (const Settings& settings :
       {settings_of(Mode::rosters, 4, 2, 1), settings_of(Mode::coevolution, 4, 2, 1),
        settings_of(Mode::hall_of_fame, 4, 2, 1)}) {
    std::map<Who, int> first_seat;
    for (std::uint64_t generation = 0; generation < 1000; ++generation)
      for (const Match& match : matches(settings, 5, generation)) {
        const Seat& seat = match.seats[0];
        if (seat.source != Source::hall) ++first_seat[{seat.source, seat.index}];
      }
    for (const auto& [who, count] : first_seat) EXPECT_NEAR(count, 500, 80);
  }
}

TEST(Matches, OfTheHallGiveAllIndividualsTheSameOpponentsAndSeat) {
  const std::vector<Match> all = matches(settings_of(Mode::hall_of_fame, 5, 3, 2), 9, 4);
  ASSERT_EQ(all.size(), 10u);
  for (std::size_t k = 2; k < all.size(); ++k)
    for (std::size_t s = 0; s < 3; ++s) {
      Seat expected = all[k % 2].seats[s];
      if (expected.source == Source::first) expected.index = k / 2;
      EXPECT_EQ(all[k].seats[s], expected);
    }
  EXPECT_NE(all[0].seats[0].x, all[1].seats[0].x) << "each trial turns the polygon";
}

TEST(Seats, AreTheCornersOfARegularPolygon) {
  const Roster roster{.size = 5, .distance = 12.5};
  const std::vector<Seat> seats = seats_of(roster, 1, 2, 3);
  const double side = 2 * 12.5 * std::sin(3.14159265358979323846 / 5);
  double x = 0, y = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    const Seat &seat = seats[k], &next = seats[(k + 1) % 5];
    EXPECT_EQ(seat.key, k + 1);
    EXPECT_NEAR(std::hypot(seat.x, seat.y), 12.5, 1e-12);
    EXPECT_NEAR(std::hypot(seat.x - next.x, seat.y - next.y), side, 1e-12);
    x += seat.x;
    y += seat.y;
  }
  EXPECT_NEAR(x, 0, 1e-12);
  EXPECT_NEAR(y, 0, 1e-12);
}

TEST(Hall, IsEvenlySpacedUpToTheNewestChampion) {
  const Settings settings = settings_of(Mode::hall_of_fame, 10, 2, 4);
  const auto numbers = [&](std::uint64_t generation) {
    std::vector<std::uint64_t> all;
    for (const HallMember& member : hall_of(settings, 1, generation)) {
      EXPECT_EQ(member.random, generation == 0);
      all.push_back(member.number);
    }
    return all;
  };
  EXPECT_THAT(numbers(0), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(numbers(1), testing::ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(numbers(4), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(numbers(20), testing::ElementsAre(4, 9, 14, 19));
}

TEST(Hall, DrawnAtRandomReachesEveryEarlierChampion) {
  Settings settings = settings_of(Mode::hall_of_fame, 10, 3, 2);
  settings.roster.hall = Hall::random;
  std::map<std::uint64_t, int> drawn;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const std::vector<HallMember> hall = hall_of(settings, seed, 5);
    EXPECT_EQ(hall, hall_of(settings, seed, 5));
    for (const HallMember& member : hall) ++drawn[member.number];
  }
  EXPECT_EQ(drawn.size(), 5u);
  for (const auto& [number, count] : drawn) EXPECT_NEAR(count, 400, 90);
}

TEST(Hall, IsEmptyInOtherModes) {
  EXPECT_TRUE(hall_of(settings_of(Mode::rosters, 10, 2, 4), 1, 3).empty());
}

std::string complaint(const Settings& settings) {
  const auto fault = fault_in(settings);
  return fault ? fault->key + ": " + fault->message : "";
}

TEST(ModeSettings, AreFineByDefaultInEveryMode) {
  for (const Settings& settings : all_modes) EXPECT_EQ(complaint(settings), "");
  EXPECT_EQ(complaint(Settings{}), "");
}

TEST(ModeSettings, MustFillTheRosters) {
  EXPECT_THAT(complaint(settings_of(Mode::rosters, 61, 2, 1)),
              HasSubstr("population: 61 does not fill rosters of 2; allowed in evolution.mode "
                        "rosters: multiples of 2"));
  EXPECT_THAT(complaint(settings_of(Mode::coevolution, 61, 4, 1)),
              HasSubstr("population: 61 does not fill rosters of 4; allowed in evolution.mode "
                        "coevolution: multiples of 2"));
  EXPECT_THAT(complaint(settings_of(Mode::coevolution, 60, 3, 1)),
              HasSubstr("roster.size: 3 is odd"));
}

TEST(ModeSettings, RefuseKeysOfAnotherMode) {
  EXPECT_THAT(complaint(settings_of(Mode::solo, 60, 3, 1)),
              HasSubstr("roster.size: has no meaning in evolution.mode solo; allowed modes: "
                        "rosters, coevolution, hall_of_fame"));
  Settings settings;
  settings.roster.distance = 3;
  EXPECT_THAT(complaint(settings), HasSubstr("roster.distance: has no meaning"));
  settings = settings_of(Mode::rosters, 60, 2, 1);
  settings.roster.hall = Hall::random;
  EXPECT_THAT(complaint(settings),
              HasSubstr("roster.hall: has no meaning in evolution.mode rosters; allowed mode: "
                        "hall_of_fame"));
}

}  // namespace
}  // namespace somas::evolution
