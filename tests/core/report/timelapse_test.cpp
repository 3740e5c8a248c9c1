// Panels of worlds whose cells stand where the test puts them.
#include "core/report/timelapse.hpp"

#include <array>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/errors.hpp"
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

const Subject subject{.experiment = "exp",
                      .run = "runs-1",
                      .seed = 7,
                      .generation = 12,
                      .individual = 34,
                      .origin = "mutation",
                      .world_seed = 0xABC,
                      .survival = 1046};

class TimelapseOfALife : public testing::Test {
 protected:
  TimelapseOfALife() {
    bench.config.radius = 10;
    bench.states = {{.name = "core"}, {.name = "skin", .parent = 0}};
    bench.free_living();
    bench.forceless();
  }
  void add(std::function<void(Declare&)> declare, std::function<void(World&)> act = {}) {
    bench.environments.push_back(model::test::acting(
        "field", Phase::stress,
        [act](World& w) {
          if (act) act(w);
        },
        declare));
  }
  void begin() {
    bench.start_with(
        {{.id = 0, .x = -5, .y = 0, .energy = 1}, {.id = 1, .x = 5, .y = 4, .state = 1}});
  }
  /// Four steps of the two cells.
  std::string drawn(TimelapseOptions options, FigureSize size = {}) {
    if (options.steps.empty()) options.steps = {0, 3};
    Timelapse timelapse(options, size);
    begin();
    for (int i = 0; i < 4; ++i) {
      bench.steps(1);
      if (prepare) prepare();
      timelapse.observe(bench.simulation());
    }
    return timelapse.render(subject);
  }

  Bench bench;
  std::function<void()> prepare;  ///< before a step is seen
};

TEST_F(TimelapseOfALife, HasACircleForEveryCellOfEveryPanelInTheColourOfItsState) {
  const std::string svg = drawn({});
  // Two panels, and the legend.
  EXPECT_EQ(filled(svg, colour_of_state(0)), 2 + 1);
  EXPECT_EQ(filled(svg, colour_of_state(1)), 2 + 1);
  EXPECT_EQ(filled(svg, colour_of_state(2)), 0);
}

TEST_F(TimelapseOfALife, SaysWhoseLifeItIs) {
  const std::string svg = drawn({});
  const std::string caption =
      "exp, run runs-1 (seed 7), generation 12: champion 34 (mutation), world seed "
      "0000000000000abc; survival 1,046 steps.";
  EXPECT_EQ(title(svg), "Development of an organism. " + caption);
  EXPECT_THAT(written(svg), AllOf(HasSubstr("step 0\n"), HasSubstr("step 3\n"), HasSubstr("core\n"),
                                  HasSubstr("skin\n"), HasSubstr(" units\n"),
                                  HasSubstr("survival 1,046 steps.")));
}

TEST_F(TimelapseOfALife, TellsWhatWasChangedAndWhoIsAlive) {
  Subject other = subject;
  other.changes = {"a.b=1", "c=2"};
  other.censored = true;
  other.population = 2;
  EXPECT_THAT(caption_of(other),
              AllOf(HasSubstr("generation 12, population 2"),
                    HasSubstr("1,046 steps (alive at the end)"), HasSubstr("what if a.b=1, c=2.")));
}

TEST_F(TimelapseOfALife, IsTheSameBytesTwiceInEveryFormat) {
  for (const PictureFormat format : {PictureFormat::svg, PictureFormat::pdf, PictureFormat::png})
    EXPECT_TRUE(drawn({}, {.format = format, .dpi = 100}) ==
                drawn({}, {.format = format, .dpi = 100}))
        << static_cast<int>(format);
}

TEST_F(TimelapseOfALife, IsAsWideAsAskedFor) {
  EXPECT_NE(drawn({}, {.width_mm = 85}).find("width=\"240.944882pt\""), std::string::npos);
  const test::Pixels png(drawn({}, {.format = PictureFormat::png, .width_mm = 85, .dpi = 254}));
  EXPECT_EQ(png.width(), 850);
}

TEST_F(TimelapseOfALife, EnergyIsGreenerTheHigherItIs) {
  prepare = [&] {
    bench.cells().energy[bench.at(0)] = 1;
    bench.cells().energy[bench.at(1)] = 0.25;
  };
  const std::string svg = drawn({.kind = PanelKind::energy});
  EXPECT_EQ(filled(svg, green_ramp(1)), 2);
  EXPECT_EQ(filled(svg, green_ramp(0.25)), 2);
  EXPECT_EQ(filled(svg, colour_of_state(0)), 0);
  EXPECT_THAT(written(svg), HasSubstr("energy\n"));
  for (double t = 0; t < 1; t += 0.125) EXPECT_GT(green_ramp(t).red, green_ramp(t + 0.125).red);
}

TEST_F(TimelapseOfALife, MorphogensAreShownAsSensedByCells) {
  bench.config.morphogens.kinds = {{0.5, 1}, {0.5, 1}};
  prepare = [&] {
    model::MorphogenFields& fields = bench.world().organisms[0].fields;
    fields.deposit(0, fields.footprint(-5, 0), 0.5f, model::Deposit::peak);
  };
  const std::string svg = drawn({.kind = PanelKind::morphogens});
  // The cell at the source senses all there is of the first, in the row of both and in its own;
  // the other cell nothing, and there is nothing of the second.
  EXPECT_EQ(filled(svg, morphogen_ramp(1, 1)), 0);
  EXPECT_THAT(written(svg), AllOf(HasSubstr("together\n"), HasSubstr("morphogen 1\n"),
                                  HasSubstr("morphogen 2\n"), Not(HasSubstr("morphogen 3"))));
  EXPECT_THAT(written(svg), HasSubstr("0.5\n"));
}

