#include "plugins/environments/walls/walls.hpp"

#include <cmath>
#include <functional>

#include <gmock/gmock.h>

#include "tests/plugins/environments/fake_world.hpp"

namespace somas::environments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

using Entry = Walls::Entry;

Entry disc(double x, double y, double radius) {
  return {.kind = "disc", .x = x, .y = y, .radius = radius};
}
Entry rectangle(const char* kind, double x, double y, double half_width, double half_height) {
  return {.kind = kind, .x = x, .y = y, .half_width = half_width, .half_height = half_height};
}
Entry gap_wall(double x, double thickness, double gap_y, double gap_width, double half_height) {
  return {.kind = "gap_wall",
          .x = x,
          .half_height = half_height,
          .thickness = thickness,
          .gap_y = gap_y,
          .gap_width = gap_width};
}

Walls::Parameters walls_of(std::vector<Entry> obstacles, double stiffness = 20,
                           double damping = 0) {
  return {.obstacles = std::move(obstacles), .stiffness = stiffness, .damping = damping};
}

struct Force {
  double x, y;
  bool operator==(const Force&) const = default;
};

/// What walls do to one cell, in one substep.
Force force_on(const FakeCell& cell, const Walls::Parameters& parameters) {
  Stage<Walls> stage(parameters, 1, {cell});
  stage.step(0);
  return {stage.world.force_x()[0], stage.world.force_y()[0]};
}

/// The path of a cell of mass m in the direction x under walls and a constant force, by
/// semi-implicit Euler as the mechanics have it, without drag. Calls visit(time, x, vx) after each
/// substep.
FakeCell moved(FakeCell cell, const Walls::Parameters& parameters, double mass, double constant,
               double h, int substeps,
               const std::function<void(double, double, double)>& visit = {}) {
  Stage<Walls> stage(parameters);
  for (int s = 0; s < substeps; ++s) {
    stage.world.place({cell});
    stage.environment.act(Phase::forces, stage.world);
    cell.vx += h * (stage.world.force_x()[0] + constant) / mass;
    cell.vy += h * stage.world.force_y()[0] / mass;
    cell.x += h * cell.vx;
    cell.y += h * cell.vy;
    if (visit) visit((s + 1) * h, cell.x, cell.vx);
  }
  return cell;
}

TEST(Walls, HaveTheParametersThatExperimentsName) {
  EXPECT_THAT(parameter_names<Walls::Parameters>(),
              ElementsAre("obstacles", "stiffness", "damping", "lightest_mass"));
  EXPECT_THAT(parameter_names<Entry>(),
              ElementsAre("kind", "x", "y", "radius", "half_width", "half_height", "thickness",
                          "gap_y", "gap_width"));
}

TEST(Walls, ActOnForcesOnly) {
  Stage<Walls> stage(walls_of({disc(0, 0, 1)}));
  EXPECT_THAT(stage.declared.phases, ElementsAre(Phase::forces));
}

TEST(Walls, PushInProportionToDepthAndApproach) {
  // 0.5 deep in the left face of a box, coming in at 2 and sliding up at 7.
  const Walls::Parameters p = walls_of({rectangle("box", 5, 0, 1, 4)}, 20, 3);
  EXPECT_EQ(force_on({.x = 3.5, .vx = 2, .vy = 7}, p), (Force{-20 * 0.5 - 3 * 2, 0}));
}

TEST(Walls, DoNothingToCellsThatOnlyTouch) {
  EXPECT_EQ(force_on({.x = 3, .vx = 5}, walls_of({rectangle("box", 5, 0, 1, 4)}, 20, 3)),
            (Force{0, 0}));
  EXPECT_EQ(force_on({.x = 3, .vx = 5}, walls_of({disc(5, 0, 1)}, 20, 3)), (Force{0, 0}));
  EXPECT_EQ(force_on({.x = 3, .vx = 5}, walls_of({rectangle("enclosure", 0, 0, 4, 4)}, 20, 3)),
            (Force{0, 0}));
}

TEST(Walls, HoldBackACellThatLeavesFasterThanItsSpringPushes) {
  const Walls::Parameters p = walls_of({rectangle("box", 5, 0, 1, 4)}, 20, 3);
  // Out of the left face at speed 5: the damper's 15 exceed the spring's 10.
  EXPECT_EQ(force_on({.x = 3.5, .vx = -5}, p), (Force{-10 + 15, 0}));
}

