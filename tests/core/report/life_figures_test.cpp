// Numbers of a life, and their charts.
#include "core/report/life_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"
#include "tests/core/report/drawn.hpp"

namespace somas::report {
namespace {

using model::test::Bench;
using test::filled;
using test::title;
using test::written;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const Subject subject{
    .experiment = "exp", .run = "r", .generation = 3, .origin = "elite", .survival = 9};

class HistoryOfALife : public testing::Test {
 protected:
  HistoryOfALife() {
    bench.states = {{.name = "core"}, {.name = "skin", .parent = 0}};
    bench.free_living();
    bench.forceless();
    bench.environments = {model::test::resource_grid("food", 2, 0, 2, 4)};
  }
  void place(std::uint32_t cores, std::uint32_t skins) {
    std::vector<model::test::Placed> cells;
    for (std::uint32_t i = 0; i < cores + skins; ++i)
      cells.push_back({.id = i,
                       .x = 2.5 * i - 25,
                       .y = 0,
                       .state = static_cast<std::uint16_t>(i < cores ? 0 : 1)});
    bench.replace(cells);
  }
  /// A life with these cells of either state after its steps.
  LifeHistory lived(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& census) {
    LifeHistory history;
    bench.start();
    for (const auto& [cores, skins] : census) {
      place(cores, skins);
      bench.steps(1);
      history.observe(bench.simulation());
      if (after_step) after_step();
    }
    return history;
  }

  Bench bench;
  std::function<void()> after_step;
};

TEST_F(HistoryOfALife, CountsCellsByStateStepByStep) {
  const LifeHistory history = lived({{1, 0}, {2, 1}, {3, 4}});
  EXPECT_THAT(history.step(), ElementsAre(0, 1, 2));
  EXPECT_THAT(history.cells().names, ElementsAre("core", "skin"));
  EXPECT_THAT(history.cells().values[0], ElementsAre(1, 2, 3));
  EXPECT_THAT(history.cells().values[1], ElementsAre(0, 1, 4));
  EXPECT_THAT(history.total(), ElementsAre(1, 3, 7));
}

TEST_F(HistoryOfALife, AvailabilityIsRelativeToTheMostThereWas) {
  after_step = [&] {
    for (double& content : bench.world().grids[0]) content /= 2;
  };
  EXPECT_THAT(lived({{1, 0}, {1, 0}, {1, 0}}).availability(), ElementsAre(1, 0.5, 0.25));
}

TEST_F(HistoryOfALife, DeathsAreThoseOfTheStep) {
  const auto handles = std::make_shared<model::test::Handles>();
  bench.environments.push_back(model::test::hazard("blow", handles, [&](World& w) {
    if (w.step() == 1) w.kill(0, handles->cause);
  }));
  const LifeHistory history = lived({{3, 0}, {3, 0}, {3, 0}});
  const auto cause =
      std::find(history.deaths().names.begin(), history.deaths().names.end(), "blow_kill");
  ASSERT_NE(cause, history.deaths().names.end());
  EXPECT_THAT(
      history.deaths().values[static_cast<std::size_t>(cause - history.deaths().names.begin())],
      ElementsAre(0, 1, 0));
}

std::string text(const std::vector<Phase>& phases) {
  std::string all;
  for (const Phase& phase : phases)
    all += phase.name + " " + std::to_string(static_cast<int>(phase.first)) + "-" +
           std::to_string(static_cast<int>(phase.last)) + " ";
  return all;
}

TEST_F(HistoryOfALife, PhasesFollowTheNumbers) {
  //                                0       1       2       3        4       5       6
  EXPECT_EQ(text(phases_of(lived({{1, 0}, {10, 0}, {19, 1}, {10, 10}, {10, 9}, {2, 8}, {0, 5}}))),
            "proliferation 0-1 specialization 2-4 decline 5-5 remnant 6-6 ");
}

TEST_F(HistoryOfALife, PhasesThatDoNotHappenAreLeftOut) {
  EXPECT_EQ(text(phases_of(lived({{1, 0}, {8, 0}, {4, 0}}))), "proliferation 0-1 decline 2-2 ");
  EXPECT_EQ(text(phases_of(lived({{1, 0}, {2, 0}}))), "proliferation 0-1 ");
  // Specialized only when there are few: no phase of its own.
  EXPECT_EQ(text(phases_of(lived({{20, 0}, {8, 8}}))), "proliferation 0-0 decline 1-1 ");
}

TEST_F(HistoryOfALife, PopulationHasAxesACurvePerStateAndACaption) {
  const std::string svg = population_figure(lived({{1, 0}, {2, 1}, {3, 4}}), subject, {});
  EXPECT_THAT(written(svg),
              AllOf(HasSubstr("time (steps)\n"), HasSubstr("cells\n"), HasSubstr("core\n"),
                    HasSubstr("skin\n"), HasSubstr("all cells\n"), HasSubstr("generation 3"),
                    Not(HasSubstr("resources"))));
  EXPECT_TRUE(svg == population_figure(lived({{1, 0}, {2, 1}, {3, 4}}), subject, {}));
}

TEST_F(HistoryOfALife, PopulationIsGreyBehindWhereThereAreResources) {
  std::uint64_t step = 0;
  after_step = [&] {
    ++step;
    for (double& content : bench.world().grids[0]) content = step < 3 ? 0 : 2;
  };
  const std::string svg = population_figure(lived({{1, 0}, {1, 0}, {1, 0}, {1, 0}}), subject, {});
  EXPECT_THAT(written(svg), HasSubstr("resources, share of the most"));
  // Full in steps 0 and 3, empty between.
  EXPECT_EQ(filled(svg, rgb(0xC4C4C4)), 2);
}

TEST_F(HistoryOfALife, PhasesAreNamedWithTheirSteps) {
  const LifeHistory history = lived({{1, 0}, {10, 0}, {19, 1}, {10, 10}, {10, 9}, {2, 8}, {0, 5}});
  const std::string svg = phases_figure(history, subject, {.width_mm = 120});
  EXPECT_THAT(title(svg),
              HasSubstr("I proliferation (0 to 1), II specialization (2 to 4), III decline "
                        "(5 to 5), IV remnant (6 to 6)."));
  EXPECT_THAT(written(svg),
              AllOf(HasSubstr("IV\n"), HasSubstr("cells\n"), HasSubstr("deaths / 1 steps\n"),
                    HasSubstr("food (most: 32)\n"), HasSubstr("first cell of a state\n")));
}

TEST_F(HistoryOfALife, ALifeOfOneStepIsDrawn) {
  EXPECT_THAT(written(population_figure(lived({{1, 0}}), subject, {})), HasSubstr("cells\n"));
  EXPECT_THAT(title(phases_figure(lived({{1, 0}}), subject, {})),
              HasSubstr("I proliferation (0 to 0)."));
}

}  // namespace
}  // namespace somas::report
