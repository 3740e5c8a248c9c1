#include "plugins/environments/toxin_gradient/toxin_gradient.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace somas::environments {

namespace {

using Parameters = ToxinGradient::Parameters;

/// Shortest decimal that reads back as x.
std::string text(double x) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
  return {digits.data(), end};
}

/// What passes from a square to each neighbour in a step, as a share of the difference.
double exchange(const Parameters& p) { return p.diffusion / (p.side * p.side); }

/// No square may give away more than it has: then nothing oscillates or becomes negative.
void check_stability(const Parameters& p) {
  const double share = exchange(p);
  if (!(share <= 0.25))
    throw ParameterError("diffusion", "diffusion / side^2 is " + text(share) +
                                          "; the explicit scheme is stable up to 1/4, that is "
                                          "'diffusion' up to " +
                                          text(0.25 * p.side * p.side));
  if (!(p.decay <= 1 - 4 * share))
    throw ParameterError("decay",
                         "a square would lose more than it holds: with this 'diffusion', "
                         "'decay' may be at most 1 - 4 diffusion / side^2 = " +
                             text(1 - 4 * share));
}

/// One explicit step from `old` to `grid`. Sums are built so that all eight symmetries of the
/// square give the same bits: of the two neighbours on either axis first, then of both axes.
void diffuse(std::span<const double> old, const Grid& grid, const Parameters& p) {
  const std::size_t columns = grid.spec.columns, rows = grid.spec.rows;
  const double share = exchange(p);
  // Beyond the edge lies the square's own concentration, so that nothing flows, or none.
  const double beyond = p.boundary == "zero_flux" ? 1 : 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t i = row * columns + column;
      const double c = old[i], ghost = beyond * c;
      const double left = column > 0 ? old[i - 1] : ghost;
      const double right = column + 1 < columns ? old[i + 1] : ghost;
      const double below = row > 0 ? old[i - columns] : ghost;
      const double above = row + 1 < rows ? old[i + columns] : ghost;
      const double around = (left + right) + (below + above);
      // Rounding must not leave less than nothing.
      grid.values[i] = std::max(0.0, c + share * (around - 4 * c) - p.decay * c);
    }
  }
}

/// In the square that holds (x, y); off the grid there is nothing.
double concentration_at(const Grid& grid, double x, double y) {
  const std::int64_t square = grid.index_of(x, y);
  return square < 0 ? 0 : grid.values[static_cast<std::size_t>(square)];
}

}  // namespace

ToxinGradient::ToxinGradient(const Parameters& parameters) : parameters_(parameters) {
  check_stability(parameters_);
  spec_.columns = spec_.rows = static_cast<std::uint32_t>(parameters_.resolution);
  spec_.side = parameters_.side;
  spec_.left = spec_.bottom = -0.5 * parameters_.side * spec_.columns;
  const Grid layout{{}, spec_};
  for (std::size_t i = 0; i < parameters_.sources.size(); ++i) {
    const Source& source = parameters_.sources[i];
    const std::int64_t square = layout.index_of(source.x, source.y);
    if (square < 0)
      throw ParameterError("sources[" + std::to_string(i) + "]",
                           "the source at (" + text(source.x) + ", " + text(source.y) +
                               ") is off the grid, which spans " + text(spec_.left) + " to " +
                               text(-spec_.left) + " on both axes");
    squares_.push_back(static_cast<std::size_t>(square));
  }
}

void ToxinGradient::declare(Declare& declare) {
  grid_ = declare.grid("concentration", spec_);
  sensor_ = declare.sensor(declare.instance());
  hazard_ = declare.hazard(declare.instance(), declare.skill(parameters_.resistance_skill, {}));
  emission_scale_ =
      declare.parameter("emission_scale", {.value = parameters_.emission_scale, .minimum = 0});
  toxicity_ = declare.parameter("toxicity", {.value = parameters_.toxicity, .minimum = 0});
  declare.acts_in(Phase::fields);
  declare.acts_in(Phase::sense);
  declare.acts_in(Phase::stress);
}

void ToxinGradient::act(Phase phase, World& world) const {
  if (phase == Phase::fields) spread(world);
  if (phase == Phase::sense) sense(world);
  if (phase == Phase::stress) poison(world);
}

void ToxinGradient::spread(World& world) const {
  thread_local std::vector<double> old;
  const Grid grid = world.grid(grid_);
  old.assign(grid.values.begin(), grid.values.end());
  diffuse(old, grid, parameters_);
  const double scale = world.parameter(emission_scale_);
  const double area = spec_.side * spec_.side;
  for (std::size_t i = 0; i < squares_.size(); ++i)
    grid.values[squares_[i]] += scale * parameters_.sources[i].rate / area;
  if (parameters_.edge != "none") hold_edge(grid, scale);
}

void ToxinGradient::hold_edge(const Grid& grid, double concentration) const {
  const std::string& edge = parameters_.edge;
  const std::size_t size = spec_.columns, last = size - 1;
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t row = edge == "top" ? last : edge == "bottom" ? 0 : k;
    const std::size_t column = edge == "right" ? last : edge == "left" ? 0 : k;
    grid.values[row * size + column] = concentration;
  }
}

void ToxinGradient::sense(World& world) const {
  const Grid grid = world.grid(grid_);
  const Cells& cells = world.cells();
  const std::span<float> sensed = world.sensor(sensor_);
  for (std::uint32_t i = 0; i < cells.count; ++i) {
    const double read = concentration_at(grid, cells.x[i], cells.y[i]) / parameters_.saturation;
    sensed[i] = static_cast<float>(std::min(1.0, read));
  }
}

void ToxinGradient::poison(World& world) const {
  const Grid grid = world.grid(grid_);
  const Cells& cells = world.cells();
  const double toxicity = world.parameter(toxicity_);
  for (std::uint32_t i = 0; i < cells.count; ++i) {
    if (cells.dead[i] != 0) continue;
    const double dose = toxicity * concentration_at(grid, cells.x[i], cells.y[i]);
    if (dose > 0) world.strike(i, hazard_, dose);
  }
}

}  // namespace somas::environments
