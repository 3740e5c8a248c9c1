/// @file
/// The host's side of `declare` and `connect` in tests: notes what is declared, and refuses what
/// the host refuses.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "somas/sdk/specialization.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/world.hpp"

namespace somas::testing {

/// All that the instances of a test declare; an Id is a place in its list. As in the host, the
/// model's own skills and causes of death come first.
struct Declared {
  /// Of Declare::skill.
  struct Skill {
    std::string name;  ///< known to all instances
    SkillSpec spec;    ///< as declared first
  };
  /// Of Declare::sensor.
  struct Sensor {
    std::string owner;  ///< the instance that declares it
    std::string name;   ///< known to all instances
  };
  /// Of Declare::cell_value.
  struct CellValue {
    std::string owner;  ///< the instance that declares it
    std::string name;   ///< its owner's own
    OnDivision rule;    ///< as declared
  };
  /// Of Declare::scalar.
  struct Scalar {
    std::string owner;  ///< the instance that declares it
    std::string name;   ///< its owner's own
    double initial;     ///< as declared
  };
  /// Of Declare::grid.
  struct GridOf {
    std::string owner;  ///< the instance that declares it
    std::string name;   ///< its owner's own
    GridSpec spec;      ///< as declared
  };
  /// Of Declare::table.
  struct TableOf {
    std::string owner;                 ///< the instance that declares it
    std::string name;                  ///< its owner's own
    std::vector<std::string> columns;  ///< their names, in order
  };
  /// Of Declare::hazard.
  struct Hazard {
    std::string owner;    ///< the instance that declares it
    std::string name;     ///< that of the cause, too
    Id cause;             ///< of the deaths
    Id resistance_skill;  ///< what a cell can absorb
  };
  /// Of Declare::resource.
  struct Resource {
    std::string owner;    ///< the instance that declares it
    std::string name;     ///< known to all instances
    Id grid;              ///< that cells take up from
    Id production_skill;  ///< most units a step
  };
  /// Of Declare::parameter.
  struct Parameter {
    std::string owner;        ///< the instance that declares it
    std::string name;         ///< its key in the experiment
    VariableSpec spec;        ///< as declared
    std::string in_charge{};  ///< the instance that sets it; empty: nobody
  };
  /// Of Declare::outline.
  struct Outline {
    std::string owner;          ///< the instance that declares it
    std::string name;           ///< its owner's own
    std::vector<Point> points;  ///< in order
    bool closed;                ///< a polygon
  };
  /// Of Declare::acts_in.
  struct Acting {
    std::string owner;  ///< the instance that acts
    Phase phase;        ///< when it acts
  };

  /// The model's own, then those declared.
  std::vector<Skill> skills = {
      {"capacity", {}},
      {"diffusion", {.fallback = 1, .minimum = 0, .maximum = 1, .cost = 0}},
      {"energy_efficiency", {.fallback = 1, .minimum = 1e-3, .cost = 0}}};
  /// The model's own, then those declared, hazards' among them.
  std::vector<std::string> causes = {"starvation", "apoptosis", "outside"};
  std::vector<Sensor> sensors;         ///< in order of declaration
  std::vector<CellValue> cell_values;  ///< in order of declaration
  std::vector<Scalar> scalars;         ///< in order of declaration
  std::vector<GridOf> grids;           ///< in order of declaration
  std::vector<TableOf> tables;         ///< in order of declaration
  std::vector<Hazard> hazards;         ///< in order of declaration
  std::vector<Resource> resources;     ///< in order of declaration
  std::vector<std::string> purposes;   ///< "instance.name"
  std::vector<Parameter> parameters;   ///< in order of declaration
  std::vector<Outline> outlines;       ///< in order of declaration
  std::vector<Acting> acting;          ///< no pair twice

  /// Whether that instance acts in that phase.
  [[nodiscard]] bool acts(std::string_view owner, Phase phase) const {
    return std::any_of(acting.begin(), acting.end(),
                       [&](const Acting& a) { return a.owner == owner && a.phase == phase; });
  }
  /// One line a declaration, in order, every number exact: equal declarations are equal lines.
  [[nodiscard]] std::vector<std::string> lines() const;
};

/// Notes the declarations of one instance. Throws std::runtime_error where the host does: a name
/// that is taken, a grid without squares, a parameter outside its own range ...
class TestDeclare final : public Declare {
 public:
  /// `declared` takes the declarations; it must outlive this. `instance` is the name of the one
  /// that declares, `info` what it is told of the experiment.
  TestDeclare(Declared& declared, const WorldInfo& info, std::string instance)
      : declared_(declared), info_(info), instance_(std::move(instance)) {}