TEST(Walls, ReckonWithTheRadiusOfTheMoment) {
  const Walls::Parameters p = walls_of({rectangle("box", 5, 0, 1, 4)});
  EXPECT_EQ(force_on({.x = 3.5, .radius = 0.5}, p), (Force{0, 0}));
  EXPECT_EQ(force_on({.x = 3.5, .radius = 0.75}, p), (Force{-20 * 0.25, 0}));
}

TEST(Walls, DiscsPushAwayFromTheirCentre) {
  // (3, 4) away from the centre: 5 of 6 apart.
  const Force f = force_on({.x = 13, .y = 4}, walls_of({disc(10, 0, 5)}));
  EXPECT_DOUBLE_EQ(f.x, 20 * 0.6);
  EXPECT_DOUBLE_EQ(f.y, 20 * 0.8);
}

TEST(Walls, CornersOfABoxPushAlongTheDiagonal) {
  // The corner is at (1, 1); the cell half a length beyond it on both axes.
  const Force f = force_on({.x = 1.5, .y = 1.5}, walls_of({rectangle("box", 0, 0, 1, 1)}));
  EXPECT_EQ(f.x, f.y);
  EXPECT_DOUBLE_EQ(std::hypot(f.x, f.y), 20 * (1 - std::sqrt(0.5)));
  // A disc that overlaps the corner's square, but not the corner itself.
  EXPECT_EQ(force_on({.x = 1.8, .y = 1.8}, walls_of({rectangle("box", 0, 0, 1, 1)})),
            (Force{0, 0}));
}

TEST(Walls, PushOutACentreInsideByTheNearestFace) {
  const Walls::Parameters p = walls_of({rectangle("box", 0, 0, 3, 2)});
  EXPECT_EQ(force_on({.x = 2.5, .y = 0}, p), (Force{20 * 1.5, 0}));
  EXPECT_EQ(force_on({.x = -2.5, .y = 0}, p), (Force{-20 * 1.5, 0}));
  EXPECT_EQ(force_on({.x = 0, .y = 1.75}, p), (Force{0, 20 * 1.25}));
  EXPECT_EQ(force_on({.x = 0, .y = -1.75}, p), (Force{0, -20 * 1.25}));
}

TEST(Walls, PushGrowsWithoutAJumpWhenTheCentreGoesIn) {
  const Walls::Parameters p = walls_of({rectangle("box", 0, 0, 3, 2)});
  EXPECT_NEAR(force_on({.x = 3 + 1e-9}, p).x, force_on({.x = 3 - 1e-9}, p).x, 1e-6);
  EXPECT_EQ(force_on({.x = 3}, p), (Force{20, 0}));
}

TEST(Walls, TiesHaveOneWayOut) {
  EXPECT_EQ(force_on({}, walls_of({disc(0, 0, 2)})), (Force{20 * 3, 0}));
  EXPECT_EQ(force_on({}, walls_of({rectangle("box", 0, 0, 2, 2)})), (Force{20 * 3, 0}));
  EXPECT_EQ(force_on({}, walls_of({rectangle("box", 0, 0, 3, 2)})), (Force{0, 20 * 3}));
  EXPECT_EQ(force_on({.x = -1, .y = 1}, walls_of({rectangle("box", 0, 0, 2, 2)})),
            (Force{-20 * 2, 0}));
}

TEST(Walls, EnclosuresPushInwardsByEachFace) {
  const Walls::Parameters p = walls_of({rectangle("enclosure", 1, 2, 10, 5)});
  EXPECT_EQ(force_on({.x = 1, .y = 2}, p), (Force{0, 0}));
  EXPECT_EQ(force_on({.x = 10.5, .y = 2}, p), (Force{-20 * 0.5, 0}));
  EXPECT_EQ(force_on({.x = 10.5, .y = -2.75}, p), (Force{-20 * 0.5, 20 * 0.75}));
  // Also from beyond.
  EXPECT_EQ(force_on({.x = -12, .y = 2}, p), (Force{20 * 4, 0}));
}

