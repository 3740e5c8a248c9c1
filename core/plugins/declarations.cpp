#include "core/plugins/declarations.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <vector>

#include "core/model/config.hpp"
#include "core/model/schema.hpp"
#include "core/plugins/example.hpp"
#include "core/plugins/suggest.hpp"

namespace somas::plugins {
namespace {

constexpr const char* phase_names[] = {"fields", "sense", "forces", "stress", "parameters"};
constexpr const char* division_texts[] = {"copied at division", "halved at division",
                                          "0 in a daughter"};

/// Rows of a table.
class Rows {
 public:
  void add(const std::string& what, const std::string& name, const std::string& more = {}) {
    text_ += "| " + what + " | `" + name + "` | " + more + " |\n";
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string number(double value) { return format_number(value); }

std::string range_of(double minimum, double maximum) {
  ParameterInfo info;
  info.minimum = minimum;
  info.maximum = maximum;
  return range_text(info);
}

std::string with_range(std::string text, double minimum, double maximum) {
  const std::string range = range_of(minimum, maximum);
  return range.empty() ? text : text.append(", ").append(range);
}

std::string grid_text(const GridSpec& grid) {
  return std::to_string(grid.columns) + " x " + std::to_string(grid.rows) + " squares of side " +
         number(grid.side) + ", from x = " + number(grid.left) + ", y = " + number(grid.bottom) +
         "; " + number(grid.initial) + " at the start";
}

/// All that stands in `schema` beyond what the model itself brings.
std::string rows_of(const model::Schema& schema, unsigned phases) {
  const model::Schema core = model::core_schema();
  Rows rows;
  for (unsigned p = 0; p < model::phase_count; ++p)
    if ((phases >> p & 1u) != 0)
      rows.add("phase", phase_names[p], p == 2 ? "every substep" : "every step");
  for (std::size_t i = core.skills.size(); i < schema.skills.size(); ++i) {
    const model::Skill& skill = schema.skills[i];
    rows.add("skill", skill.name,
             with_range("default " + number(skill.spec.fallback), skill.spec.minimum,
                        skill.spec.maximum) +
                 "; costs " + number(skill.spec.cost) + " of a budget");
  }
  for (const model::Sensor& sensor : schema.sensors)
    rows.add("sensor", sensor.name, "an input of every state's controller");
  for (const model::Resource& resource : schema.resources)
    rows.add("resource", resource.name,
             "output `uptake." + resource.name + "`; from grid `" +
                 schema.grids[resource.grid].name + "`, at most the points in `" +
                 schema.skills[resource.production_skill].name + "` a step");
  std::vector<bool> of_hazard(schema.causes.size(), false);
  for (const model::Hazard& hazard : schema.hazards) {
    of_hazard[hazard.cause] = true;
    rows.add("hazard", schema.causes[hazard.cause],
             "a cause of death, when more is absorbed than the points in `" +
                 schema.skills[hazard.resistance_skill].name + "`");
  }
  for (std::size_t i = core.causes.size(); i < schema.causes.size(); ++i)
    if (!of_hazard[i]) rows.add("cause", schema.causes[i], "a cause of death");
  for (const model::VariableParameter& p : schema.parameters)
    rows.add("variable parameter", p.name,
             with_range("others may vary it from " + number(p.spec.value), p.spec.minimum,
                        p.spec.maximum));
  for (const model::GridDeclaration& grid : schema.grids)
    rows.add("grid", grid.name, grid_text(grid.spec));
  for (const model::TableDeclaration& table : schema.tables)
    rows.add("table", table.name, "columns " + join(table.columns));
  for (const model::Scalar& scalar : schema.scalars)
    rows.add("scalar", scalar.name, number(scalar.initial) + " at the start");
  for (const model::CellValue& value : schema.cell_values)
    rows.add("cell value", value.name, division_texts[static_cast<unsigned>(value.rule)]);
  for (const std::string& purpose : schema.purposes)
    rows.add("random purpose", purpose.substr(purpose.find('.') + 1));
  return rows.text();
}

/// Where the reference's instances are: a world of the model's defaults.
WorldInfo usual_world() {
  const model::Config config;
  return {.radius = config.radius,
          .max_steps = config.max_steps,
          .substeps = config.mechanics.substeps,
          .time_step = config.mechanics.time_step};
}

std::string table_of(const std::string& rows) {
  if (rows.empty()) return "It declares nothing.\n";
  return "| what | name | more |\n|---|---|---|\n" + rows;
}

std::string asked(const PluginClass& described, const ParameterValue& values) {
  model::Schema schema = model::core_schema();
  switch (described.info->kind) {
    case PluginKind::environment: {
      model::SchemaBuilder builder(schema, usual_world(), described.id());
      described.create<Environment>(values)->declare(builder);
      return table_of(rows_of(schema, builder.phases()));
    }
    case PluginKind::fitness: {
      model::SchemaBuilder builder(schema, usual_world(), "fitness");
      const std::shared_ptr<Fitness> fitness = described.create<Fitness>(values);
      fitness->declare(builder);
      const std::string objective = "Its objective is `" + std::string(fitness->objective()) + "`.";
      const std::string rows = rows_of(schema, builder.phases());
      return objective + "\n" + (rows.empty() ? "" : "\n" + table_of(rows));
    }
    case PluginKind::specialization:
      return described.create<Specialization>(values)->heritable() != nullptr
                 ? "The tree evolves: it is part of the genome.\n"
                 : "The tree is fixed: it is the same for all genomes.\n";
    case PluginKind::controller:
      break;
  }
  return {};
}

}  // namespace

std::string declarations(const PluginClass& described) {
  if (described.info->kind == PluginKind::controller) return {};
  const ParameterValue values = example_of(described.parameters());
  std::string said;
  try {
    said = asked(described, values);
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    said = "It refuses them: " + std::string(error.what()) + ".\n";
  } catch (...) {
    said = "It refuses them, with an exception that is no std::exception.\n";
  }
  if (described.parameters().empty()) return said;
  const bool examples = std::any_of(described.parameters().begin(), described.parameters().end(),
                                    [](const ParameterInfo& info) { return info.required != 0; });
  return (examples ? "With the defaults, and with what is required as above:\n\n"
                   : "With the defaults:\n\n") +
         said;
}

}  // namespace somas::plugins
