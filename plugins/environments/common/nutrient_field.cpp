#include "plugins/environments/common/nutrient_field.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "somas/sdk/workers.hpp"

namespace somas::environments {

namespace {

// What is worth a thread.
constexpr std::uint32_t least_patches = 16384, least_cells = 2048;
/// What is looked up together.
constexpr std::uint32_t most_cells = 128;

/// Patches that are full are the most, and stand together: those are not written. In a large world
/// memory is all that this waits for.
template <class Capacity>
void grow(double* content, std::uint32_t begin, std::uint32_t end, double growth,
          const Capacity& capacity) {
  constexpr std::uint32_t many = 32;
  while (begin < end) {
    const std::uint32_t stop = std::min(begin + many, end);
    std::uint64_t missing = 0;
    for (std::uint32_t i = begin; i < stop; ++i)
      missing |=
          std::bit_cast<std::uint64_t>(content[i]) ^ std::bit_cast<std::uint64_t>(capacity(i));
    for (std::uint32_t i = begin; missing != 0 && i < stop; ++i)
      content[i] = std::min(content[i] + growth, capacity(i));
    begin = stop;
  }
}

}  // namespace

bool Region::contains(double x, double y) const {
  switch (shape) {
    case Shape::square:
      return std::abs(x) <= size && std::abs(y) <= size;
    case Shape::disc:
      return x * x + y * y <= size * size;
    default:
      return true;
  }
}

void NutrientField::declare(Declare& declare, const PatchParameters& parameters,
                            const Region& region) {
  const auto resolution = static_cast<std::uint32_t>(parameters.resolution);
  GridSpec spec;
  spec.columns = spec.rows = resolution;
  spec.side = parameters.side;
  spec.left = spec.bottom = -0.5 * parameters.side * resolution;

  // The capacity of each patch says all about the region.
  const Grid layout{{}, spec};
  capacity_.resize(std::size_t{resolution} * resolution);
  for (std::size_t i = 0; i < capacity_.size(); ++i)
    capacity_[i] =
        region.contains(layout.centre_x(i), layout.centre_y(i)) ? parameters.capacity : 0;
  const auto [least, most] = std::minmax_element(capacity_.begin(), capacity_.end());
  everywhere_ = *least == *most ? *most : 0;
  if (*most == 0)
    throw ParameterError(region.shape == Region::Shape::disc ? "radius" : "half_side",
                         "the region is too small: no patch has its centre inside");

  regeneration_ =
      declare.parameter("regeneration", {.value = parameters.regeneration, .minimum = 0});
  grid_ = declare.grid("content", spec);
  sensor_ = declare.sensor(declare.instance());
  declare.resource(declare.instance(), grid_, declare.skill(parameters.production_skill, {}));
}

void NutrientField::set(World& world, double level) const {
  const Grid grid = world.grid(grid_);
  for (std::size_t i = 0; i < capacity_.size(); ++i) grid.values[i] = std::min(level, capacity_[i]);
}

void NutrientField::regenerate(World& world) const {
  const Grid grid = world.grid(grid_);
  const double growth = world.parameter(regeneration_);
  const auto patches = static_cast<std::uint32_t>(capacity_.size());
  share_work(world, patches, least_patches, [&](std::uint32_t begin, std::uint32_t end) {
    const double* capacity = capacity_.data();
    if (const double same = everywhere_; same > 0)
      grow(grid.values.data(), begin, end, growth, [=](std::uint32_t) { return same; });
    else
      grow(grid.values.data(), begin, end, growth, [=](std::uint32_t i) { return capacity[i]; });
  });
}

void NutrientField::sense(World& world) const {
  const Grid grid = world.grid(grid_);
  const Cells& cells = world.cells();
  const std::span<float> sensed = world.sensor(sensor_);
  share_work(world, cells.count, least_cells, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; i += most_cells)
      sense(grid, cells, sensed, i, std::min(most_cells, end - i));
  });
}

/// Of few cells; patches and quotients in lanes.
void NutrientField::sense(const Grid& grid, const Cells& cells, std::span<float> sensed,
                          std::uint32_t first, std::uint32_t count) const {
  std::array<std::int64_t, most_cells> patch;
  std::array<double, most_cells> content, capacity;
  const double *x = &cells.x[first], *y = &cells.y[first];
  float* found = &sensed[first];
  for (std::uint32_t i = 0; i < count; ++i) patch[i] = grid.index_of(x[i], y[i]);
  for (std::uint32_t i = 0; i < count; ++i) {
    content[i] = patch[i] < 0 ? 0 : grid.values[patch[i]];
    capacity[i] = patch[i] < 0 ? 0 : everywhere_ > 0 ? everywhere_ : capacity_[patch[i]];
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const double share = content[i] / capacity[i];
    found[i] = static_cast<float>(capacity[i] > 0 ? share : 0.0);
  }
}

}  // namespace somas::environments
