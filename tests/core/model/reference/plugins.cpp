// The world as plugins see it, and the calls of all plugins.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tests/core/model/reference/phases.hpp"

namespace somas::reference {

namespace {

/// Where along a segment, in [0, 1], it meets a disc: 0 when it starts inside; -1: nowhere.
double meeting(const Segment& s, const Cell& cell) {
  const double fx = s.x0 - cell.x, fy = s.y0 - cell.y;
  const double outside = fx * fx + fy * fy - cell.radius * cell.radius;
  if (outside <= 0) return 0;
  const double dx = s.x1 - s.x0, dy = s.y1 - s.y0;
  const double towards = fx * dx + fy * dy;
  if (towards >= 0) return -1;
  const double square = dx * dx + dy * dy;
  const double discriminant = towards * towards - square * outside;
  if (discriminant < 0) return -1;
  const double t = (-towards - std::sqrt(discriminant)) / square;
  return t <= 1 ? t : -1;
}

/// Columns of the cells, gathered when made and written back by `keep`.
class SeenWorld final : public somas::World {
 public:
  explicit SeenWorld(reference::World& world) : world_(world), order_(world.seen_order()) {
    for (const std::size_t i : order_) {
      const Cell& cell = world.cells[i];
      x_.push_back(cell.x), y_.push_back(cell.y);
      vx_.push_back(cell.vx), vy_.push_back(cell.vy);
      radius_.push_back(cell.radius);
      energy_.push_back(cell.energy), ambrosia_.push_back(cell.ambrosia);
      pressure_.push_back(cell.pressure);
      id_.push_back(cell.name.id);
      state_.push_back(cell.state), organism_.push_back(cell.name.organism);
      dead_.push_back(cell.dead ? 1 : 0);
    }
    cells_ = {.count = static_cast<std::uint32_t>(order_.size()),
              .x = x_,
              .y = y_,
              .vx = vx_,
              .vy = vy_,
              .radius = radius_,
              .energy = energy_,
              .ambrosia = ambrosia_,
              .pressure = pressure_,
              .id = id_,
              .state = state_,
              .organism = organism_,
              .dead = dead_};
    force_x_.assign(order_.size(), 0.0);
    force_y_.assign(order_.size(), 0.0);
    sensors_.assign(world.schema().sensors.size(), std::vector<float>(order_.size(), 0.0f));
    for (Id v = 0; v < world.schema().cell_values.size(); ++v) {
      values_.emplace_back();
      for (const std::size_t i : order_) values_[v].push_back(world.cells[i].values[v]);
    }
    for (Id s = 0; s < world.schema().skills.size(); ++s) {
      skills_.emplace_back();
      for (const std::size_t i : order_)
        skills_[s].push_back(world.state_of(world.cells[i]).skill(s));
    }
  }

  /// Writes back what plugins may write.
  void keep(Phase phase) {
    for (std::size_t k = 0; k < order_.size(); ++k) {
      Cell& cell = world_.cells[order_[k]];
      for (Id v = 0; v < values_.size(); ++v) cell.values[v] = values_[v][k];
      cell.force_x = force_x_[k];
      cell.force_y = force_y_[k];
      if (phase != Phase::sense) continue;
      const std::uint32_t first = world_.organism_of(cell).phenotype->ports->in().first_sensor;
      for (Id s = 0; s < sensors_.size(); ++s) cell.inputs[first + s] = sensors_[s][k];
    }
  }

  [[nodiscard]] std::uint64_t step() const override { return world_.step; }
  [[nodiscard]] const WorldInfo& info() const override { return world_.ecosystem->info(); }
  [[nodiscard]] const Cells& cells() const override { return cells_; }
  [[nodiscard]] std::span<float> sensor(Id sensor) override { return sensors_.at(sensor); }
  [[nodiscard]] std::span<const double> skill(Id skill) override { return skills_.at(skill); }
  [[nodiscard]] std::span<double> cell_value(Id value) override { return values_.at(value); }
  [[nodiscard]] double& scalar(Id scalar) override { return world_.scalars.at(scalar); }
  [[nodiscard]] Grid grid(Id grid) override {
    return {world_.grids.at(grid), world_.schema().grids[grid].spec};
  }
  [[nodiscard]] Table& table(Id table) override { return world_.tables.at(table); }
  [[nodiscard]] std::span<double> force_x() override { return force_x_; }
  [[nodiscard]] std::span<double> force_y() override { return force_y_; }

