// Morphogens (docs/model.md, section 1), square by square.
#pragma once

#include <array>

#include "tests/core/model/reference/world.hpp"

namespace somas::reference {

/// Inverse-distance weights of the 3x3 block round a point, from the lower left, row by row.
struct Block {
  std::int64_t column = 0, row = 0;  ///< of the square in the middle
  std::array<float, 9> weight{};     ///< 0: off the grid
  float sum = 0, peak = 0;
};

/// Change of a concentration per length.
struct Slope {
  double x = 0, y = 0;
};

/// Empty fields, one a morphogen.
[[nodiscard]] std::vector<Field> empty_fields(const model::MorphogenGrid& grid);
void evaporate_and_spread(const model::Morphogen& morphogen, Mistake mistake, Field& field);
[[nodiscard]] Block block_at(const Field& field, double x, double y);
[[nodiscard]] float sense(const Field& field, double x, double y);
void deposit(model::Deposit rule, double x, double y, float amount, Field& field);
[[nodiscard]] Slope slope_at(const Field& field, double x, double y);

}  // namespace somas::reference