  [[nodiscard]] const WorldInfo& world() const override { return info_; }
  [[nodiscard]] std::string_view instance() const override { return instance_; }
  void acts_in(Phase phase) override {
    if (!declared_.acts(instance_, phase)) declared_.acting.push_back({instance_, phase});
  }
  Id skill(std::string_view name, const SkillSpec& spec) override {
    for (Id id = 0; id < declared_.skills.size(); ++id) {
      if (declared_.skills[id].name != name) continue;
      const SkillSpec& known = declared_.skills[id].spec;
      if (known.fallback != spec.fallback || known.minimum != spec.minimum ||
          known.maximum != spec.maximum || known.cost != spec.cost)
        clash("another kind of skill", name);
      return id;
    }
    return append(declared_.skills, {std::string(name), spec});
  }
  Id sensor(std::string_view name) override {
    const bool of_the_model = name == "pressure" || name == "energy" || name == "ambrosia" ||
                              name == "specialize" || name.starts_with("morphogen.");
    const auto taken = [&](const Declared::Sensor& s) { return s.name == name; };
    if (of_the_model || any(declared_.sensors, taken)) clash("a sensor", name);
    return append(declared_.sensors, {instance_, std::string(name)});
  }
  Id cell_value(std::string_view name, OnDivision rule) override {
    refuse_own(declared_.cell_values, "a cell value", name);
    return append(declared_.cell_values, {instance_, std::string(name), rule});
  }
  Id scalar(std::string_view name, double initial) override {
    refuse_own(declared_.scalars, "a scalar", name);
    return append(declared_.scalars, {instance_, std::string(name), initial});
  }
  Id grid(std::string_view name, const GridSpec& spec) override {
    refuse_own(declared_.grids, "a grid", name);
    if (spec.columns == 0 || spec.rows == 0 || !(spec.side > 0))
      throw std::runtime_error(instance_ + ": grid '" + std::string(name) + "' has no squares");
    return append(declared_.grids, {instance_, std::string(name), spec});
  }
  Id table(std::string_view name, std::span<const std::string_view> columns) override {
    refuse_own(declared_.tables, "a table", name);
    return append(declared_.tables,
                  {instance_, std::string(name), {columns.begin(), columns.end()}});
  }
  Id hazard(std::string_view name, Id resistance_skill) override {
    require_declared("a resistance skill", resistance_skill, declared_.skills.size());
    const Id cause_id = cause(name);
    return append(declared_.hazards, {instance_, std::string(name), cause_id, resistance_skill});
  }
  Id cause(std::string_view name) override {
    if (any(declared_.causes, [&](const std::string& c) { return c == name; }))
      clash("a cause of death", name);
    return append(declared_.causes, std::string(name));
  }
  Id resource(std::string_view name, Id grid, Id production_skill) override {
    require_declared("a grid", grid, declared_.grids.size());
    require_declared("a production skill", production_skill, declared_.skills.size());
    for (const Declared::Resource& r : declared_.resources) {
      if (r.name == name) clash("a resource", name);
      if (r.production_skill == production_skill)
        throw std::runtime_error(instance_ + ": the production skill of '" + std::string(name) +
                                 "' already takes up the resource '" + r.name + "'");
    }
    return append(declared_.resources, {instance_, std::string(name), grid, production_skill});
  }
  Id purpose(std::string_view name) override {
    const std::string full = instance_ + "." + std::string(name);
    if (any(declared_.purposes, [&](const std::string& p) { return p == full; }))
      clash("a random purpose", name);
    return append(declared_.purposes, full);
  }
  Id parameter(std::string_view name, const VariableSpec& spec) override {
    refuse_own(declared_.parameters, "a parameter", name);
    if (!std::isfinite(spec.value) || spec.value < spec.minimum || spec.value > spec.maximum)
      throw std::runtime_error(instance_ + ": the parameter '" + std::string(name) +
                               "' is outside its own range");
    return append(declared_.parameters, {instance_, std::string(name), spec});
  }
  void outline(std::string_view name, std::span<const Point> points, bool closed) override {
    const auto finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
    if (points.size() < 2 || !std::all_of(points.begin(), points.end(), finite))
      throw std::runtime_error(instance_ + ": the outline '" + std::string(name) +
                               "' needs at least two points, all finite");
    declared_.outlines.push_back(
        {instance_, std::string(name), {points.begin(), points.end()}, closed});
  }

