#include "bench/colonies.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <malloc.h>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "bench/subject.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

/// The steps of the recorded life that are copied, by one colony after another: cells are neither
/// few nor at their limit, and nearly as many are born as die.
constexpr std::array<std::uint64_t, 8> prime{800, 740, 840, 760, 720, 820, 780, 860};
/// Steps before the start: contacts are found, storage is warm.
constexpr int settling_steps = 4;

/// Colonies as they were recorded. Their phenotype is gone.
const std::vector<model::WorldState>& recorded() {
  static const std::vector<model::WorldState> worlds = [] {
    std::vector<model::WorldState> copies(prime.size());
    static_cast<void>(run::record_life(*shipped().ecosystem, champion().individual.genome,
                                       champion().seed, {}, [&](const model::Simulation& life) {
                                         const auto at = std::find(prime.begin(), prime.end(),
                                                                   life.steps_done());
                                         if (at != prime.end())
                                           copies[at - prime.begin()] = life.state();
                                       }));
    for (const model::WorldState& copy : copies)
      if (copy.cells.size() == 0) throw std::runtime_error("the champion died before its prime");
    return copies;
  }();
  return worlds;
}

const model::GridDeclaration& shipped_nutrients() {
  return shipped().ecosystem->schema().grids.front();
}

double side() { return shipped_nutrients().spec.side; }

/// Where a colony comes to lie, in squares from its place in the recorded world, and how many of
/// its cells and particles there are.
struct Copy {
  const model::WorldState* of = nullptr;
  std::int64_t columns = 0, rows = 0;
  double part = 1;  ///< of the recorded one
  std::uint32_t cells = 0, particles = 0;
};

/// Colonies for so many cells, the last one cut down; not yet in their places.
std::vector<Copy> colonies_for(std::uint32_t cells) {
  std::vector<Copy> copies;
  for (std::uint32_t left = cells; left > 0; left -= copies.back().cells) {
    Copy copy{.of = &recorded()[copies.size() % recorded().size()]};
    const std::uint32_t whole = copy.of->cells.size();
    copy.cells = std::min(whole, left);
    copy.part = static_cast<double>(copy.cells) / whole;
    copy.particles = static_cast<std::uint32_t>(copy.part * copy.of->tables.front().rows());
    copies.push_back(copy);
  }
  return copies;
}

/// Squares along an edge of the nutrient grid that gives each colony as many as it had; even, as
/// shipped.
std::uint32_t edge_for(const std::vector<Copy>& copies) {
  double colonies = 0;
  for (const Copy& copy : copies) colonies += copy.part;
  return 2 * static_cast<std::uint32_t>(
                 std::ceil(0.5 * shipped_nutrients().spec.columns * std::sqrt(colonies)));
}

/// The middle of a colony, in squares.
std::pair<double, double> middle_of(const model::CellStore& colony) {
  const double count = side() * colony.size();
  return {std::accumulate(colony.x.begin(), colony.x.end(), 0.0) / count,
          std::accumulate(colony.y.begin(), colony.y.end(), 0.0) / count};
}

/// The `count` innermost cells of a colony, marked.
std::vector<std::uint8_t> innermost(const model::CellStore& colony, std::uint32_t count) {
  const auto [x, y] = middle_of(colony);
  std::vector<std::pair<double, std::uint32_t>> by_distance;
  for (std::uint32_t i = 0; i < colony.size(); ++i)
    by_distance.emplace_back(std::hypot(colony.x[i] - x * side(), colony.y[i] - y * side()), i);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::uint8_t> marked(colony.size(), 0);
  for (std::uint32_t k = 0; k < count; ++k) marked[by_distance[k].second] = 1;
  return marked;
}

std::string text(const char* path, double value) {
  return std::string(path) + "=" + std::to_string(value);
}

