// A host of one environment without a model behind it: it keeps what the environment declares,
// places cells where a test wants them, and notes what the environment does to them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "somas/sdk/environment.hpp"
#include "somas/sdk/parameters.hpp"
#include "somas/sdk/workers.hpp"

namespace somas::environments {

/// Notes every declaration.
class FakeDeclare final : public Declare {
 public:
  struct Resource {
    std::string name;
    Id grid;
    Id skill;
  };
  struct Hazard {
    std::string name;
    Id skill;
  };

  explicit FakeDeclare(const WorldInfo& info, std::string instance)
      : info_(info), instance_(std::move(instance)) {}

  const WorldInfo& world() const override { return info_; }
  std::string_view instance() const override { return instance_; }
  void acts_in(Phase phase) override { phases.insert(phase); }
  Id skill(std::string_view name, const SkillSpec& spec) override {
    skill_specs.push_back(spec);
    return append(skills, name);
  }
  Id sensor(std::string_view name) override { return append(sensors, name); }
  Id cell_value(std::string_view, OnDivision) override { return no_id; }
  Id scalar(std::string_view, double initial) override {
    scalars.push_back(initial);
    return static_cast<Id>(scalars.size() - 1);
  }
  Id grid(std::string_view, const GridSpec& spec) override {
    grids.push_back(spec);
    return static_cast<Id>(grids.size() - 1);
  }
  Id table(std::string_view, std::span<const std::string_view> columns) override {
    tables.emplace_back(columns.begin(), columns.end());
    return static_cast<Id>(tables.size() - 1);
  }
  Id hazard(std::string_view name, Id skill) override {
    hazards.push_back({std::string(name), skill});
    return static_cast<Id>(hazards.size() - 1);
  }
  Id cause(std::string_view) override { return no_id; }
  Id resource(std::string_view name, Id grid, Id skill) override {
    resources.push_back({std::string(name), grid, skill});
    return static_cast<Id>(resources.size() - 1);
  }
  Id purpose(std::string_view name) override { return append(purposes, name); }
  Id parameter(std::string_view name, const VariableSpec& spec) override {
    parameters.push_back(spec);
    return append(parameter_names, name);
  }
  void outline(std::string_view name, std::span<const Point> points, bool closed) override {
    outlines.push_back({std::string(name), {points.begin(), points.end()}, closed});
  }

  struct Outline {
    std::string name;
    std::vector<Point> points;
    bool closed;
  };
  std::set<Phase> phases;
  std::vector<std::string> skills, sensors, purposes;
  std::vector<SkillSpec> skill_specs;
  std::vector<double> scalars;
  std::vector<GridSpec> grids;
  std::vector<std::vector<std::string>> tables;
  std::vector<Hazard> hazards;
  std::vector<Resource> resources;
  std::vector<std::string> parameter_names;
  std::vector<VariableSpec> parameters;
  std::vector<Outline> outlines;

 private:
  static Id append(std::vector<std::string>& list, std::string_view name) {
    list.emplace_back(name);
    return static_cast<Id>(list.size() - 1);
  }

  WorldInfo info_;
  std::string instance_;
};

class FakeTable final : public Table {
 public:
  explicit FakeTable(std::size_t columns) : columns_(columns) {}
  std::uint32_t rows() const override { return static_cast<std::uint32_t>(columns_[0].size()); }
  std::span<double> column(Id column) override { return columns_.at(column); }
  void resize(std::uint32_t rows) override {
    for (auto& column : columns_) column.resize(rows);
  }

 private:
  std::vector<std::vector<double>> columns_;
};

struct FakeCell {
  double x = 0, y = 0;
  double radius = 1;
  std::uint64_t id = 0;
  double vx = 0, vy = 0;
  bool dead = false;
};

/// What an environment did to a cell.
struct Strike {
  std::uint64_t cell_id;
  double energy;
  bool operator==(const Strike&) const = default;
};

class FakeWorld final : public World {
 public:
  FakeWorld(const WorldInfo& info, std::uint64_t seed, const FakeDeclare& declared,
            const std::vector<FakeCell>& cells = {})
      : info_(info), seed_(seed), specs_(declared.grids), scalars_(declared.scalars) {
    for (const GridSpec& spec : specs_)
      grids_.emplace_back(std::size_t{spec.columns} * spec.rows, spec.initial);
    for (const auto& columns : declared.tables) tables_.emplace_back(columns.size());
    for (const VariableSpec& spec : declared.parameters) parameters.push_back(spec.value);
    sensors_.resize(declared.sensors.size());
    place(cells);
  }

  void place(const std::vector<FakeCell>& cells) {
    x_.clear(), y_.clear(), radius_.clear(), id_.clear();
    vx_.clear(), vy_.clear(), dead_.clear();
    for (const FakeCell& cell : cells) {
      x_.push_back(cell.x);
      y_.push_back(cell.y);
      radius_.push_back(cell.radius);
      id_.push_back(cell.id);
      vx_.push_back(cell.vx);
      vy_.push_back(cell.vy);
      dead_.push_back(cell.dead ? 1 : 0);
    }
    force_x_.assign(cells.size(), 0.0);
    force_y_.assign(cells.size(), 0.0);
    for (auto& sensor : sensors_) sensor.assign(cells.size(), -1.0f);
    cells_.count = static_cast<std::uint32_t>(cells.size());
    cells_.x = x_;
    cells_.y = y_;
    cells_.radius = radius_;
    cells_.id = id_;
    cells_.vx = vx_;
    cells_.vy = vy_;
    cells_.dead = dead_;
  }
  void set_step(std::uint64_t step) { step_ = step; }

