#include "core/model/motility.hpp"

#include <cmath>

namespace somas::model {

void Motility::prepare(const WorldState& world) {
  crawls_.clear();
  const CellStore& cells = world.cells;
  for (const CellRange& range : cells.ranges) {
    const State& state = world.state_of(range.begin);
    if (state.motility == 0) continue;
    const MorphogenFields& fields = world.organisms[range.organism].fields;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      if (cells.dead[i] != 0) continue;
      const Gradient g = fields.gradient(state.motility_signal, cells.x[i], cells.y[i]);
      const double steepness = std::sqrt(g.x * g.x + g.y * g.y);
      if (!(steepness >= flat_gradient)) continue;
      crawls_.push_back(
          {i, state.motility * (g.x / steepness), state.motility * (g.y / steepness)});
    }
  }
}

void Motility::add(std::span<double> fx, std::span<double> fy) const {
  for (const Crawl& crawl : crawls_) {
    fx[crawl.cell] += crawl.fx;
    fy[crawl.cell] += crawl.fy;
  }
}

}  // namespace somas::model