  void first_hit(std::span<const Segment> segments, std::span<std::int32_t> hits) override {
    std::vector<std::int32_t> seen_at(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k)
      seen_at[order_[k]] = static_cast<std::int32_t>(k);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      hits[s] = -1;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < world_.cells.size(); ++i) {
        const double t = meeting(segments[s], world_.cells[i]);
        const bool better =
            world_.mistake == Mistake::last_hit ? hits[s] < 0 || t > nearest : t < nearest;
        if (t < 0 || !better) continue;  // of equals the first one counts
        nearest = t;
        hits[s] = seen_at[i];
      }
      if (hits[s] >= 0) ++world_.events.hits;
    }
  }
  void strike(std::uint32_t cell, Id hazard, double energy) override {
    const model::Hazard& declared = world_.schema().hazards.at(hazard);
    Cell& struck = world_.cells[order_.at(cell)];
    struck.damage[hazard] += energy;
    if (struck.damage[hazard] > world_.state_of(struck).skill(declared.resistance_skill))
      kill(cell, declared.cause);
  }
  void kill(std::uint32_t cell, Id cause) override {
    Cell& killed = world_.cells[order_.at(cell)];
    if (world_.mistake == Mistake::second_cause) killed.dead = false;
    killed.kill(cause);
    dead_[cell] = 1;
  }
  [[nodiscard]] Rng rng(Id purpose, std::uint64_t entity) const override {
    constexpr std::uint64_t nobodys = ~std::uint64_t{0};
    return {world_.seed, nobodys, world_.step, stable_key(world_.schema().purposes.at(purpose)),
            entity};
  }
  [[nodiscard]] double parameter(Id parameter) const override {
    return world_.parameters.at(parameter);
  }
  void set_parameter(Id parameter, double value) override {
    world_.parameters.at(parameter) = value;
  }

 private:
  reference::World& world_;
  std::vector<std::size_t> order_;  ///< place in world_.cells of each cell that is seen
  std::vector<double> x_, y_, vx_, vy_, radius_, energy_, ambrosia_, pressure_;
  std::vector<std::uint64_t> id_;
  std::vector<std::uint16_t> state_, organism_;
  std::vector<std::uint8_t> dead_;
  Cells cells_;
  std::vector<double> force_x_, force_y_;
  std::vector<std::vector<float>> sensors_;
  std::vector<std::vector<double>> values_, skills_;
};

/// The cells of one organism and state, by their places in the world: a batch of their controller.
void control(World& world, const std::vector<std::size_t>& batch) {
  const Cell& any = world.cells[batch.front()];
  const model::Phenotype& phenotype = *world.organism_of(any).phenotype;
  const Layout& layout = phenotype.ports->layout();
  const std::size_t count = batch.size();
  const std::uint32_t memory_rows = phenotype.program->memory_per_cell();
  const auto output_rows = static_cast<std::uint32_t>(layout.outputs.size());

  // Rows of values, each a value a cell. An output that is never written is NaN.
  std::vector<float> in, memory, out(output_rows * count, std::numeric_limits<float>::quiet_NaN());
  for (std::uint32_t row = 0; row < layout.input_channels; ++row)
    for (const std::size_t i : batch) in.push_back(world.cells[i].inputs[row]);
  for (std::uint32_t row = 0; row < memory_rows; ++row)
    for (const std::size_t i : batch) memory.push_back(world.cells[i].memory[row]);

  const auto lanes = static_cast<std::uint32_t>(count);
  const Batch call{.count = lanes,
                   .organism = any.name.organism,
                   .state = any.state,
                   .in = {in.data(), layout.input_channels, lanes, count},
                   .memory = {memory.data(), memory_rows, lanes, count},
                   .out = {out.data(), output_rows, lanes, count}};
  std::uint32_t times = 1;
  if (world.step == 0) {
    phenotype.program->start(call);
    times += world.config().warm_up_steps;
  }
  for (std::uint32_t t = 0; t < times; ++t) phenotype.program->step(call);

  for (std::size_t lane = 0; lane < count; ++lane) {
    Cell& cell = world.cells[batch[lane]];
    cell.outputs.clear();
    for (std::uint32_t row = 0; row < output_rows; ++row)
      cell.outputs.push_back(out[row * count + lane]);
    for (std::uint32_t row = 0; row < memory_rows; ++row)
      cell.memory[row] = memory[row * count + lane];
  }
}

}  // namespace

void begin_environments(World& world) {
  SeenWorld seen(world);
  for (const model::NamedEnvironment& environment : world.ecosystem->environments())
    environment.instance->begin(seen);
  seen.keep(Phase::fields);
}

void act(Phase phase, World& world) {
  SeenWorld seen(world);
  for (const std::uint32_t index : world.ecosystem->acting(phase))
    world.ecosystem->environments()[index].instance->act(phase, seen);
  seen.keep(phase);
}

bool observe(World& world) {
  SeenWorld seen(world);
  return world.ecosystem->fitness().observe(seen);
}

void control(World& world) {
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<std::size_t>> batches;
  for (const std::size_t i : world.seen_order())
    batches[{world.cells[i].name.organism, world.cells[i].state}].push_back(i);
  for (const auto& [organism_and_state, batch] : batches) control(world, batch);
}

}  // namespace somas::reference
