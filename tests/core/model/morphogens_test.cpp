// Section 1 of the model: sweeps, sensing and deposits.
#include "core/model/morphogens.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Concentrations in double, row-major; the oracle's own.
struct Field {
  int size;
  std::vector<double> at;

  explicit Field(int n) : size(n), at(static_cast<std::size_t>(n * n)) {}
  double& operator()(int c, int r) { return at[static_cast<std::size_t>(r * size + c)]; }
  double operator()(int c, int r) const { return at[static_cast<std::size_t>(r * size + c)]; }
};

/// The rule as written: evaporate everything, then keep the maximum of oneself and the neighbours'
/// offers C (1 - R d), then forget what is negligible.
Field swept(const Field& field, double attenuation, double evaporation) {
  Field before = field;
  for (double& value : before.at) value *= 1 - evaporation;
  Field after(field.size);
  for (int r = 0; r < field.size; ++r)
    for (int c = 0; c < field.size; ++c) {
      double best = before(c, r);
      for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc) {
          const int cc = c + dc, rr = r + dr;
          if ((dc == 0 && dr == 0) || cc < 0 || rr < 0 || cc >= field.size || rr >= field.size)
            continue;
          const double distance = std::sqrt(double(dc * dc + dr * dr));
          best = std::max(best, before(cc, rr) * std::max(0.0, 1 - attenuation * distance));
        }
      after(c, r) = best < 1e-6 ? 0 : best;
    }
  return after;
}

MorphogenGrid grid_of(std::uint32_t size, double attenuation, double evaporation, double side = 2) {
  return {.size = size, .side = side, .kinds = {{attenuation, evaporation}}};
}

std::uint32_t u(int i) { return static_cast<std::uint32_t>(i); }

void load(MorphogenFields& fields, const Field& field, std::size_t kind = 0) {
  for (int r = 0; r < field.size; ++r)
    for (int c = 0; c < field.size; ++c)
      if (field(c, r) != 0) fields.set(kind, u(c), u(r), static_cast<float>(field(c, r)));
}

/// Concentrations between 0.01 and 1 on some of the squares.
Field random_field(int size, double density, Dice& dice) {
  Field field(size);
  for (double& value : field.at)
    if (dice.uniform(0, 1) < density) value = static_cast<float>(dice.uniform(0.01, 1));
  return field;
}

// ---- sweeps -------------------------------------------------------------------------------------

TEST(MorphogenSweep, EqualsTheRuleWrittenOutOnRandomFields) {
  Dice dice(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int size = 1 + static_cast<int>(dice.below(21));
    const double attenuation = dice.uniform(0, 1), evaporation = dice.uniform(0, 0.3);
    const double density = trial % 3 == 0 ? 1.0 : trial % 3 == 1 ? 0.2 : 0.01;
    Field oracle = random_field(size, density, dice);
    const MorphogenGrid grid = grid_of(u(size), attenuation, evaporation);
    MorphogenFields fields(grid);
    load(fields, oracle);
    for (int sweep = 0; sweep < 6; ++sweep) {
      fields.evaporate_and_spread(grid);
      oracle = swept(oracle, attenuation, evaporation);
      for (int r = 0; r < size; ++r)
        for (int c = 0; c < size; ++c) {
          const double value = fields.value(0, u(c), u(r));
          // A float that lands on the other side of the threshold may differ by the threshold.
          if (oracle(c, r) < 1.1e-6 && value < 1.1e-6) continue;
          ASSERT_NEAR(value, oracle(c, r), 2e-6 * oracle(c, r)) << c << ' ' << r;
        }
    }
  }
}