  void* extension(std::string_view id) const override {
    return id == Workers::extension_id ? workers : nullptr;
  }

  std::uint64_t step() const override { return step_; }
  const WorldInfo& info() const override { return info_; }
  const Cells& cells() const override { return cells_; }
  std::span<float> sensor(Id sensor) override { return sensors_.at(sensor); }
  std::span<const double> skill(Id) override { return {}; }
  std::span<double> cell_value(Id) override { return {}; }
  double& scalar(Id scalar) override { return scalars_.at(scalar); }
  Grid grid(Id grid) override { return {grids_.at(grid), specs_.at(grid)}; }
  Table& table(Id table) override { return tables_.at(table); }
  std::span<double> force_x() override { return force_x_; }
  std::span<double> force_y() override { return force_y_; }
  void first_hit(std::span<const Segment> segments, std::span<std::int32_t> cells) override {
    ++first_hit_calls;
    for (std::size_t i = 0; i < segments.size(); ++i) cells[i] = first_cell(segments[i]);
  }
  void strike(std::uint32_t cell, Id, double energy) override {
    strikes.push_back({id_.at(cell), energy});
  }
  void kill(std::uint32_t, Id) override { FAIL() << "nobody asked for it"; }
  Rng rng(Id purpose, std::uint64_t entity) const override {
    return Rng(seed_, 0, step_, purpose, entity);
  }
  double parameter(Id parameter) const override { return parameters.at(parameter); }
  void set_parameter(Id parameter, double value) override { parameters.at(parameter) = value; }

  Workers* workers = nullptr;      ///< who shares the work; null: nobody
  std::vector<double> parameters;  ///< what each variable parameter is now
  std::vector<Strike> strikes;
  int first_hit_calls = 0;

 private:
  /// Share of the segment before it meets the disc; infinity if it does not.
  static double meeting(const Segment& s, double x, double y, double radius) {
    const double dx = s.x1 - s.x0, dy = s.y1 - s.y0, ox = s.x0 - x, oy = s.y0 - y;
    const double a = dx * dx + dy * dy, b = ox * dx + oy * dy;
    const double c = ox * ox + oy * oy - radius * radius;
    if (c <= 0) return 0;
    const double discriminant = b * b - a * c;
    if (a == 0 || discriminant < 0) return std::numeric_limits<double>::infinity();
    const double share = (-b - std::sqrt(discriminant)) / a;
    return share >= 0 && share <= 1 ? share : std::numeric_limits<double>::infinity();
  }

  std::int32_t first_cell(const Segment& segment) const {
    std::int32_t best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < cells_.count; ++i) {
      const double share = meeting(segment, x_[i], y_[i], radius_[i]);
      if (share > 1 || share > least || (share == least && id_[i] > id_[best])) continue;
      best = static_cast<std::int32_t>(i);
      least = share;
    }
    return best;
  }

  WorldInfo info_;
  std::uint64_t seed_;
  std::uint64_t step_ = 0;
  std::vector<GridSpec> specs_;
  std::vector<double> scalars_;
  std::vector<std::vector<double>> grids_;
  std::vector<FakeTable> tables_;
  std::vector<std::vector<float>> sensors_;
  std::vector<double> x_, y_, radius_, vx_, vy_, force_x_, force_y_;
  std::vector<std::uint8_t> dead_;
  std::vector<std::uint64_t> id_;
  Cells cells_;
};

/// An environment, declared, in a world of its own.
template <class Environment>
struct Stage {
  explicit Stage(const typename Environment::Parameters& parameters, std::uint64_t seed = 1,
                 const std::vector<FakeCell>& cells = {}, std::uint64_t max_steps = 3000)
      : info{60, max_steps, 3, 1.0 / 30},
        environment(parameters),
        declared(info, "it"),
        world(info, seed, declare(), cells) {
    environment.begin(world);
  }

  /// One step of the world: every phase that the environment acts in.
  void step(std::uint64_t number) {
    world.set_step(number);
    for (const Phase phase : declared.phases) environment.act(phase, world);
  }

  WorldInfo info;
  Environment environment;
  FakeDeclare declared;
  FakeWorld world;

 private:
  const FakeDeclare& declare() {
    environment.declare(declared);
    return declared;
  }
};

/// The path and message of the ParameterError that `wire` throws.
template <class Wire>
std::pair<std::string, std::string> refusal(Wire wire) {
  try {
    wire();
  } catch (const ParameterError& error) {
    return {error.path(), error.what()};
  }
  return {"", "no refusal"};
}

/// Names of the parameters that a plugin class describes.
template <class Parameters>
std::vector<std::string> parameter_names() {
  Parameters parameters;
  Describe d;
  parameters.describe(d);
  std::vector<std::string> names;
  for (const ParameterInfo& info : d.parameters()) names.emplace_back(info.name);
  return names;
}

}  // namespace somas::environments