std::size_t heap_in_use() {
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

class Copying {
 public:
  Copying(std::vector<Copy> copies, model::Simulation& simulation)
      : copies_(std::move(copies)), to_(simulation.mutable_state()) {
    spread_out();
    copy_cells();
    copy_particles();
    for (const Copy& copy : copies_) {
      copy_morphogens(copy);
      copy_nutrients(copy);
    }
    to_.step = prime.front();
    to_.scalars = recorded().front().scalars;
    simulation.restructured();
  }

 private:
  void spread_out() {
    const auto count = static_cast<std::uint32_t>(copies_.size());
    const auto across =
        static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    const std::uint32_t up = (count + across - 1) / across;
    const double edge = edge_for(copies_);
    const auto place = [&](std::uint32_t i, std::uint32_t of, double middle) {
      return std::llround(edge * ((i + 0.5) / of - 0.5) - middle);
    };
    for (std::uint32_t c = 0; c < count; ++c) {
      const auto [x, y] = middle_of(copies_[c].of->cells);
      copies_[c].columns = place(c % across, across, x);
      copies_[c].rows = place(c / across, up, y);
    }
  }

  void copy_cells() {
    const Copy& last = copies_.back();
    const std::vector<std::uint8_t> in_last = innermost(last.of->cells, last.cells);
    model::CellStore& cells = to_.cells;
    std::uint32_t next = 0, most = 0;
    for (const Copy& copy : copies_) most = std::max(most, copy.of->cells.size());
    for (std::uint32_t k = 0; k < most; ++k) {
      for (const Copy& copy : copies_) {
        const model::CellStore& source = copy.of->cells;
        if (k >= source.size()) continue;
        const std::uint32_t i = source.order[k];
        if (&copy == &last && in_last[i] == 0) continue;
        // The founder is already there.
        const std::uint32_t at = next == 0 ? 0 : cells.append(cells.memory.channels());
        copy_cell(source, i, cells, at);
        cells.x[at] += side() * static_cast<double>(copy.columns);
        cells.y[at] += side() * static_cast<double>(copy.rows);
        cells.id[at] = next++;
      }
    }
    to_.organisms.front().next_id = next;
  }

  static void copy_cell(const model::CellStore& source, std::uint32_t i, model::CellStore& cells,
                        std::uint32_t at) {
    cells.x[at] = source.x[i], cells.y[at] = source.y[i];
    cells.vx[at] = source.vx[i], cells.vy[at] = source.vy[i];
    cells.radius[at] = source.radius[i];
    cells.energy[at] = source.energy[i], cells.ambrosia[at] = source.ambrosia[i];
    cells.pressure[at] = source.pressure[i];
    cells.stress_xx[at] = source.stress_xx[i];
    cells.stress_xy[at] = source.stress_xy[i];
    cells.stress_yy[at] = source.stress_yy[i];
    cells.born[at] = source.born[i], cells.parent[at] = source.parent[i];
    cells.remaining[at] = source.remaining[i];
    cells.state[at] = source.state[i], cells.target[at] = source.target[i];
    cells.action[at] = source.action[i];
    for (std::size_t v = 0; v < cells.values.size(); ++v) cells.values[v][at] = source.values[v][i];
    for (std::size_t h = 0; h < cells.damage.size(); ++h) cells.damage[h][at] = source.damage[h][i];
    for (std::uint32_t c = 0; c < cells.memory.channels(); ++c)
      cells.memory.row(c)[at] = source.memory.row(c)[i];
  }

  /// In the order in which they were launched, like cells; of a part of them every so many-th.
  void copy_particles() {
    model::TableStore& table = to_.tables.front();
    std::uint32_t rows = 0, most = 0, next = 0;
    for (const Copy& copy : copies_) {
      rows += copy.particles;
      most = std::max(most, copy.particles);
    }
    table.resize(rows);
    for (std::uint32_t k = 0; k < most; ++k) {
      for (const Copy& copy : copies_) {
        if (k >= copy.particles) continue;
        const model::TableStore& source = copy.of->tables.front();
        const auto i =
            static_cast<std::uint32_t>(std::uint64_t{k} * source.rows() / copy.particles);
        for (Id c = 0; c < source.columns(); ++c) table.column(c)[next] = source.column(c)[i];
        table.column(0)[next] += side() * static_cast<double>(copy.columns);
        table.column(1)[next] += side() * static_cast<double>(copy.rows);
        ++next;
      }
    }
  }

  /// Where fields of colonies overlap the greater value counts, as it does for sources.
  void copy_morphogens(const Copy& copy) {
    const model::MorphogenFields& source = copy.of->organisms.front().fields;
    model::MorphogenFields& fields = to_.organisms.front().fields;
    const std::int64_t old_size = source.size(), size = fields.size();
    const std::int64_t right = copy.columns + size / 2 - old_size / 2;
    const std::int64_t up = copy.rows + size / 2 - old_size / 2;
    for (std::int64_t row = std::max<std::int64_t>(0, -up); row < std::min(old_size, size - up);
         ++row) {
      for (std::int64_t column = std::max<std::int64_t>(0, -right);
           column < std::min(old_size, size - right); ++column) {
        const auto c = static_cast<std::uint32_t>(column), r = static_cast<std::uint32_t>(row);
        const auto to_c = static_cast<std::uint32_t>(column + right);
        const auto to_r = static_cast<std::uint32_t>(row + up);
        for (std::size_t kind = 0; kind < fields.kinds(); ++kind)
          if (source.value(kind, c, r) > fields.value(kind, to_c, to_r))
            fields.set(kind, to_c, to_r, source.value(kind, c, r));
      }
    }
  }

  /// Where colonies eat from the same patch the lower content counts.
  void copy_nutrients(const Copy& copy) {
    const std::vector<double>& source = copy.of->grids.front();
    std::vector<double>& content = to_.grids.front();
    const auto old_size = std::llround(std::sqrt(static_cast<double>(source.size())));
    const auto size = std::llround(std::sqrt(static_cast<double>(content.size())));
    const std::int64_t right = copy.columns + size / 2 - old_size / 2;
    const std::int64_t up = copy.rows + size / 2 - old_size / 2;
    for (std::int64_t row = std::max<std::int64_t>(0, -up); row < std::min(old_size, size - up);
         ++row) {
      for (std::int64_t column = std::max<std::int64_t>(0, -right);
           column < std::min(old_size, size - right); ++column) {
        double& there = content[static_cast<std::size_t>((row + up) * size + column + right)];
        there = std::min(there, source[static_cast<std::size_t>(row * old_size + column)]);
      }
    }
  }

  std::vector<Copy> copies_;
  model::WorldState& to_;
};

}  // namespace