TEST(MorphogenSweep, EachKindFollowsItsOwnAttenuationAndEvaporation) {
  MorphogenGrid grid{.size = 9, .side = 2, .kinds = {{0.1, 0.2}, {0.5, 0.0}, {0.0, 0.5}}};
  MorphogenFields fields(grid);
  for (std::size_t kind = 0; kind < 3; ++kind) fields.set(kind, 4, 4, 1);
  fields.evaporate_and_spread(grid);
  const std::array<double, 3> self{0.8, 1.0, 0.5};
  const std::array<double, 3> beside{0.8 * 0.9, 0.5, 0.5};
  const std::array<double, 3> diagonal{0.8 * (1 - 0.1 * std::sqrt(2.0)), 1 - 0.5 * std::sqrt(2.0),
                                       0.5};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    EXPECT_NEAR(fields.value(kind, 4, 4), self[kind], 1e-6);
    EXPECT_NEAR(fields.value(kind, 5, 4), beside[kind], 1e-6);
    EXPECT_NEAR(fields.value(kind, 4, 3), beside[kind], 1e-6);
    EXPECT_NEAR(fields.value(kind, 3, 3), diagonal[kind], 1e-6);
    EXPECT_EQ(fields.value(kind, 6, 4), 0) << "one sweep reaches one square";
  }
}

TEST(MorphogenSweep, SteadySourceFallsGeometricallyAlongAnAxis) {
  const double attenuation = 0.13, evaporation = 0.07, source = 0.8;
  const MorphogenGrid grid = grid_of(41, attenuation, evaporation);
  MorphogenFields fields(grid);
  for (int sweep = 0; sweep < 60; ++sweep) {
    fields.set(0, 20, 20, static_cast<float>(source));
    fields.evaporate_and_spread(grid);
  }
  for (int n = 1; n <= 20; ++n) {
    const double expected = source * std::pow((1 - attenuation) * (1 - evaporation), n);
    EXPECT_NEAR(fields.value(0, u(20 + n), 20), expected, 1e-5 * expected) << n;
    EXPECT_NEAR(fields.value(0, 20, u(20 - n)), expected, 1e-5 * expected) << n;
  }
}

TEST(MorphogenSweep, AbandonedFieldEvaporatesEverywhereAtOneRate) {
  // A flat field offers nobody anything: what is left is evaporation, as in k steps C0 (1 - E)^k.
  const MorphogenGrid grid = grid_of(7, 0.3, 0.1);
  MorphogenFields fields(grid);
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c < 7; ++c) fields.set(0, u(c), u(r), 0.5f);
  for (int k = 1; k <= 30; ++k) {
    fields.evaporate_and_spread(grid);
    const double expected = 0.5 * std::pow(0.9, k);
    EXPECT_NEAR(fields.value(0, 3, 3), expected, 1e-5 * expected);
    EXPECT_NEAR(fields.value(0, 0, 6), expected, 1e-5 * expected);
  }
}

TEST(MorphogenSweep, DefaultKindsHalveOverTheirStatedDistances) {
  const MorphogenGrid grid;
  ASSERT_EQ(grid.size, 65u);
  ASSERT_EQ(grid.side, 2);
  ASSERT_EQ(grid.kinds.size(), 3u);
  MorphogenFields fields(grid);
  for (int sweep = 0; sweep < 120; ++sweep) {
    for (std::size_t kind = 0; kind < 3; ++kind) fields.set(kind, 32, 32, 1);
    fields.evaporate_and_spread(grid);
  }
  for (std::size_t kind = 0; kind < 3; ++kind) fields.set(kind, 32, 32, 1);
  const std::array<double, 3> stated{13.5, 8.8, 4.2};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    int n = 0;
    while (fields.value(kind, u(32 + n + 1), 32) > 0.5f) ++n;
    const double near = fields.value(kind, u(32 + n), 32);
    const double far = fields.value(kind, u(32 + n + 1), 32);
    const double squares = n + std::log(near / 0.5) / std::log(near / far);
    EXPECT_NEAR(squares * grid.side, stated[kind], 0.05) << kind;
  }
}

