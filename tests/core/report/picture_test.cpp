// Pictures of worlds whose cells stand where the test puts them, read back pixel by pixel.
#include "core/report/picture.hpp"

#include <algorithm>
#include <array>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/errors.hpp"
#include "tests/core/model/support.hpp"
#include "tests/core/report/drawn.hpp"

namespace somas::report {
namespace {

using model::test::Bench;
using model::test::Handles;
using testing::AllOf;
using testing::HasSubstr;

constexpr unsigned no_ink = 0xFFFFFF, orange = 0xE69F00, blue = 0x0072B2, vermillion = 0xD55E00;

/// The pixels of a picture of the whole world.
class Pixels : public test::Pixels {
 public:
  using test::Pixels::Pixels;
  /// In the world view of one panel `world` across its radius; the panel is as wide as the picture
  /// but for a gap of 4 at both sides, under the title.
  [[nodiscard]] unsigned at_world(double x, double y, double radius) const {
    const double side = width() - 2 * 5.0, font = std::min(30.0, side / 22),
                 top = 5 + 1.2 * 1.45 * font;
    const double scale = side / (2 * 1.03 * radius);
    return at(static_cast<int>(5 + side / 2 + x * scale),
              static_cast<int>(top + side / 2 - y * scale));
  }
};

class PictureOfAWorld : public testing::Test {
 protected:
  PictureOfAWorld() {
    bench.config.radius = 10;
    bench.states = {{.name = "core"}, {.name = "skin", .parent = 0}};
    bench.free_living();
    bench.forceless();
  }
  /// A step with cells at rest: core at (-5, 0), skin at (5, 4).
  Picture drawn(PictureOptions options = {.steps = {0}, .whole_world = true, .width = 800}) {
    bench.start_with({{.id = 0, .x = -5, .y = 0}, {.id = 1, .x = 5, .y = 4, .state = 1}});
    bench.steps(1);
    if (dividing) bench.cells().action[bench.at(0)] = model::Action::division;
    Picture picture(std::move(options));
    picture.observe(bench.simulation());
    return picture;
  }
  void add(std::function<void(Declare&)> declare) {
    bench.environments.push_back(model::test::acting(
        "field", Phase::stress,
        [this](World& w) {
          if (act) act(w);
        },
        declare));
  }