std::vector<std::string> scaled_world(std::uint32_t cells) {
  const std::vector<Copy> copies = colonies_for(cells);
  const std::uint32_t edge = edge_for(copies);
  const double radius = edge * side() * std::sqrt(0.5);  // of the square's corners
  // As many as in the recorded world are in flight; they now fly for longer. The number that a
  // world may have in flight at most is checked with twice the radius.
  double in_flight = 0;
  for (const Copy& copy : copies) in_flight += copy.particles;
  constexpr double speed = 0.5, most_in_flight = 9.9e6;
  const double rate =
      std::min(in_flight * speed / radius, most_in_flight / (2 * radius / speed + 1));
  return {text("world.radius", radius),
          "world.max_cells=" + std::to_string(2 * std::uint64_t{cells} + 100),
          "world.morphogens.size=" + std::to_string(edge + 1),
          "environments.nutrients.resolution=" + std::to_string(edge),
          text("environments.particle_aggression.aim_spread", 0.2 * radius),
          text("environments.particle_aggression.rate_constant", rate),
          "environments.particle_aggression.rate_linear=0",
          "environments.particle_aggression.rate_quadratic=0"};
}

Colonies::Colonies(std::uint32_t cells)
    : heap_before_((static_cast<void>(recorded()), heap_in_use())),
      experiment_(experiment_1(scaled_world(cells))),
      phenotype_(experiment_.ecosystem->express(champion().individual.genome)) {
  const model::RosterEntry founder{.phenotype = &phenotype_, .key = 1};
  simulation_ =
      std::make_unique<model::Simulation>(*experiment_.ecosystem, std::span(&founder, 1), 1);
  const Copying copying(colonies_for(cells), *simulation_);
  for (int step = 0; step < settling_steps; ++step) simulation_->step();
  heap_bytes_ = heap_in_use() - heap_before_;
  start_ = simulation_->state();
}

Colonies& colonies_of(std::uint32_t cells) {
  static std::unique_ptr<Colonies> last;
  static std::uint32_t size = 0;
  if (size != cells) {
    last.reset();
    last = std::make_unique<Colonies>(cells);
    size = cells;
  }
  last->rewind();
  return *last;
}

std::size_t state_bytes(const model::WorldState& world) {
  std::size_t bytes = 0;
  const auto add = [&](const auto& column) { bytes += column.size() * sizeof(column.front()); };
  world.cells.each_column(add);
  add(world.cells.order), add(world.cells.rank);
  add(world.contacts.runs), add(world.contacts.items);
  return bytes;
}

}  // namespace somas::bench