TEST(MorphogenSweep, TwoEqualSourcesReadAsTheNearerOne) {
  const MorphogenGrid grid = grid_of(21, 0.1, 0.05);
  const auto settled = [&](std::vector<int> columns) {
    MorphogenFields fields(grid);
    for (int sweep = 0; sweep < 40; ++sweep) {
      for (const int c : columns) fields.set(0, u(c), 10, 1);
      fields.evaporate_and_spread(grid);
    }
    return fields;
  };
  const MorphogenFields left = settled({6}), right = settled({14}), both = settled({6, 14});
  for (int r = 0; r < 21; ++r)
    for (int c = 0; c < 21; ++c)
      EXPECT_EQ(both.value(0, u(c), u(r)),
                std::max(left.value(0, u(c), u(r)), right.value(0, u(c), u(r))));
  EXPECT_EQ(both.value(0, 10, 10), left.value(0, 10, 10)) << "half-way both read as one";
  EXPECT_GT(both.value(0, 10, 10), 0);
}

TEST(MorphogenSweep, TracesBelowAMillionthVanish) {
  const MorphogenGrid grid = grid_of(5, 0.5, 0);
  MorphogenFields fields(grid);
  fields.set(0, 2, 2, 1.9e-6f);
  fields.evaporate_and_spread(grid);
  EXPECT_NEAR(fields.value(0, 2, 2), 1.9e-6, 1e-12);
  EXPECT_EQ(fields.value(0, 3, 2), 0) << "0.95e-6 is nothing";
  fields.set(0, 2, 2, 2.2e-6f);
  fields.evaporate_and_spread(grid);
  EXPECT_NEAR(fields.value(0, 3, 2), 1.1e-6, 1e-12);
  EXPECT_EQ(fields.value(0, 3, 3), 0);
}

TEST(MorphogenSweep, CommutesWithTheEightSymmetriesOfTheGrid) {
  Dice dice(2);
  const int size = 11;
  for (int trial = 0; trial < 8; ++trial) {
    const MorphogenGrid grid = grid_of(u(size), dice.uniform(0, 0.8), dice.uniform(0, 0.2));
    const Field field = random_field(size, 0.15, dice);
    const auto image = [&](int symmetry, int c, int r) {
      if ((symmetry & 1) != 0) c = size - 1 - c;
      if ((symmetry & 2) != 0) r = size - 1 - r;
      return (symmetry & 4) != 0 ? std::pair(r, c) : std::pair(c, r);
    };
    MorphogenFields plain(grid);
    load(plain, field);
    for (int sweep = 0; sweep < 5; ++sweep) plain.evaporate_and_spread(grid);
    for (int symmetry = 1; symmetry < 8; ++symmetry) {
      Field moved(size);
      for (int r = 0; r < size; ++r)
        for (int c = 0; c < size; ++c) {
          const auto [cc, rr] = image(symmetry, c, r);
          moved(cc, rr) = field(c, r);
        }
      MorphogenFields turned(grid);
      load(turned, moved);
      for (int sweep = 0; sweep < 5; ++sweep) turned.evaporate_and_spread(grid);
      for (int r = 0; r < size; ++r)
        for (int c = 0; c < size; ++c) {
          const auto [cc, rr] = image(symmetry, c, r);
          ASSERT_EQ(turned.value(0, u(cc), u(rr)), plain.value(0, u(c), u(r))) << symmetry;
        }
    }
  }
}

TEST(MorphogenSweep, StrongAttenuationOffersNothingAcrossTheDiagonal) {
  const MorphogenGrid grid = grid_of(5, 1, 0);
  MorphogenFields fields(grid);
  fields.set(0, 2, 2, 1);
  for (int sweep = 0; sweep < 3; ++sweep) fields.evaporate_and_spread(grid);
  for (int r = 0; r < 5; ++r)
    for (int c = 0; c < 5; ++c)
      EXPECT_EQ(fields.value(0, u(c), u(r)), c == 2 && r == 2 ? 1.0f : 0.0f);

  const MorphogenGrid steep = grid_of(5, 0.8, 0);  // 1 - 0.8 sqrt 2 is negative
  MorphogenFields other(steep);
  other.set(0, 2, 2, 1);
  other.evaporate_and_spread(steep);
  EXPECT_NEAR(other.value(0, 3, 2), 0.2, 1e-6);
  EXPECT_EQ(other.value(0, 3, 3), 0);
}

