// What the model itself and the environments declare: the vocabulary of an experiment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "somas/sdk/specialization.hpp"
#include "somas/sdk/world.hpp"

#include "core/model/config.hpp"

namespace somas::model {

/// Skills of the model itself come first, in this order; environments' skills follow.
enum CoreSkill : Id { skill_capacity = 0, skill_diffusion = 1, skill_energy_efficiency = 2 };

/// Causes of death of the model itself come first; hazards and causes of environments follow.
enum CoreCause : Id { cause_starvation = 0, cause_apoptosis = 1, cause_outside = 2 };
inline constexpr Id no_cause = no_id;

inline constexpr std::size_t phase_count = 5;

struct Skill {
  std::string name;
  SkillSpec spec;
};

struct Sensor {
  std::string owner, name;
};

struct CellValue {
  std::string owner, name;
  OnDivision rule;
};

struct Scalar {
  std::string owner, name;
  double initial;
};

struct VariableParameter {
  std::string owner, name;
  VariableSpec spec;
  std::string in_charge;  ///< instance that sets it; empty: nobody
};

/// For pictures.
struct Outline {
  std::string owner, name;
  std::vector<Point> points;
  bool closed;
};

struct GridDeclaration {
  std::string owner, name;
  GridSpec spec;
};

struct TableDeclaration {
  std::string owner, name;
  std::vector<std::string> columns;
};

/// A cause of death that acts by absorbed energy.
struct Hazard {
  Id cause;
  Id resistance_skill;
};

struct Resource {
  std::string name;
  Id grid;
  Id production_skill;
};

struct Schema {
  std::vector<Skill> skills;
  std::vector<Sensor> sensors;
  std::vector<CellValue> cell_values;
  std::vector<Scalar> scalars;
  std::vector<GridDeclaration> grids;
  std::vector<TableDeclaration> tables;
  std::vector<std::string> causes;
  std::vector<Hazard> hazards;
  std::vector<Resource> resources;
  std::vector<std::string> purposes;  ///< "owner.name"; the stream's name is its stable_key
  std::vector<VariableParameter> parameters;
  std::vector<Outline> outlines;

  [[nodiscard]] std::vector<SkillInfo> skill_infos() const;
};

/// Whether the squares of a grid cover the whole disc of that radius about the origin.
[[nodiscard]] inline bool covers(const GridSpec& grid, double radius) {
  return grid.left <= -radius && grid.bottom <= -radius &&
         grid.left + grid.columns * grid.side >= radius &&
         grid.bottom + grid.rows * grid.side >= radius;
}

/// The vocabulary before any environment spoke.
[[nodiscard]] Schema core_schema();

/// The host's side of `Declare` for one instance. Throws std::runtime_error on a clash.
class SchemaBuilder final : public Declare {
 public:
  SchemaBuilder(Schema& schema, const WorldInfo& info, std::string instance)
      : schema_(schema), info_(info), instance_(std::move(instance)) {}

  [[nodiscard]] const WorldInfo& world() const override { return info_; }
  [[nodiscard]] std::string_view instance() const override { return instance_; }
  void acts_in(Phase phase) override { phases_ |= 1u << static_cast<unsigned>(phase); }
  Id skill(std::string_view name, const SkillSpec& spec) override;
  Id sensor(std::string_view name) override;
  Id cell_value(std::string_view name, OnDivision rule) override;
  Id scalar(std::string_view name, double initial) override;
  Id grid(std::string_view name, const GridSpec& spec) override;
  Id table(std::string_view name, std::span<const std::string_view> columns) override;
  Id hazard(std::string_view name, Id resistance_skill) override;
  Id cause(std::string_view name) override;
  Id resource(std::string_view name, Id grid, Id production_skill) override;
  Id purpose(std::string_view name) override;
  Id parameter(std::string_view name, const VariableSpec& spec) override;
  void outline(std::string_view name, std::span<const Point> points, bool closed) override;

  /// Bit p set: the instance acts in Phase p.
  [[nodiscard]] unsigned phases() const { return phases_; }

 private:
  Schema& schema_;
  WorldInfo info_;
  std::string instance_;
  unsigned phases_ = 0;
};

/// The host's side of `Connections` for one instance.
class SchemaConnections final : public Connections {
 public:
  SchemaConnections(Schema& schema, std::string instance)
      : schema_(schema), instance_(std::move(instance)) {}
  Variable vary(std::string_view instance, std::string_view parameter) override;

 private:
  Schema& schema_;
  std::string instance_;
};

}  // namespace somas::model
