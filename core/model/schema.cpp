#include "core/model/schema.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace somas::model {

namespace {

[[noreturn]] void clash(const std::string& instance, const char* what, std::string_view name) {
  throw std::runtime_error(instance + " declares " + what + " '" + std::string(name) +
                           "', which is declared already");
}

bool same(const SkillSpec& a, const SkillSpec& b) {
  return a.fallback == b.fallback && a.minimum == b.minimum && a.maximum == b.maximum &&
         a.cost == b.cost;
}

/// Position of `item` appended to `list`.
template <class T>
Id append(std::vector<T>& list, T item) {
  list.push_back(std::move(item));
  return static_cast<Id>(list.size() - 1);
}

void require_valid(const std::string& instance, std::string_view what, Id id, std::size_t count) {
  if (id >= count)
    throw std::runtime_error(instance + " names " + std::string(what) + " it never declared");
}

/// Whether the owner's list holds the name already.
template <class T>
bool owned(const std::vector<T>& list, std::string_view owner, std::string_view name) {
  return std::any_of(list.begin(), list.end(),
                     [&](const T& t) { return t.owner == owner && t.name == name; });
}

}  // namespace

Schema core_schema() {
  Schema schema;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  schema.skills = {
      {"capacity", {.fallback = 0, .minimum = 0, .maximum = infinity, .cost = 1}},
      // Free under a budget, as the sums of points of the paper's own states have it (section 5).
      {"diffusion", {.fallback = 1, .minimum = 0, .maximum = 1, .cost = 0}},
      {"energy_efficiency", {.fallback = 1, .minimum = 1e-3, .maximum = infinity, .cost = 0}},
  };
  schema.causes = {"starvation", "apoptosis", "outside"};
  return schema;
}

std::vector<SkillInfo> Schema::skill_infos() const {
  std::vector<SkillInfo> infos;
  for (const Skill& skill : skills) infos.push_back({skill.name, skill.spec});
  return infos;
}

Id SchemaBuilder::skill(std::string_view name, const SkillSpec& spec) {
  for (Id id = 0; id < schema_.skills.size(); ++id) {
    if (schema_.skills[id].name != name) continue;
    if (!same(schema_.skills[id].spec, spec)) clash(instance_, "another kind of skill", name);
    return id;
  }
  return append(schema_.skills, {std::string(name), spec});
}

Id SchemaBuilder::sensor(std::string_view name) {
  const auto& all = schema_.sensors;
  const bool of_the_model = name == "pressure" || name == "energy" || name == "ambrosia" ||
                            name == "specialize" || name.starts_with("morphogen.");
  const auto is_it = [name](const Sensor& other) { return other.name == name; };
  if (of_the_model || std::any_of(all.begin(), all.end(), is_it))
    clash(instance_, "a sensor", name);
  return append(schema_.sensors, {instance_, std::string(name)});
}

Id SchemaBuilder::cell_value(std::string_view name, OnDivision rule) {
  if (owned(schema_.cell_values, instance_, name)) clash(instance_, "a cell value", name);
  return append(schema_.cell_values, {instance_, std::string(name), rule});
}

Id SchemaBuilder::scalar(std::string_view name, double initial) {
  if (owned(schema_.scalars, instance_, name)) clash(instance_, "a scalar", name);
  return append(schema_.scalars, {instance_, std::string(name), initial});
}

Id SchemaBuilder::grid(std::string_view name, const GridSpec& spec) {
  if (owned(schema_.grids, instance_, name)) clash(instance_, "a grid", name);
  if (spec.columns == 0 || spec.rows == 0 || !(spec.side > 0))
    throw std::runtime_error(instance_ + ": grid '" + std::string(name) + "' has no squares");
  return append(schema_.grids, {instance_, std::string(name), spec});
}

Id SchemaBuilder::table(std::string_view name, std::span<const std::string_view> columns) {
  if (owned(schema_.tables, instance_, name)) clash(instance_, "a table", name);
  return append(schema_.tables,
                TableDeclaration{instance_, std::string(name), {columns.begin(), columns.end()}});
}

Id SchemaBuilder::hazard(std::string_view name, Id resistance_skill) {
  require_valid(instance_, "a resistance skill", resistance_skill, schema_.skills.size());
  const Id cause_id = cause(name);
  return append(schema_.hazards, {cause_id, resistance_skill});
}

Id SchemaBuilder::cause(std::string_view name) {
  const auto& all = schema_.causes;
  if (std::find(all.begin(), all.end(), name) != all.end())
    clash(instance_, "a cause of death", name);
  return append(schema_.causes, std::string(name));
}

Id SchemaBuilder::resource(std::string_view name, Id grid, Id production_skill) {
  require_valid(instance_, "a grid", grid, schema_.grids.size());
  require_valid(instance_, "a production skill", production_skill, schema_.skills.size());
  for (const Resource& r : schema_.resources) {
    if (r.name == name) clash(instance_, "a resource", name);
    // A state's points are what it takes up of one type a step; two types need two skills.
    if (r.production_skill == production_skill)
      throw std::runtime_error(instance_ + ": the skill '" + schema_.skills[production_skill].name +
                               "' already takes up the resource '" + r.name + "'; give '" +
                               std::string(name) + "' a production skill of its own");
  }
  return append(schema_.resources, {std::string(name), grid, production_skill});
}

Id SchemaBuilder::purpose(std::string_view name) {
  std::string full = instance_ + "." + std::string(name);
  const auto& all = schema_.purposes;
  if (std::find(all.begin(), all.end(), full) != all.end())
    clash(instance_, "a random purpose", name);
  return append(schema_.purposes, std::move(full));
}

Id SchemaBuilder::parameter(std::string_view name, const VariableSpec& spec) {
  if (owned(schema_.parameters, instance_, name)) clash(instance_, "a parameter", name);
  if (!std::isfinite(spec.value) || spec.value < spec.minimum || spec.value > spec.maximum)
    throw std::runtime_error(instance_ + ": the parameter '" + std::string(name) +
                             "' is outside its own range");
  return append(schema_.parameters, {instance_, std::string(name), spec, {}});
}

void SchemaBuilder::outline(std::string_view name, std::span<const Point> points, bool closed) {
  const auto finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
  if (points.size() < 2 || !std::all_of(points.begin(), points.end(), finite))
    throw std::runtime_error(instance_ + ": the outline '" + std::string(name) +
                             "' needs at least two points, all finite");
  schema_.outlines.push_back(
      {instance_, std::string(name), {points.begin(), points.end()}, closed});
}

Variable SchemaConnections::vary(std::string_view instance, std::string_view parameter) {
  std::string known;
  for (Id id = 0; id < schema_.parameters.size(); ++id) {
    VariableParameter& p = schema_.parameters[id];
    if (p.owner != instance || p.name != parameter) {
      known += (known.empty() ? "" : ", ") + p.owner + "." + p.name;
      continue;
    }
    if (!p.in_charge.empty())
      throw std::runtime_error("'" + p.owner + "." + p.name + "' is in charge of '" + p.in_charge +
                               "' already");
    p.in_charge = instance_;
    return {id, p.spec};
  }
  throw std::runtime_error("no environment has a variable parameter '" + std::string(instance) +
                           "." + std::string(parameter) +
                           "'; there are: " + (known.empty() ? std::string("none") : known));
}

}  // namespace somas::model