TEST(MorphogenSweep, FullReachNeitherAttenuatesNorForgets) {
  const MorphogenGrid grid = grid_of(5, 0, 0);
  MorphogenFields fields(grid);
  fields.set(0, 0, 0, 0.25f);
  for (int sweep = 0; sweep < 4; ++sweep) fields.evaporate_and_spread(grid);
  for (int r = 0; r < 5; ++r)
    for (int c = 0; c < 5; ++c) EXPECT_EQ(fields.value(0, u(c), u(r)), 0.25f);
}

// ---- sensing and depositing ---------------------------------------------------------------------

/// Inverse distances to the centres of the 3x3 block round (x, y), by hand; 0 off the grid.
struct Block {
  std::array<int, 9> column, row;
  std::array<double, 9> weight;
  double sum = 0, greatest = 0;
};

Block block_round(double x, double y, int size, double side) {
  const double low = -0.5 * side * size;
  const int c = static_cast<int>(std::floor((x - low) / side));
  const int r = static_cast<int>(std::floor((y - low) / side));
  Block block{};
  for (std::size_t k = 0; k < 9; ++k) {
    block.column[k] = c + static_cast<int>(k % 3) - 1;
    block.row[k] = r + static_cast<int>(k / 3) - 1;
    if (block.column[k] < 0 || block.row[k] < 0 || block.column[k] >= size || block.row[k] >= size)
      continue;
    const double cx = low + (block.column[k] + 0.5) * side, cy = low + (block.row[k] + 0.5) * side;
    block.weight[k] = 1 / std::hypot(x - cx, y - cy);
    block.sum += block.weight[k];
    block.greatest = std::max(block.greatest, block.weight[k]);
  }
  return block;
}

TEST(MorphogenSensing, IsTheInverseDistanceWeightedMeanOfTheBlock) {
  Dice dice(3);
  const int size = 9;
  const double side = 1.5;
  const MorphogenGrid grid = grid_of(u(size), 0.1, 0.1, side);
  const double half = 0.5 * side * size;
  for (int trial = 0; trial < 400; ++trial) {
    const Field field = random_field(size, 1, dice);
    MorphogenFields fields(grid);
    load(fields, field);
    const double x = dice.uniform(-half, half), y = dice.uniform(-half, half);
    const Block block = block_round(x, y, size, side);
    double expected = 0;
    for (std::size_t k = 0; k < 9; ++k)
      if (block.weight[k] > 0) expected += block.weight[k] * field(block.column[k], block.row[k]);
    expected /= block.sum;
    EXPECT_NEAR(fields.sense(0, fields.footprint(x, y)), expected, 1e-5) << x << ' ' << y;
  }
}

TEST(MorphogenSensing, BySquareDistancesOnAPointWorkedOutByHand) {
  // Side 2, centre square round the origin; the point (1, 0) lies on its right edge and so belongs
  // to the next square, whose centre is (2, 0). Distances to (0, 0), (2, 0), (4, 0): 1, 1, 3; to
  // (0, +-2), (2, +-2): sqrt 5; to (4, +-2): sqrt 13.
  const MorphogenGrid grid = grid_of(9, 0, 0, 2);
  MorphogenFields fields(grid);
  fields.set(0, 4, 4, 1);  // the origin's square alone
  const double sum = 1 + 1 + 1.0 / 3 + 4 / std::sqrt(5.0) + 2 / std::sqrt(13.0);
  EXPECT_NEAR(fields.sense(0, fields.footprint(1, 0)), 1 / sum, 1e-6);
}

TEST(MorphogenSensing, AtACentreIsThatCentresValue) {
  const MorphogenGrid grid = grid_of(5, 0, 0, 2);
  MorphogenFields fields(grid);
  for (int c = 0; c < 5; ++c)
    for (int r = 0; r < 5; ++r) fields.set(0, u(c), u(r), static_cast<float>(0.1 * c + 0.02 * r));
  for (int c = 0; c < 5; ++c)
    for (int r = 0; r < 5; ++r)
      EXPECT_EQ(fields.sense(0, fields.footprint(fields.centre(u(c)), fields.centre(u(r)))),
                static_cast<float>(0.1 * c + 0.02 * r));
  EXPECT_EQ(fields.centre(2), 0) << "a square is centred on the origin";
  EXPECT_EQ(fields.centre(0), -4);
}