 private:
  template <class T, class Wanted>
  static bool any(const std::vector<T>& list, Wanted wanted) {
    return std::any_of(list.begin(), list.end(), wanted);
  }
  template <class T>
  static Id append(std::vector<T>& list, T item) {
    list.push_back(std::move(item));
    return static_cast<Id>(list.size() - 1);
  }
  [[noreturn]] void clash(const char* what, std::string_view name) const {
    throw std::runtime_error(instance_ + " declares " + what + " '" + std::string(name) +
                             "', which is declared already");
  }
  template <class T>
  void refuse_own(const std::vector<T>& list, const char* what, std::string_view name) const {
    if (any(list, [&](const T& t) { return t.owner == instance_ && t.name == name; }))
      clash(what, name);
  }
  void require_declared(const char* what, Id id, std::size_t count) const {
    if (id >= count) throw std::runtime_error(instance_ + " names " + what + " it never declared");
  }

  Declared& declared_;
  WorldInfo info_;
  std::string instance_;
};

/// Gives the variable parameters in `declared` to those who ask, each to one instance.
class TestConnections final : public Connections {
 public:
  /// `declared` must outlive this; `instance` is the name of the one that asks.
  TestConnections(Declared& declared, std::string instance)
      : declared_(declared), instance_(std::move(instance)) {}

  Variable vary(std::string_view instance, std::string_view parameter) override {
    std::string known;
    for (Id id = 0; id < declared_.parameters.size(); ++id) {
      Declared::Parameter& p = declared_.parameters[id];
      if (p.owner != instance || p.name != parameter) {
        known += (known.empty() ? "" : ", ") + p.owner + "." + p.name;
        continue;
      }
      if (!p.in_charge.empty())
        throw std::runtime_error("'" + p.owner + "." + p.name + "' is in charge of '" +
                                 p.in_charge + "' already");
      p.in_charge = instance_;
      return {id, p.spec};
    }
    throw std::runtime_error("no environment has a variable parameter '" + std::string(instance) +
                             "." + std::string(parameter) +
                             "'; there are: " + (known.empty() ? std::string("none") : known));
  }

 private:
  Declared& declared_;
  std::string instance_;
};

namespace detail {

/// Words of one line, numbers exact.
class Line {
 public:
  explicit Line(const char* kind) : text_(kind) {}
  Line& operator<<(std::string_view word) {
    text_ += ' ';
    text_ += word;
    return *this;
  }
  Line& operator<<(double number) { return *this << std::string_view(text_of(number)); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace detail

inline std::vector<std::string> Declared::lines() const {
  std::vector<std::string> all;
  const auto put = [&](const detail::Line& line) { all.push_back(line.text()); };
  using detail::Line;
  for (const Acting& a : acting) put(Line("phase") << a.owner << static_cast<double>(a.phase));
  for (const Skill& s : skills)
    put(Line("skill") << s.name << s.spec.fallback << s.spec.minimum << s.spec.maximum
                      << s.spec.cost);
  for (const std::string& c : causes) put(Line("cause") << c);
  for (const Sensor& s : sensors) put(Line("sensor") << s.owner << s.name);
  for (const CellValue& v : cell_values)
    put(Line("cell value") << v.owner << v.name << static_cast<double>(v.rule));
  for (const Scalar& s : scalars) put(Line("scalar") << s.owner << s.name << s.initial);
  for (const GridOf& g : grids)
    put(Line("grid") << g.owner << g.name << g.spec.columns << g.spec.rows << g.spec.side
                     << g.spec.left << g.spec.bottom << g.spec.initial);
  for (const TableOf& t : tables) {
    Line line("table");
    line << t.owner << t.name;
    for (const std::string& column : t.columns) line << column;
    put(line);
  }
  for (const Hazard& h : hazards)
    put(Line("hazard") << h.owner << h.name << h.cause << h.resistance_skill);
  for (const Resource& r : resources)
    put(Line("resource") << r.owner << r.name << r.grid << r.production_skill);
  for (const std::string& p : purposes) put(Line("purpose") << p);
  for (const Parameter& p : parameters)
    put(Line("parameter") << p.owner << p.name << p.spec.value << p.spec.minimum << p.spec.maximum
                          << p.in_charge);
  for (const Outline& o : outlines) {
    Line line("outline");
    line << o.owner << o.name << (o.closed ? "closed" : "open");
    for (const Point& p : o.points) line << p.x << p.y;
    put(line);
  }
  return all;
}

}  // namespace somas::testing