TEST(Walls, GapWallsAreTwoBoxesWithAGapBetween) {
  const Entry entry = gap_wall(8, 2, 1, 3, 10);
  Stage<Walls> stage(walls_of({entry}));
  ASSERT_EQ(stage.declared.outlines.size(), 2u);
  const auto corners = [&](std::size_t i) {
    const std::vector<Point>& p = stage.declared.outlines[i].points;
    return std::vector<double>{p[0].x, p[0].y, p[2].x, p[2].y};
  };
  EXPECT_THAT(corners(0), ElementsAre(7, -10, 9, -0.5));
  EXPECT_THAT(corners(1), ElementsAre(7, 2.5, 9, 10));
  EXPECT_EQ(force_on({.x = 8, .y = 1}, walls_of({entry})), (Force{0, 0}));
  EXPECT_EQ(force_on({.x = 6.5, .y = 5}, walls_of({entry})), (Force{-20 * 0.5, 0}));
}

// Pictures shade the inside of closed outlines, which is where the cells of an enclosure live.
TEST(Walls, EnclosuresAreDrawnAsALineAndSolidShapesAsAreas) {
  Stage<Walls> stage(walls_of({rectangle("enclosure", 1, 2, 10, 5), rectangle("box", 5, 0, 1, 4)}));
  ASSERT_EQ(stage.declared.outlines.size(), 2u);
  const auto& enclosure = stage.declared.outlines[0];
  EXPECT_FALSE(enclosure.closed);
  ASSERT_EQ(enclosure.points.size(), 5u);
  EXPECT_EQ(enclosure.points.front().x, enclosure.points.back().x);
  EXPECT_EQ(enclosure.points.front().y, enclosure.points.back().y);
  EXPECT_EQ(enclosure.points[2].x, 11);
  EXPECT_EQ(enclosure.points[2].y, 7);
  EXPECT_TRUE(stage.declared.outlines[1].closed);
}

TEST(Walls, ForcesOfSeveralObstaclesAddUp) {
  const Walls::Parameters both =
      walls_of({rectangle("box", 5, 0, 1, 4), rectangle("box", 3.5, -2, 4, 1.5)});
  EXPECT_EQ(force_on({.x = 3.5, .y = 0}, both), (Force{-20 * 0.5, 20 * 0.5}));
}

// ---- motion ------------------------------------------------------------------------------------

TEST(Walls, StopACellThatDriftsAgainstThemAsADampedOscillator) {
  const double mass = 1.5, stiffness = 20, damping = 2, speed = 1, h = 1e-4;
  const Walls::Parameters p = walls_of({rectangle("box", 5, 0, 1, 4)}, stiffness, damping);
  // With u the depth and u(0) = 0: u = v / w exp(-c t / 2m) sin(w t), w^2 = k/m - (c/2m)^2.
  const double decay = damping / (2 * mass);
  const double frequency = std::sqrt(stiffness / mass - decay * decay);
  const double end = M_PI / frequency;
  double worst = 0, deepest = 0;
  const FakeCell last = moved({.x = 3, .vx = speed}, p, mass, 0, h, static_cast<int>(end / h),
                              [&](double t, double x, double) {
                                const double depth = speed / frequency * std::exp(-decay * t) *
                                                     std::sin(frequency * t);
                                worst = std::max(worst, std::abs(x - 3 - depth));
                                deepest = std::max(deepest, depth);
                              });
  EXPECT_GT(deepest, 0.2);
  EXPECT_LT(worst, 2 * h);
  EXPECT_NEAR(last.vx, -speed * std::exp(-decay * end), 10 * h);
}

TEST(Walls, ReverseMomentumWithoutLossWithoutADamper) {
  const double mass = 2, h = 1e-4;
  for (const Entry& obstacle :
       {rectangle("box", 5, 0, 1, 4), disc(6, 0, 2), rectangle("enclosure", 0, 0, 4, 4)}) {
    const FakeCell last =
        moved({.x = 2.9, .vx = 1}, walls_of({obstacle}), mass, 0, h, static_cast<int>(2 / h));
    EXPECT_LT(last.x, 3) << obstacle.kind;
    EXPECT_NEAR(last.vx, -1, 10 * h) << obstacle.kind;
    EXPECT_EQ(last.vy, 0) << obstacle.kind;
  }
}