TEST(MorphogenSensing, LeavesOffGridCentresOutAtEdgesAndCorners) {
  const MorphogenGrid grid = grid_of(5, 0, 0, 2);
  MorphogenFields fields(grid);
  for (int c = 0; c < 5; ++c)
    for (int r = 0; r < 5; ++r) fields.set(0, u(c), u(r), 0.5f);
  // If missing centres counted as 0, a flat field would read less than itself.
  for (const double edge : {-4.9, -4.0, 4.3, 4.99})
    for (const double other : {-4.7, 0.3, 4.8}) {
      EXPECT_NEAR(fields.sense(0, fields.footprint(edge, other)), 0.5, 1e-6);
      EXPECT_NEAR(fields.sense(0, fields.footprint(other, edge)), 0.5, 1e-6);
    }
}

TEST(MorphogenSensing, OfManyPointsIsThatOfEachAlone) {
  Dice dice(31);
  for (int trial = 0; trial < 60; ++trial) {
    const int size = 5 + static_cast<int>(dice.below(30));
    const MorphogenGrid grid = grid_of(u(size), 0.1, 0.1, 2);
    MorphogenFields fields(grid);
    load(fields, random_field(size, 1, dice));
    // Inside, over the edges, at centres, off the grid, nowhere.
    std::vector<double> x, y;
    for (std::size_t i = 0, count = dice.below(100); i < count; ++i) {
      const double half = size + 4.0;
      x.push_back(dice.uniform(-half, half));
      y.push_back(dice.uniform(-half, half));
      if (dice.below(10) == 0) x.back() = fields.centre(u(size) / 2), y.back() = fields.centre(1);
      if (dice.below(30) == 0) x.back() = std::nan("");
      if (dice.below(30) == 0) y.back() = -std::numeric_limits<double>::infinity();
    }
    std::vector<Footprint> prints(x.size());
    std::vector<float> sensed(x.size());
    fields.survey(x, y, prints, {sensed.data(), 1, u(static_cast<int>(x.size())), x.size()});
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Footprint alone = fields.footprint(x[i], y[i]);
      EXPECT_EQ(prints[i].weight, alone.weight) << x[i] << ' ' << y[i];
      EXPECT_EQ(prints[i].column, alone.column);
      EXPECT_EQ(prints[i].row, alone.row);
      EXPECT_EQ(prints[i].sum, alone.sum);
      EXPECT_EQ(prints[i].peak, alone.peak);
      EXPECT_EQ(sensed[i], fields.sense(0, alone)) << x[i] << ' ' << y[i];
    }
  }
}

TEST(MorphogenGradient, OfALinearFieldIsExactEverywhereOnTheGrid) {
  Dice dice(8);
  for (int trial = 0; trial < 400; ++trial) {
    const int size = 2 + static_cast<int>(dice.below(9));
    const double side = trial % 2 == 0 ? 2 : 0.5;
    // Whole multiples of 1/4096 a square are exact in single precision.
    const double a = static_cast<double>(dice.below(41)) - 20;
    const double b = static_cast<double>(dice.below(41)) - 20;
    MorphogenFields fields(grid_of(u(size), 0, 0, side));
    for (int c = 0; c < size; ++c)
      for (int r = 0; r < size; ++r)
        fields.set(0, u(c), u(r), static_cast<float>(0.5 + (a * c + b * r) / 4096));
    const double half = 0.5 * side * size;
    const Gradient g = fields.gradient(0, dice.uniform(-half, half), dice.uniform(-half, half));
    EXPECT_NEAR(g.x, a / (4096 * side), 1e-15) << size;
    EXPECT_NEAR(g.y, b / (4096 * side), 1e-15) << size;
  }
}

