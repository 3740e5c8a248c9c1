#include "core/recording/recorder.hpp"

#include <limits>
#include <stdexcept>

#include "core/recording/header.hpp"

namespace somas::recording {
namespace {

constexpr float no_number = std::numeric_limits<float>::quiet_NaN();

/// A column in canonical order.
template <class To, class From>
void take(std::vector<To>& to, const std::vector<From>& from, const model::CellStore& cells) {
  to.resize(cells.size());
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = static_cast<To>(from[cells.order[k]]);
}

void take_cells(const model::CellStore& cells, Cells& taken) {
  take(taken.id, cells.id, cells);
  take(taken.parent, cells.parent, cells);
  take(taken.born, cells.born, cells);
  take(taken.organism, cells.organism, cells);
  take(taken.state, cells.state, cells);
  take(taken.action, cells.action, cells);
  take(taken.x, cells.x, cells);
  take(taken.y, cells.y, cells);
  take(taken.radius, cells.radius, cells);
  take(taken.energy, cells.energy, cells);
  take(taken.ambrosia, cells.ambrosia, cells);
  take(taken.pressure, cells.pressure, cells);
  taken.damage.resize(cells.damage.size());
  for (std::size_t h = 0; h < cells.damage.size(); ++h)
    take(taken.damage[h], cells.damage[h], cells);
  taken.values.resize(cells.values.size());
  for (std::size_t v = 0; v < cells.values.size(); ++v)
    take(taken.values[v], cells.values[v], cells);

  taken.target.assign(cells.size(), none);
  for (std::size_t k = 0; k < taken.target.size(); ++k) {
    const std::uint32_t i = cells.order[k];
    if (cells.action[i] == model::Action::specialization) taken.target[k] = cells.target[i];
  }
}

void take_tables(const std::vector<model::TableStore>& tables, std::vector<TableRows>& taken) {
  taken.resize(tables.size());
  for (std::size_t t = 0; t < tables.size(); ++t) {
    taken[t].columns.resize(tables[t].columns());
    for (std::size_t c = 0; c < taken[t].columns.size(); ++c) {
      const std::span<const double> column = tables[t].column(static_cast<Id>(c));
      taken[t].columns[c].assign(column.begin(), column.end());
    }
  }
}

/// Concentrations row-major from the lower left.
void take_morphogen(const model::MorphogenFields& fields, std::size_t kind,
                    std::vector<float>& taken) {
  const std::uint32_t size = fields.size();
  taken.assign(std::size_t{size} * size, 0.0f);
  const model::MorphogenFields::Box box = fields.box(kind);
  if (box.left > box.right) return;
  for (std::uint32_t row = box.bottom; row <= box.top; ++row)
    for (std::uint32_t column = box.left; column <= box.right; ++column)
      taken[std::size_t{row} * size + column] = fields.value(kind, column, row);
}

}  // namespace

Recorder::Recorder(const model::Ecosystem& ecosystem, std::size_t own_seat, Sink& sink,
                   Provenance provenance, RecorderOptions options)
    : ecosystem_(ecosystem), own_seat_(own_seat), sink_(sink), options_(options) {
  if (options.every == 0 || options.fields_every == 0)
    throw std::invalid_argument("frames are at least one step apart");
  header_.provenance = std::move(provenance);
}

void Recorder::begin(const model::WorldState& world) {
  if (begun_) return;
  begun_ = true;
  Provenance provenance = std::move(header_.provenance);
  header_ = header_of(ecosystem_, world);
  header_.provenance = std::move(provenance);
  header_.every = options_.every;
  header_.fields_every = options_.fields_every;
  header_.controller = options_.controller;
  for (std::uint32_t k = 0; k < header_.organisms.size(); ++k)
    if (header_.organisms[k].seat == own_seat_) header_.own = k;
  for (const Grid& grid : header_.grids)
    squares_in_world_.push_back(squares_in_world(grid, header_.radius));
  sink_.begin(header_);
}

void Recorder::controlled(const model::WorldState& world, const model::FloatMatrix& inputs,
                          const model::FloatMatrix& outputs) {
  begin(world);
  if (!options_.controller) return;
  // Cells may be born, change their place and die before the frame is taken: keep who is who.
  const model::CellStore& cells = world.cells;
  controlled_.resize(cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k)
    controlled_[k] = {cells.organism[cells.order[k]], cells.id[cells.order[k]]};
  const auto keep = [&](const model::FloatMatrix& from, std::vector<std::vector<float>>& to) {
    to.resize(from.channels());
    for (std::uint32_t channel = 0; channel < from.channels(); ++channel) {
      const float* row = from.row(channel);
      to[channel].resize(cells.size());
      for (std::size_t k = 0; k < cells.size(); ++k) to[channel][k] = row[cells.order[k]];
    }
  };
  keep(inputs, inputs_);
  keep(outputs, outputs_);
}

void Recorder::tell(const model::WorldState& world, std::uint32_t cell, EventKind kind,
                    std::uint16_t from, std::uint16_t cause) {
  begin(world);
  const model::CellStore& cells = world.cells;
  sink_.event({.step = world.step,
               .kind = kind,
               .organism = cells.organism[cell],
               .cell = static_cast<std::uint32_t>(cells.id[cell]),
               .parent = static_cast<std::uint32_t>(cells.parent[cell]),
               .state = cells.state[cell],
               .from = from,
               .cause = cause,
               .x = static_cast<float>(cells.x[cell]),
               .y = static_cast<float>(cells.y[cell])});
}

void Recorder::division_refused(const model::WorldState& world, std::uint32_t cell) {
  tell(world, cell, EventKind::refused_division);
}

void Recorder::specialized(const model::WorldState& world, std::uint32_t cell, std::uint16_t from) {
  tell(world, cell, EventKind::specialization, from);
}

void Recorder::born(const model::WorldState& world, std::uint32_t daughter) {
  tell(world, daughter, EventKind::birth);
}

void Recorder::died(const model::WorldState& world, std::uint32_t cell) {
  const std::uint32_t cause = world.cells.cause[cell];
  tell(world, cell, EventKind::death, none,
       cause == model::no_cause ? none : static_cast<std::uint16_t>(cause));
}

void Recorder::ambrosia_passed(const model::WorldState& world, std::uint32_t from, std::uint32_t to,
                               double amount) {
  const model::CellStore& cells = world.cells;
  flux_[{cells.organism[from], cells.state[from], cells.organism[to], cells.state[to]}] += amount;
}

void Recorder::observe(const model::Simulation& simulation) {
  const model::WorldState& world = simulation.state();
  begin(world);
  steps_done_ = simulation.steps_done();
  const std::uint64_t step = steps_done_ - 1;
  const bool last = simulation.finished();
  summarize(world, step);
  if (step % options_.every != 0 && !last) return;
  take_frame(world, step, step % options_.fields_every == 0 || last);
}

void Recorder::summarize(const model::WorldState& world, std::uint64_t step) {
  const std::size_t organisms = world.organisms.size();
  summary_.step = step;
  summary_.population.assign(header_.slots(), 0);
  summary_.energy.assign(organisms, 0.0);
  summary_.ambrosia.assign(organisms, 0.0);
  const model::CellStore& cells = world.cells;
  for (const std::uint32_t i : cells.order) {
    const std::uint16_t organism = cells.organism[i];
    ++summary_.population[header_.organisms[organism].first_slot + cells.state[i]];
    summary_.energy[organism] += cells.energy[i];
    summary_.ambrosia[organism] += cells.ambrosia[i];
  }
  for (std::size_t k = 0; k < organisms; ++k) {
    if (world.organisms[k].live == 0) continue;
    summary_.energy[k] /= world.organisms[k].live;
    summary_.ambrosia[k] /= world.organisms[k].live;
  }
  summary_.grid_totals.assign(world.grids.size(), 0.0);
  for (std::size_t g = 0; g < world.grids.size(); ++g)
    for (const std::uint32_t square : squares_in_world_[g])
      summary_.grid_totals[g] += world.grids[g][square];
  summary_.flux.clear();
  for (const auto& [way, amount] : flux_)
    summary_.flux.push_back({way[0], way[1], way[2], way[3], amount});
  flux_.clear();
  sink_.summary(summary_);
}

void Recorder::take_frame(const model::WorldState& world, std::uint64_t step, bool fields) {
  frame_.step = step;
  take_cells(world.cells, frame_.cells);
  take_controller(world.cells);
  take_tables(world.tables, frame_.tables);
  frame_.has_fields = fields;
  frame_.grids.resize(fields ? world.grids.size() : 0);
  frame_.morphogens.resize(fields ? world.organisms.size() : 0);
  if (fields) take_fields(world);
  sink_.frame(frame_);
}

void Recorder::take_controller(const model::CellStore& cells) {
  if (!options_.controller) return;
  // Both lists ascend by (organism, id): one walk finds every cell's lane.
  std::vector<std::size_t> lane(cells.size(), controlled_.size());
  std::size_t at = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const std::pair<std::uint16_t, std::uint64_t> who{cells.organism[cells.order[k]],
                                                      cells.id[cells.order[k]]};
    while (at < controlled_.size() && controlled_[at] < who) ++at;
    if (at < controlled_.size() && controlled_[at] == who) lane[k] = at;
  }
  const auto pick = [&](const std::vector<std::vector<float>>& from,
                        std::vector<std::vector<float>>& to) {
    to.resize(from.size());
    for (std::size_t channel = 0; channel < from.size(); ++channel) {
      to[channel].assign(cells.size(), no_number);
      for (std::size_t k = 0; k < cells.size(); ++k)
        if (lane[k] < controlled_.size()) to[channel][k] = from[channel][lane[k]];
    }
  };
  pick(inputs_, frame_.cells.inputs);
  pick(outputs_, frame_.cells.outputs);
}

void Recorder::take_fields(const model::WorldState& world) {
  for (std::size_t g = 0; g < world.grids.size(); ++g)
    frame_.grids[g].assign(world.grids[g].begin(), world.grids[g].end());
  for (std::size_t k = 0; k < world.organisms.size(); ++k) {
    const model::MorphogenFields& fields = world.organisms[k].fields;
    frame_.morphogens[k].resize(fields.kinds());
    for (std::size_t kind = 0; kind < fields.kinds(); ++kind)
      take_morphogen(fields, kind, frame_.morphogens[k][kind]);
  }
}

void Recorder::finish(const evaluation::Result& result) {
  if (!begun_) throw std::logic_error("a recording is finished that never began");
  Ending ending;
  ending.steps = steps_done_;
  for (const Organism& organism : header_.organisms)
    ending.outcomes.push_back(result.rows.at(organism.seat).outcome);
  ending.score = result.rows.at(own_seat_).score;
  sink_.finish(ending);
}

}  // namespace somas::recording