TEST(Walls, ErrorOfAReboundIsOfTheFirstOrderInTheSubstep) {
  const auto lost = [](double h) {
    return std::abs(1 + moved({.x = 2.95, .vx = 1}, walls_of({rectangle("box", 5, 0, 1, 4)}), 1, 0,
                              h, static_cast<int>(2 / h))
                            .vx);
  };
  for (const double h : {1e-2, 1e-3, 1e-4}) EXPECT_LT(lost(h), 5 * h) << h;
}

TEST(Walls, ACellPressedByAForceRestsAtForceOverStiffness) {
  const Walls::Parameters p = walls_of({rectangle("box", 5, 0, 1, 4)}, 20, 5);
  const FakeCell last = moved({.x = 2.5}, p, 1, 4, 1.0 / 30, 3000);
  EXPECT_NEAR(last.x, 3 + 4.0 / 20, 1e-12);
  EXPECT_NEAR(last.vx, 0, 1e-12);
}

TEST(Walls, SlidingAlongAFlatWallIsFree) {
  const FakeCell last = moved(
      {.x = 3.2, .vy = 0.5}, walls_of({rectangle("box", 5, 0, 1, 40)}, 20, 5), 1, 0, 1.0 / 30, 300);
  EXPECT_EQ(last.vy, 0.5);
}

TEST(Walls, MirroredScenesHaveMirroredForcesBitForBit) {
  const auto scene = [](double sx, double sy) {
    return walls_of({disc(sx * 3.1, sy * 2.3, 1.7), rectangle("box", sx * -2.2, sy * 0.7, 1.3, 0.9),
                     rectangle("enclosure", sx * 0.4, sy * -0.3, 4.1, 3.3)},
                    17.3, 2.9);
  };
  Rng rng(1, 2, 3, 4, 5);
  const auto within = [&](double reach) { return reach * (2 * rng.uniform() - 1); };
  int pushed = 0;
  for (int n = 0; n < 500; ++n) {
    const FakeCell cell{.x = within(6),
                        .y = within(5),
                        .radius = 0.5 + rng.uniform(),
                        .vx = within(1),
                        .vy = within(1)};
    const Force f = force_on(cell, scene(1, 1));
    pushed += f == Force{0, 0} ? 0 : 1;
    for (const auto& [sx, sy] : {std::pair{-1.0, 1.0}, {1.0, -1.0}, {-1.0, -1.0}}) {
      FakeCell mirrored = cell;
      mirrored.x *= sx, mirrored.vx *= sx, mirrored.y *= sy, mirrored.vy *= sy;
      EXPECT_EQ(force_on(mirrored, scene(sx, sy)), (Force{sx * f.x, sy * f.y}));
    }
  }
  EXPECT_GT(pushed, 100);
}

// ---- pictures ----------------------------------------------------------------------------------

TEST(Walls, OutlineSolidShapesAsClosedPolygons) {
  Stage<Walls> stage(walls_of({disc(1, 2, 3), rectangle("box", 5, 0, 1, 4),
                               rectangle("enclosure", 0, 0, 10, 8), gap_wall(0, 1, 0, 2, 5)}));
  const auto& outlines = stage.declared.outlines;
  std::vector<std::string> names;
  for (const auto& outline : outlines) {
    names.push_back(outline.name);
    EXPECT_EQ(outline.closed, outline.name != "enclosure");
  }
  EXPECT_THAT(names, ElementsAre("disc", "box", "enclosure", "box", "box"));
  ASSERT_EQ(outlines[0].points.size(), 32u);
  double area = 0;
  for (std::size_t i = 0; i < 32; ++i) {
    const Point &a = outlines[0].points[i], &b = outlines[0].points[(i + 1) % 32];
    EXPECT_NEAR(std::hypot(a.x - 1, a.y - 2), 3, 1e-12);
    area += 0.5 * ((a.x - 1) * (b.y - 2) - (b.x - 1) * (a.y - 2));
  }
  EXPECT_NEAR(area, 16 * 9 * std::sin(2 * M_PI / 32), 1e-9);
  ASSERT_EQ(outlines[1].points.size(), 4u);
  EXPECT_EQ(outlines[1].points[0].x, 4);
  EXPECT_EQ(outlines[1].points[2].y, 4);
}

// ---- parameters --------------------------------------------------------------------------------