TEST_F(TimelapseOfALife, TheGridOfMorphogensIsDrawnBelowCircles) {
  bench.config.morphogens.kinds = {{0.5, 1}};
  prepare = [&] {
    model::MorphogenFields& fields = bench.world().organisms[0].fields;
    fields.set(0, 32, 32, 0.5f);
  };
  const std::string svg = drawn({.kind = PanelKind::grid});
  EXPECT_EQ(filled(svg, morphogen_ramp(0, 1)), 2);  // one square of each panel
  EXPECT_EQ(filled(svg, colour_of_state(0)), 0);
}

TEST_F(TimelapseOfALife, AnExperimentWithoutMorphogensHasNoneToShow) {
  bench.config.morphogens.kinds = {};
  EXPECT_THROW((void)drawn({.kind = PanelKind::morphogens}), run::UsageError);
}

// An environment that nobody has heard of.
TEST_F(TimelapseOfALife, ShowsWhatAnyEnvironmentDeclares) {
  Id table = no_id, grid = no_id;
  add(
      [&](Declare& d) {
        const std::array<std::string_view, 2> columns{"x", "y"};
        table = d.table("motes", columns);
        grid = d.grid("fog", {.columns = 10, .rows = 10, .side = 2, .left = -10, .bottom = -10});
        const std::array<Point, 4> pond{{{-2, -8}, {2, -8}, {2, -6}, {-2, -6}}};
        d.outline("pond", pond, true);
        d.outline("fence", std::span(pond).first(2), false);
      },
      [&](World& w) {
        w.table(table).resize(2);
        for (const Id column : {0u, 1u})
          for (double& value : w.table(table).column(column)) value = 3;
        w.grid(grid).values[55] = 4;
      });
  const std::string svg = drawn({.whole_world = true});
  EXPECT_THAT(written(svg),
              AllOf(HasSubstr("field.motes\n"), HasSubstr("field.fog\n"), HasSubstr("field.pond\n"),
                    HasSubstr("field.fence\n"), HasSubstr("4\n")));
  EXPECT_EQ(filled(svg, colour_of_table(0)), 2 + 1);  // all rows of a panel are one path
  EXPECT_GT(filled(svg, grey_ramp(1)), 1);
}

TEST_F(TimelapseOfALife, StripesWhereAResourceWasUnlessItIsEverywhere) {
  bench.environments.push_back(model::test::resource_grid("food", 2, 0, 2, 64));
  EXPECT_THAT(written(drawn({})), Not(HasSubstr("zone of food")));
  bench.environments = {model::test::resource_grid("food", 2, 0, 2, 4)};
  const std::string svg = drawn({});
  EXPECT_THAT(written(svg), HasSubstr("zone of food"));
}

TEST_F(TimelapseOfALife, AZoneKeepsItsStripesWhenTheResourceIsGone) {
  bench.environments = {model::test::resource_grid("food", 2, 0, 2, 4)};
  begin();
  Zones zones;
  bench.steps(1);
  zones.observe(bench.simulation());
  for (double& content : bench.world().grids[0]) content = 0;
  bench.steps(1);
  zones.observe(bench.simulation());
  ASSERT_EQ(zones.zones().size(), 1u);
  EXPECT_FALSE(zones.zones()[0].everywhere);
  EXPECT_THAT(zones.zones()[0].squares, testing::Each(1));
}

TEST_F(TimelapseOfALife, OrganismsInCompanyHaveOutlinesOfTheirOwn) {
  // Alone an organism has none.
  EXPECT_EQ(filled(drawn({}), colour_of_organism(0)), 0);
  Timelapse timelapse({.steps = {0}, .organism = 1}, {});
  bench.founders = {{.key = 1, .x = -5}, {.key = 2, .x = 5}};
  bench.start();
  bench.steps(1);
  timelapse.observe(bench.simulation());
  const std::string svg = timelapse.render(subject);
  EXPECT_EQ(filled(svg, colour_of_organism(0)), 1);
  EXPECT_EQ(filled(svg, colour_of_organism(1)), 1);
  EXPECT_THAT(written(svg),
              AllOf(HasSubstr("organism 1\n"), HasSubstr("organism 2 (the champion)\n")));
}

TEST(EvenSteps, AreMultiplesOfARoundNumberWithinTheLife) {
  EXPECT_THAT(even_steps(1046, 10), ElementsAre(100, 200, 300, 400, 500, 600, 700, 800, 900, 1000));
  EXPECT_THAT(even_steps(12, 4), ElementsAre(2, 4, 6, 8));
  EXPECT_THAT(even_steps(1, 8), ElementsAre(0));
  EXPECT_THAT(even_steps(0, 8), ElementsAre(0));
  for (std::uint64_t life = 1; life < 5000; life += 7)
    for (const std::uint64_t step : even_steps(life, 10)) EXPECT_LT(step, life);
}

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const run::UsageError& error) {
    return error.what();
  }
  return "not refused";
}

TEST_F(TimelapseOfALife, SaysWhyItCannotBeDrawn) {
  EXPECT_THAT(refusal([&] {
                (void)drawn({.steps = {0, 9}});
              }),
              HasSubstr("step 9 is beyond the life; its last step is 3"));
  EXPECT_THAT(refusal([&] { (void)drawn({.columns = 9}, {.width_mm = 85}); }),
              HasSubstr("--columns: 9 panels side by side"));
}

}  // namespace
}  // namespace somas::report