TEST(MorphogenGradient, IsTheSlopeOfTheLeastSquaresPlane) {
  Dice dice(9);
  for (int trial = 0; trial < 400; ++trial) {
    const int size = 1 + static_cast<int>(dice.below(6));
    const double side = 1.5, half = 0.5 * side * size;
    const Field field = random_field(size, 0.8, dice);
    MorphogenFields fields(grid_of(u(size), 0, 0, side));
    load(fields, field);
    const double x = dice.uniform(-half, half), y = dice.uniform(-half, half);
    // Over a rectangle of squares the axes part: sum (x - mean) C / sum (x - mean)^2.
    const Block block = block_round(x, y, size, side);
    double n = 0, mean_c = 0, mean_r = 0, up_x = 0, up_y = 0, square_c = 0, square_r = 0;
    for (std::size_t k = 0; k < 9; ++k) {
      if (!(block.weight[k] > 0)) continue;
      ++n, mean_c += block.column[k], mean_r += block.row[k];
    }
    mean_c /= n, mean_r /= n;
    for (std::size_t k = 0; k < 9; ++k) {
      if (!(block.weight[k] > 0)) continue;
      const double c = block.column[k] - mean_c, r = block.row[k] - mean_r;
      up_x += c * field(block.column[k], block.row[k]), square_c += c * c;
      up_y += r * field(block.column[k], block.row[k]), square_r += r * r;
    }
    const Gradient g = fields.gradient(0, x, y);
    EXPECT_NEAR(g.x, square_c == 0 ? 0 : up_x / square_c / side, 1e-12) << size;
    EXPECT_NEAR(g.y, square_r == 0 ? 0 : up_y / square_r / side, 1e-12) << size;
  }
}

TEST(MorphogenGradient, PointsAtASourceFromAllSidesAlike) {
  // Its own square in the middle of the block weighs nothing.
  MorphogenFields fields(grid_of(9, 0, 0, 2));
  fields.set(0, 4, 4, 1);
  for (int dc = -1; dc <= 1; ++dc)
    for (int dr = -1; dr <= 1; ++dr) {
      const Gradient g = fields.gradient(0, 2.0 * dc + 0.3, 2.0 * dr - 0.7);
      EXPECT_NEAR(g.x, -dc / 12.0, 1e-15);
      EXPECT_NEAR(g.y, -dr / 12.0, 1e-15);
    }
}

TEST(MorphogenGradient, IsZeroOutsideTheGrid) {
  MorphogenFields fields(grid_of(5, 0, 0, 2));
  for (int c = 0; c < 5; ++c)
    for (int r = 0; r < 5; ++r) fields.set(0, u(c), u(r), static_cast<float>(0.1 * (c + r)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double far : {-7.1, 7.1, 1e300, nan}) {
    EXPECT_EQ(fields.gradient(0, far, 0).x, 0) << far;
    EXPECT_EQ(fields.gradient(0, far, 0).y, 0) << far;
    EXPECT_EQ(fields.gradient(0, 0, far).x, 0) << far;
    EXPECT_EQ(fields.gradient(0, 0, far).y, 0) << far;
  }
}

TEST(MorphogenSensing, IsZeroOutsideTheGrid) {
  const MorphogenGrid grid = grid_of(5, 0, 0, 2);
  MorphogenFields fields(grid);
  for (int c = 0; c < 5; ++c)
    for (int r = 0; r < 5; ++r) fields.set(0, u(c), u(r), 1);
  for (const double far : {-8.0, 8.0, 1e9, -1e300})
    for (const double near : {0.0, 8.0}) {
      EXPECT_EQ(fields.sense(0, fields.footprint(far, near)), 0);
      EXPECT_EQ(fields.sense(0, fields.footprint(near, far)), 0);
      MorphogenFields copy = fields;
      copy.deposit(0, copy.footprint(far, near), 5, Deposit::peak);
      for (int c = 0; c < 5; ++c)
        for (int r = 0; r < 5; ++r) EXPECT_EQ(copy.value(0, u(c), u(r)), 1);
    }
}

TEST(MorphogenDeposit, PeakGivesTheNearestCentreTheWholeProduction) {
  Dice dice(4);
  const int size = 7;
  const MorphogenGrid grid = grid_of(u(size), 0, 0, 2);
  for (int trial = 0; trial < 200; ++trial) {
    const double x = dice.uniform(-7, 7), y = dice.uniform(-7, 7), amount = dice.uniform(0.1, 1);
    MorphogenFields fields(grid);
    fields.deposit(0, fields.footprint(x, y), static_cast<float>(amount), Deposit::peak);
    const Block block = block_round(x, y, size, 2);
    Field expected(size);
    for (std::size_t k = 0; k < 9; ++k)
      if (block.weight[k] > 0)
        expected(block.column[k], block.row[k]) = amount * block.weight[k] / block.greatest;
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c)
        ASSERT_NEAR(fields.value(0, u(c), u(r)), expected(c, r), 1e-5 * amount);
  }
}