std::pair<std::string, std::string> refused(const Walls::Parameters& parameters) {
  return refusal([&] { Stage<Walls> stage(parameters); });
}

TEST(Walls, RefuseKeysThatDoNotFitTheKind) {
  const auto second = [](Entry entry) {
    return refused(walls_of({disc(0, 0, 1), std::move(entry)}));
  };
  EXPECT_THAT(second({.kind = "disc", .x = 1, .y = 1}),
              Pair("obstacles[1].radius", "kind 'disc' needs 'radius'"));
  EXPECT_THAT(second({.kind = "box", .x = 1, .half_width = 1, .half_height = 1}),
              Pair("obstacles[1].y", "kind 'box' needs 'y'"));
  EXPECT_THAT(second({.kind = "enclosure", .x = 1, .y = 1, .half_width = 1}),
              Pair("obstacles[1].half_height", "kind 'enclosure' needs 'half_height'"));
  Entry box = rectangle("box", 0, 0, 1, 1);
  box.radius = 1;
  EXPECT_THAT(second(box), Pair("obstacles[1].radius", "kind 'box' has no 'radius'"));
  Entry gap = gap_wall(0, 1, 0, 1, 5);
  gap.y = 0;
  EXPECT_THAT(second(gap), Pair("obstacles[1].y", "kind 'gap_wall' has no 'y'"));
  gap = gap_wall(0, 1, 0, 1, 5);
  gap.gap_width.reset();
  EXPECT_THAT(second(gap), Pair("obstacles[1].gap_width", "kind 'gap_wall' needs 'gap_width'"));
  EXPECT_THAT(second(disc(std::numeric_limits<double>::infinity(), 0, 1)),
              Pair("obstacles[1].x", "must be finite"));
}

TEST(Walls, RefuseAGapThatIsNotWithinTheWall) {
  EXPECT_THAT(
      refused(walls_of({gap_wall(0, 1, 4, 2, 5)})),
      Pair("obstacles[0].gap_width", "the gap, from 3 to 5, must lie within the wall, -5 to 5"));
  EXPECT_THAT(refused(walls_of({gap_wall(0, 1, -4, 3, 5)})).first, "obstacles[0].gap_width");
  EXPECT_EQ(refused(walls_of({gap_wall(0, 1, 3.9, 2, 5)})).second, "no refusal");
}

TEST(Walls, RefuseContactsThatTheSubstepCannotBear) {
  // The stage's substep is 1/30: without a damper k may be 2 m / h^2 = 1800 m.
  EXPECT_EQ(refused(walls_of({}, 1799)).second, "no refusal");
  EXPECT_THAT(refused(walls_of({}, 1801)),
              Pair("stiffness", HasSubstr("up to a substep of 0.0333")));
  Walls::Parameters light = walls_of({}, 1799);
  light.lightest_mass = 0.5;
  EXPECT_THAT(refused(light), Pair("stiffness", HasSubstr("cells of mass 0.5 are stable")));
  // Next to no spring: c h <= m.
  EXPECT_EQ(refused(walls_of({}, 1e-9, 29.9)).second, "no refusal");
  EXPECT_EQ(refused(walls_of({}, 1e-9, 30.1)).first, "stiffness");
}

TEST(Walls, LimitOfTheSubstepLeavesHalfOfWhatALoneCellBears) {
  for (const auto& [k, c, m] : {std::tuple{20.0, 3.0, 1.0}, {500.0, 0.0, 2.0}, {1.0, 9.0, 0.3}}) {
    const double h = stable_contact_time_step(k, c, m);
    EXPECT_NEAR(k * h * h + 2 * c * h, 2 * m, 1e-12);
  }
}

TEST(Walls, LimitHoldsForTwoContactsOfACellThatIsNotLighterThanSaid) {
  // An enclosure narrower than the cell holds it between two springs: 2 k.
  const auto greatest = [](double mass) {
    double most = 0;
    moved({.x = 1e-3, .radius = 2}, walls_of({rectangle("enclosure", 0, 0, 1, 50)}, 1790), mass, 0,
          1.0 / 30, 400, [&](double, double x, double) { most = std::max(most, std::abs(x)); });
    return most;
  };
  EXPECT_LT(greatest(1), 0.1);
  EXPECT_GT(greatest(0.9), 1);
}

}  // namespace
}  // namespace somas::environments