  Bench bench;
  bool dividing = false;
  std::function<void(World&)> act;
};

TEST_F(PictureOfAWorld, ShowsCellsWhereTheyAreInTheColourOfTheirState) {
  const Pixels png(drawn().render(PictureFormat::png));
  EXPECT_EQ(png.at_world(-5, 0, 10), orange);
  EXPECT_EQ(png.at_world(-5, 0.8, 10), orange);
  EXPECT_EQ(png.at_world(5, 4, 10), blue);
  for (const auto& [x, y] :
       {std::pair{-5.0, 1.2}, {-5.0, -1.2}, {5.0, -4.0}, {-5.0, 4.0}, {0., 0.}})
    EXPECT_EQ(png.at_world(x, y, 10), no_ink) << x << " " << y;
}

TEST_F(PictureOfAWorld, RimsCellsThatDivide) {
  dividing = true;
  const Pixels png(drawn().render(PictureFormat::png));
  EXPECT_EQ(png.at_world(-5, 0.85, 10), 0x191919u);
  EXPECT_EQ(png.at_world(-5, 0, 10), orange);
  EXPECT_NE(png.at_world(5, 4.85, 10), 0x191919u);
}

TEST_F(PictureOfAWorld, CountsCellsByStateAndThoseThatDivide) {
  dividing = true;
  const Picture picture = drawn();
  ASSERT_EQ(picture.panels().size(), 1u);
  EXPECT_EQ(picture.states(), (std::vector<std::string>{"core", "skin"}));
  EXPECT_EQ(picture.panels()[0].counts, (std::vector<std::uint32_t>{1, 1}));
  EXPECT_EQ(picture.panels()[0].dividing(), 1u);
}

TEST_F(PictureOfAWorld, DrawsOutlinesOfEnvironments) {
  add([](Declare& d) {
    const std::array<Point, 4> wall{{{-2, -6}, {2, -6}, {2, -3}, {-2, -3}}};
    d.outline("wall", wall, true);
  });
  const Pixels png(drawn().render(PictureFormat::png));
  EXPECT_NE(png.at_world(0, -4.5, 10), no_ink);
  EXPECT_EQ(png.at_world(0, -2, 10), no_ink);
}

TEST_F(PictureOfAWorld, DrawsOpenOutlinesAsLinesOnly) {
  add([](Declare& d) {
    const std::array<Point, 3> fence{{{-2, -6}, {2, -6}, {2, -3}}};
    d.outline("fence", fence, false);
  });
  const Pixels png(drawn().render(PictureFormat::png));
  EXPECT_NE(png.at_world(0, -6, 10), no_ink);
  EXPECT_NE(png.at_world(2, -4.5, 10), no_ink);
  // Neither its inside nor the way back to its beginning.
  EXPECT_EQ(png.at_world(1, -5, 10), no_ink);
  EXPECT_EQ(png.at_world(0, -4.5, 10), no_ink);
}

TEST_F(PictureOfAWorld, DrawsRowsOfTablesWithPositions) {
  Id table = no_id;
  add([&](Declare& d) {
    const std::array<std::string_view, 3> columns{"age", "x", "y"};
    table = d.table("motes", columns);
  });
  act = [&](World& w) {
    w.table(table).resize(1);
    w.table(table).column(1)[0] = 3;
    w.table(table).column(2)[0] = -5;
  };
  const Pixels png(drawn().render(PictureFormat::png));
  EXPECT_EQ(png.at_world(3, -5, 10), vermillion);
  EXPECT_EQ(png.at_world(-3, -5, 10), no_ink);
}

TEST_F(PictureOfAWorld, ShadesTheGridByItsContentInsideTheWorldOnly) {
  add([](Declare& d) {
    (void)d.grid("poison", {.columns = 2, .rows = 2, .side = 10, .left = -10, .bottom = -10});
  });
  Picture picture = [&] {
    bench.start_with({{.id = 0, .x = -5, .y = 0}});
    bench.steps(1);
    bench.world().grids[0] = {0, 4, 2, 0};  // lower right is full, upper left half full
    Picture p({.steps = {0}, .grid = "field.poison", .whole_world = true, .width = 800});
    p.observe(bench.simulation());
    return p;
  }();
  const Pixels png(picture.render(PictureFormat::png));
  EXPECT_EQ(png.at_world(-3, -3, 10), no_ink);
  EXPECT_EQ(png.at_world(3, 3, 10), no_ink);
  EXPECT_LT(png.at_world(3, -3, 10), png.at_world(-3, 3, 10));
  EXPECT_LT(png.at_world(-3, 3, 10), no_ink);
  EXPECT_EQ(png.at_world(9.5, -9.5, 10), no_ink);
}

TEST_F(PictureOfAWorld, FitsTheOrganismUnlessToldOtherwise) {
  const Picture near = drawn({.steps = {0}, .width = 800}), far = drawn();
  const Pixels a(near.render(PictureFormat::png)), b(far.render(PictureFormat::png));
  EXPECT_GT(a.count(orange), b.count(orange));
}

TEST_F(PictureOfAWorld, IsTheSameBytesTwiceInEveryFormat) {
  const Picture picture = drawn();
  for (const PictureFormat f : {PictureFormat::svg, PictureFormat::pdf, PictureFormat::png})
    EXPECT_TRUE(picture.render(f) == picture.render(f)) << static_cast<int>(f);
}

// Every element that opens closes, in order.
TEST_F(PictureOfAWorld, IsWellFormedAsSvg) {
  const std::string svg = drawn().render(PictureFormat::svg);
  std::vector<std::string> open;
  std::size_t elements = 0;
  for (std::size_t at = svg.find('<'); at != std::string::npos; at = svg.find('<', at + 1)) {
    const std::size_t end = svg.find('>', at);
    ASSERT_NE(end, std::string::npos);
    if (svg[at + 1] == '?') continue;
    ++elements;
    const std::size_t from = svg[at + 1] == '/' ? at + 2 : at + 1;
    const std::string name = svg.substr(from, svg.find_first_of(" \n/>", from) - from);
    if (svg[at + 1] == '/') {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), name);
      open.pop_back();
    } else if (svg[end - 1] != '/') {
      open.push_back(name);
    }
  }
  EXPECT_TRUE(open.empty());
  EXPECT_GT(elements, 20u);
}

TEST_F(PictureOfAWorld, HasAPanelForEachChosenStep) {
  bench.start_with({{.id = 0}});
  Picture picture({.steps = {3, 1, 3}, .width = 400});
  for (int i = 0; i < 4; ++i) {
    bench.steps(1);
    picture.observe(bench.simulation());
  }
  ASSERT_EQ(picture.panels().size(), 2u);
  EXPECT_EQ(picture.panels()[0].step, 1u);
  EXPECT_EQ(picture.panels()[1].step, 3u);
  EXPECT_EQ(Pixels(picture.render(PictureFormat::png)).width(), 400);
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

TEST_F(PictureOfAWorld, SaysWhyItCannotBeDrawn) {
  EXPECT_THAT(refusal([] { (void)picture_format("a.gif"); }), HasSubstr(".svg, .pdf or .png"));
  EXPECT_THAT(refusal([] { Picture({.steps = {1, 2}, .width = 199}); }), HasSubstr("at least 200"));
  EXPECT_THAT(refusal([&] { (void)drawn({.steps = {7}}).render(PictureFormat::png); }),
              HasSubstr("step 7 is beyond the life; its last step is 0"));
  add([](Declare& d) { (void)d.grid("poison", {.columns = 1, .rows = 1}); });
  EXPECT_THAT(refusal([&] { (void)drawn({.steps = {0}, .grid = "field.poisn"}); }),
              AllOf(HasSubstr("no grid 'field.poisn'"), HasSubstr("grids: field.poison")));
}

}  // namespace
}  // namespace somas::report
