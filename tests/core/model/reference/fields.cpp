#include "tests/core/model/reference/fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace somas::reference {

namespace {

/// Left edge of the grid, and its lower edge.
double low_edge(const Field& field) { return -0.5 * field.side * static_cast<double>(field.size); }

/// Calls visit(k, column offset, row offset) for the nine squares of a block.
template <class Visit>
void each_of_nine(Visit&& visit) {
  for (std::size_t k = 0; k < 9; ++k)
    visit(k, static_cast<int>(k % 3) - 1, static_cast<int>(k / 3) - 1);
}

void scale(float factor, Field& field) {
  for (float& c : field.squares) c *= factor;
}

}  // namespace

std::vector<Field> empty_fields(const model::MorphogenGrid& grid) {
  const std::size_t squares = std::size_t{grid.size} * grid.size;
  return std::vector<Field>(grid.kinds.size(),
                            {grid.size, grid.side, std::vector<float>(squares, 0.0f)});
}

void evaporate_and_spread(const model::Morphogen& morphogen, Mistake mistake, Field& field) {
  const auto kept = static_cast<float>(1.0 - morphogen.evaporation);
  const auto straight = static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation));
  const auto diagonal =
      static_cast<float>(std::max(0.0, 1.0 - morphogen.attenuation * std::numbers::sqrt2));
  if (mistake != Mistake::spread_first) scale(kept, field);
  const Field before = field;
  for (std::int64_t row = 0; row < field.size; ++row) {
    for (std::int64_t column = 0; column < field.size; ++column) {
      float most = before.at(column, row);
      each_of_nine([&](std::size_t, int dx, int dy) {
        if (dx == 0 && dy == 0) return;
        const float factor = dx == 0 || dy == 0 ? straight : diagonal;
        most = std::max(most, before.at(column + dx, row + dy) * factor);
      });
      if (mistake == Mistake::spread_first) most *= kept;
      field.squares[static_cast<std::size_t>(row * field.size + column)] =
          most < 1e-6f ? 0.0f : most;
    }
  }
}

Block block_at(const Field& field, double x, double y) {
  Block block;
  const double sides_x = (x - low_edge(field)) / field.side;
  const double sides_y = (y - low_edge(field)) / field.side;
  const double column = std::floor(sides_x), row = std::floor(sides_y);
  const auto size = static_cast<double>(field.size);
  const bool near = column >= -1 && column <= size && row >= -1 && row <= size;
  if (!near) return block;
  block.column = static_cast<std::int64_t>(column);
  block.row = static_cast<std::int64_t>(row);

  // From the middle of the square that holds the point, in sides.
  const auto fx = static_cast<float>(sides_x - (column + 0.5));
  const auto fy = static_cast<float>(sides_y - (row + 0.5));
  const bool at_centre = fx * fx + fy * fy < 1e-6f * 1e-6f;
  each_of_nine([&](std::size_t k, int dx, int dy) {
    if (!field.has(block.column + dx, block.row + dy)) return;
    const float away_x = fx - static_cast<float>(dx), away_y = fy - static_cast<float>(dy);
    const bool middle = dx == 0 && dy == 0;
    if (at_centre)
      block.weight[k] = middle ? 1.0f : 0.0f;
    else
      block.weight[k] = 1.0f / std::sqrt(away_x * away_x + away_y * away_y);
  });
  for (const float weight : block.weight) {
    block.sum += weight;
    block.peak = std::max(block.peak, weight);
  }
  return block;
}

float sense(const Field& field, double x, double y) {
  const Block block = block_at(field, x, y);
  if (block.sum == 0) return 0.0f;
  float total = 0;
  each_of_nine([&](std::size_t k, int dx, int dy) {
    total += field.at(block.column + dx, block.row + dy) * block.weight[k];
  });
  return total / block.sum;
}

void deposit(model::Deposit rule, double x, double y, float amount, Field& field) {
  const Block block = block_at(field, x, y);
  if (block.sum == 0) return;
  const float unit = amount / (rule == model::Deposit::peak ? block.peak : block.sum);
  each_of_nine([&](std::size_t k, int dx, int dy) {
    if (!field.has(block.column + dx, block.row + dy)) return;
    float& square =
        field.squares[static_cast<std::size_t>((block.row + dy) * field.size + block.column + dx)];
    square = std::max(square, block.weight[k] * unit);
  });
}

Slope slope_at(const Field& field, double x, double y) {
  const double column = std::floor((x - low_edge(field)) / field.side);
  const double row = std::floor((y - low_edge(field)) / field.side);
  const auto size = static_cast<double>(field.size);
  if (!(column >= -1 && column <= size && row >= -1 && row <= size)) return {};

  // The block, without what is off the grid.
  const auto first = [](double middle) {
    return std::max<std::int64_t>(static_cast<std::int64_t>(middle) - 1, 0);
  };
  const auto last = [&](double middle) {
    return std::min<std::int64_t>(static_cast<std::int64_t>(middle) + 1, field.size - 1);
  };
  const std::int64_t left = first(column), right = last(column);
  const std::int64_t bottom = first(row), top = last(row);
  const auto width = static_cast<double>(right - left), height = static_cast<double>(top - bottom);
  Slope slope;
  for (std::int64_t r = bottom; r <= top; ++r)
    slope.x += static_cast<double>(field.at(right, r)) - static_cast<double>(field.at(left, r));
  for (std::int64_t c = left; c <= right; ++c)
    slope.y += static_cast<double>(field.at(c, top)) - static_cast<double>(field.at(c, bottom));
  if (width > 0) slope.x /= (height + 1) * width * field.side;
  if (height > 0) slope.y /= (width + 1) * height * field.side;
  return slope;
}

}  // namespace somas::reference