TEST(MorphogenDeposit, ShareSpreadsTheProductionByWeight) {
  Dice dice(5);
  const int size = 7;
  const MorphogenGrid grid = grid_of(u(size), 0, 0, 2);
  double nearest = 0;
  const int trials = 4000;
  for (int trial = 0; trial < trials; ++trial) {
    const double x = dice.uniform(-1, 1), y = dice.uniform(-1, 1);
    MorphogenFields fields(grid);
    fields.deposit(0, fields.footprint(x, y), 1, Deposit::share);
    const Block block = block_round(x, y, size, 2);
    double total = 0;
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) total += fields.value(0, u(c), u(r));
    ASSERT_NEAR(total, 1, 1e-5) << "all of the production, no more";
    ASSERT_NEAR(fields.value(0, 3, 3), block.weight[4] / block.sum, 1e-5);
    nearest += fields.value(0, 3, 3) / trials;
  }
  EXPECT_NEAR(nearest, 0.3, 0.05) << "the nearest centre gets about 0.3 of what peak gives it";
}

TEST(MorphogenDeposit, AtACentreTouchesThatSquareAlone) {
  const MorphogenGrid grid = grid_of(5, 0, 0, 2);
  for (const Deposit rule : {Deposit::peak, Deposit::share}) {
    MorphogenFields fields(grid);
    fields.deposit(0, fields.footprint(2, -2), 0.7f, rule);
    for (int r = 0; r < 5; ++r)
      for (int c = 0; c < 5; ++c)
        EXPECT_EQ(fields.value(0, u(c), u(r)), c == 3 && r == 1 ? 0.7f : 0.0f);
  }
}

TEST(MorphogenDeposit, KeepsTheMaximumOfOldAndNew) {
  const MorphogenGrid grid = grid_of(5, 0, 0, 2);
  for (const Deposit rule : {Deposit::peak, Deposit::share}) {
    MorphogenFields alone(grid), over(grid);
    const Footprint at = alone.footprint(0.4, -0.3);
    alone.deposit(0, at, 0.6f, rule);
    for (int c = 0; c < 5; ++c)
      for (int r = 0; r < 5; ++r) over.set(0, u(c), u(r), 0.1f);
    over.deposit(0, at, 0.6f, rule);
    over.deposit(0, at, 0.6f, rule);  // a second cell on the spot adds nothing
    bool some_kept = false, some_raised = false;
    for (int c = 0; c < 5; ++c)
      for (int r = 0; r < 5; ++r) {
        EXPECT_EQ(over.value(0, u(c), u(r)), std::max(0.1f, alone.value(0, u(c), u(r))));
        some_kept |= over.value(0, u(c), u(r)) == 0.1f;
        some_raised |= over.value(0, u(c), u(r)) > 0.1f;
      }
    EXPECT_TRUE(some_kept && some_raised);
  }
}

TEST(MorphogenDeposit, AtAnEdgeStaysOnTheGridAndSpreadsFromThere) {
  const int size = 5;
  const MorphogenGrid grid = grid_of(u(size), 0.2, 0.1, 2);
  for (const auto& [x, y] : {std::pair(-4.9, -4.9), std::pair(4.9, 0.1), std::pair(0.2, 4.9)}) {
    MorphogenFields fields(grid);
    fields.deposit(0, fields.footprint(x, y), 1, Deposit::peak);
    Field oracle(size);
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) oracle(c, r) = fields.value(0, u(c), u(r));
    for (int sweep = 0; sweep < 6; ++sweep) {
      fields.evaporate_and_spread(grid);
      oracle = swept(oracle, 0.2, 0.1);
    }
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) EXPECT_NEAR(fields.value(0, u(c), u(r)), oracle(c, r), 1e-6);
  }
}

// ---- within a running simulation ----------------------------------------------------------------

TEST(MorphogenStep, EvaporatesAndSpreadsOnceAStepBeforeCellsSense) {
  Bench bench;
  bench.free_living();
  bench.config.morphogens.kinds = {{0.1, 0.25}};
  std::vector<float> sensed;
  bench.script = [&](const Lane& lane) {
    sensed.push_back(lane.in("morphogen.0"));
    lane.out("morphogen.0", 0.8f);
  };
  bench.start();
  bench.steps(6);
  const MorphogenFields& fields = bench.world().organisms[0].fields;
  // The founder sits on a centre: it reads what it left there, one evaporation later.
  EXPECT_EQ(sensed[0], 0);
  for (std::size_t t = 1; t < 6; ++t) EXPECT_NEAR(sensed[t], 0.8 * 0.75, 1e-6) << t;
  // After deposit at step t the wave of step 0 stands t squares away.
  for (std::uint32_t n = 0; n <= 5; ++n)
    EXPECT_NEAR(fields.value(0, 32 + n, 32), 0.8 * std::pow(0.9 * 0.75, n), 1e-6) << n;
  EXPECT_EQ(fields.value(0, 38, 32), 0);
}

TEST(MorphogenStep, ProductionIsClampedToTheUnitInterval) {
  Bench bench;
  bench.free_living();
  bench.script = [&](const Lane& lane) {
    lane.out("morphogen.0", 7.5f);
    lane.out("morphogen.1", -2.0f);
    lane.out("morphogen.2", 0.25f);
  };
  bench.start();
  bench.steps(1);
  const MorphogenFields& fields = bench.world().organisms[0].fields;
  EXPECT_EQ(fields.value(0, 32, 32), 1.0f);
  EXPECT_EQ(fields.value(1, 32, 32), 0.0f);
  EXPECT_EQ(fields.value(2, 32, 32), 0.25f);
}

TEST(MorphogenStep, DepositRuleIsTheExperiments) {
  for (const Deposit rule : {Deposit::peak, Deposit::share}) {
    Bench bench;
    bench.free_living();
    bench.config.morphogens.deposit = rule;
    bench.founders = {{.key = 1, .x = 0.5, .y = 0.5}};
    bench.script = [&](const Lane& lane) { lane.out("morphogen.0", 1.0f); };
    bench.start();
    bench.steps(1);
    const Block block = block_round(0.5, 0.5, 65, 2);
    const double expected = rule == Deposit::peak ? 1.0 : block.greatest / block.sum;
    EXPECT_NEAR(bench.world().organisms[0].fields.value(0, 32, 32), expected, 1e-6);
  }
}

TEST(MorphogenStep, EveryOrganismHasFieldsOfItsOwn) {
  Bench bench;
  bench.free_living();
  bench.founders = {{.key = 1, .x = 0}, {.key = 2, .x = 10}};
  std::vector<float> sensed_by_second;
  bench.script = [&](const Lane& lane) {
    if (lane.organism() == 0) lane.out("morphogen.0", 1.0f);
    if (lane.organism() == 1) sensed_by_second.push_back(lane.in("morphogen.0"));
  };
  bench.start();
  bench.steps(20);
  EXPECT_EQ(bench.world().organisms[0].fields.value(0, 32, 32), 1.0f);
  for (const float value : bench.world().organisms[1].fields.raw(0)) EXPECT_EQ(value, 0);
  for (const float value : sensed_by_second) EXPECT_EQ(value, 0);
  EXPECT_GT(bench.world().organisms[0].fields.value(0, 37, 32), 0.1f)
      << "the first organism's own field reached the place where the second sits";
}

}  // namespace
}  // namespace somas::model::test
