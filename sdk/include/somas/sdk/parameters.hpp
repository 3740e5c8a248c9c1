// Typed parameters of a plugin class.
//
// A plugin keeps its parameters in a plain struct whose initialisers are the defaults, with a
// member `describe` that names each one:
//
//   struct Parameters {
//     double rate = 1.0;
//     std::string mode = "peak";
//     void describe(somas::Describe& d) {
//       d("rate", rate, "Particles a step", {.unit = "1/step", .minimum = 0});
//       d.choice("mode", mode, {"peak", "share"}, "How to weigh");
//     }
//   };
//
// The same function serves twice: to list the parameters for the host (which validates the YAML
// against the list, prints and documents it), and to read the host's values back into the struct.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "somas/sdk/types.hpp"

namespace somas {

/// Kinds of parameters; the numbers are part of the ABI.
enum class ParameterKind : std::uint32_t {
  none = 0,     ///< no value given (an optional parameter left out)
  number = 1,   ///< double; never NaN
  integer = 2,  ///< 64-bit signed
  boolean = 3,  ///< in Value::integer, 0 or 1
  text = 4,     ///< UTF-8, NUL-terminated
  choice = 5,   ///< text, one of ParameterInfo::choices
  list = 6,     ///< of one element kind, described by fields[0]
  group = 7,    ///< named fields, described by fields
  table = 8,    ///< free keys -> numbers (skills of a state, say)
};

/// A value as it crosses the boundary: plain data, owned by the host, valid during `create` only.
struct Value {
  ParameterKind kind = ParameterKind::none;
  std::uint32_t reserved = 0;
  double number = 0;
  std::int64_t integer = 0;
  const char* text = nullptr;
  const char* key = nullptr;     ///< name within the enclosing group or table
  const Value* items = nullptr;  ///< list elements, group fields, table entries
  std::uint64_t count = 0;
};

/// One parameter as it crosses the boundary: plain data, owned by the plugin, valid while loaded.
struct ParameterInfo {
  std::uint32_t size = sizeof(ParameterInfo);
  ParameterKind kind = ParameterKind::none;
  const char* name = "";
  const char* unit = "";
  const char* doc = "";
  Value fallback{};                ///< the default; kind none: required, or optional and left out
  std::uint32_t required = 0;      ///< 1: the YAML must give it
  std::uint32_t minimum_open = 0;  ///< 1: the minimum itself is not allowed
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  const char* const* choices = nullptr;
  std::uint64_t choice_count = 0;
  const ParameterInfo* fields = nullptr;  ///< group: its fields; list: one, its element
  std::uint64_t field_count = 0;
};

/// What may be said of a numeric parameter beside its doc.
struct Limits {
  const char* unit = "";
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_open =
      false;  ///< exclude the minimum: `{.minimum = 0, .minimum_open = true}` is > 0
  bool required = false;
};

class Describe;

/// A struct with `void describe(Describe&)`: the shape of Parameters and of groups inside it.
template <class T>
concept Described = requires(T t, Describe& d) {
  t.describe(d);
};

/// The visitor that a `describe` member is called with. Names and docs must be string literals.
class Describe {
 public:
  /// Collects: afterwards `parameters()` lists what was described, defaults from the struct.
  Describe() = default;
  /// Reads: every described member is set from the group `values`.
  explicit Describe(const Value& values) : values_(&values) {}

  void operator()(const char* name, double& member, const char* doc, const Limits& limits = {});
  void operator()(const char* name, std::optional<double>& member, const char* doc,
                  const Limits& limits = {});
  void operator()(const char* name, std::int64_t& member, const char* doc,
                  const Limits& limits = {});
  void operator()(const char* name, bool& member, const char* doc);
  void operator()(const char* name, std::string& member, const char* doc,
                  const Limits& limits = {});
  void operator()(const char* name, std::vector<double>& member, const char* doc,
                  const Limits& limits = {});
  /// A string out of a fixed set.
  void choice(const char* name, std::string& member, std::initializer_list<const char*> allowed,
              const char* doc);
  /// Free keys with numbers.
  void table(const char* name, std::map<std::string, double>& member, const char* doc,
             const Limits& limits = {});
  /// A nested group.
  template <Described T>
  void group(const char* name, T& member, const char* doc);
  /// A list of groups; the element's own defaults fill what an element leaves out.
  template <Described T>
  void list(const char* name, std::vector<T>& member, const char* doc, bool required = false);

  /// The collected list; valid as long as this object lives.
  [[nodiscard]] const std::vector<ParameterInfo>& parameters() const { return infos_; }

 private:
  [[nodiscard]] bool reading() const { return values_ != nullptr; }
  [[nodiscard]] const Value* find(std::string_view name) const {
    for (std::uint64_t i = 0; i < values_->count; ++i)
      if (name == values_->items[i].key) return &values_->items[i];
    return nullptr;
  }
  ParameterInfo& add(ParameterKind kind, const char* name, const char* doc, const Limits& limits) {
    ParameterInfo info;
    info.kind = kind;
    info.name = name;
    info.unit = limits.unit;
    info.doc = doc;
    info.minimum = limits.minimum;
    info.maximum = limits.maximum;
    info.minimum_open = limits.minimum_open ? 1 : 0;
    info.required = limits.required ? 1 : 0;
    if (!limits.required) info.fallback.kind = kind;
    infos_.push_back(info);
    return infos_.back();
  }
  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }
  /// What `described` describes as one group value: every field with its default.
  Value group_of_defaults(const Describe& described) {
    auto& fields = values_of_lists_.emplace_back();
    for (const ParameterInfo& info : described.infos_) {
      if (info.fallback.kind == ParameterKind::none) continue;
      fields.push_back(info.fallback);
      fields.back().key = info.name;
    }
    Value group;
    group.kind = ParameterKind::group;
    group.items = fields.data();
    group.count = fields.size();
    return group;
  }

  const Value* values_ = nullptr;
  std::vector<ParameterInfo> infos_;
  // Storage that the infos point into; deques and unique_ptrs keep addresses stable.
  std::deque<std::string> texts_;
  std::deque<std::vector<const char*>> choices_;
  std::deque<std::vector<Value>> values_of_lists_;
  std::deque<std::unique_ptr<Describe>> nested_;
};

inline void Describe::operator()(const char* name, double& member, const char* doc,
                                 const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::number) member = v->number;
    return;
  }
  add(ParameterKind::number, name, doc, limits).fallback.number = member;
}

inline void Describe::operator()(const char* name, std::optional<double>& member, const char* doc,
                                 const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::number) member = v->number;
    return;
  }
  ParameterInfo& info = add(ParameterKind::number, name, doc, limits);
  info.fallback.kind = member ? ParameterKind::number : ParameterKind::none;
  info.fallback.number = member.value_or(0);
}

inline void Describe::operator()(const char* name, std::int64_t& member, const char* doc,
                                 const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::integer) member = v->integer;
    return;
  }
  add(ParameterKind::integer, name, doc, limits).fallback.integer = member;
}

inline void Describe::operator()(const char* name, bool& member, const char* doc) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::boolean)
      member = v->integer != 0;
    return;
  }
  add(ParameterKind::boolean, name, doc, {}).fallback.integer = member ? 1 : 0;
}

inline void Describe::operator()(const char* name, std::string& member, const char* doc,
                                 const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::text) member = v->text;
    return;
  }
  const char* text = keep(member);
  add(ParameterKind::text, name, doc, limits).fallback.text = text;
}

inline void Describe::operator()(const char* name, std::vector<double>& member, const char* doc,
                                 const Limits& limits) {
  if (reading()) {
    const Value* v = find(name);
    if (v == nullptr || v->kind != ParameterKind::list) return;
    member.clear();
    for (std::uint64_t i = 0; i < v->count; ++i) member.push_back(v->items[i].number);
    return;
  }
  auto& kept = values_of_lists_.emplace_back();
  for (const double x : member) {
    Value item;
    item.kind = ParameterKind::number;
    item.number = x;
    kept.push_back(item);
  }
  auto& element = nested_.emplace_back(std::make_unique<Describe>());
  Limits element_limits = limits;
  element_limits.required = true;
  element->add(ParameterKind::number, "", doc, element_limits);
  ParameterInfo& info = add(ParameterKind::list, name, doc, limits);
  info.fallback.items = kept.data();
  info.fallback.count = kept.size();
  info.fields = element->infos_.data();
  info.field_count = 1;
}

inline void Describe::choice(const char* name, std::string& member,
                             std::initializer_list<const char*> allowed, const char* doc) {
  if (reading()) {
    if (const Value* v = find(name); v && v->kind == ParameterKind::choice) member = v->text;
    return;
  }
  const char* text = keep(member);
  auto& kept = choices_.emplace_back(allowed);
  ParameterInfo& info = add(ParameterKind::choice, name, doc, {});
  info.fallback.text = text;
  info.choices = kept.data();
  info.choice_count = kept.size();
}

inline void Describe::table(const char* name, std::map<std::string, double>& member,
                            const char* doc, const Limits& limits) {
  if (reading()) {
    const Value* v = find(name);
    if (v == nullptr || v->kind != ParameterKind::table) return;
    member.clear();
    for (std::uint64_t i = 0; i < v->count; ++i) member[v->items[i].key] = v->items[i].number;
    return;
  }
  auto& kept = values_of_lists_.emplace_back();
  for (const auto& [key, number] : member) {
    Value item;
    item.kind = ParameterKind::number;
    item.number = number;
    item.key = keep(key);
    kept.push_back(item);
  }
  ParameterInfo& info = add(ParameterKind::table, name, doc, limits);
  info.fallback.items = kept.data();
  info.fallback.count = kept.size();
}

template <Described T>
void Describe::group(const char* name, T& member, const char* doc) {
  if (reading()) {
    const Value* v = find(name);
    if (v == nullptr || v->kind != ParameterKind::group) return;
    Describe inner(*v);
    member.describe(inner);
    return;
  }
  auto& inner = nested_.emplace_back(std::make_unique<Describe>());
  member.describe(*inner);
  const Value fallback = group_of_defaults(*inner);
  ParameterInfo& info = add(ParameterKind::group, name, doc, {});
  info.fallback = fallback;
  info.fields = inner->infos_.data();
  info.field_count = inner->infos_.size();
}

template <Described T>
void Describe::list(const char* name, std::vector<T>& member, const char* doc, bool required) {
  if (reading()) {
    const Value* v = find(name);
    if (v == nullptr || v->kind != ParameterKind::list) return;
    member.clear();
    for (std::uint64_t i = 0; i < v->count; ++i) {
      Describe inner(v->items[i]);
      member.emplace_back().describe(inner);
    }
    return;
  }
  auto& fields = nested_.emplace_back(std::make_unique<Describe>());
  T prototype{};
  prototype.describe(*fields);
  auto& element = nested_.emplace_back(std::make_unique<Describe>());
  ParameterInfo& group = element->add(ParameterKind::group, "", doc, {});
  group.fields = fields->infos_.data();
  group.field_count = fields->infos_.size();

  // The default list, element by element.
  std::vector<Value> defaults;
  for (T& item : member) {
    auto& described = nested_.emplace_back(std::make_unique<Describe>());
    item.describe(*described);
    defaults.push_back(group_of_defaults(*described));
  }
  auto& kept = values_of_lists_.emplace_back(std::move(defaults));
  ParameterInfo& info = add(ParameterKind::list, name, doc, {.required = required});
  info.fallback.items = kept.data();
  info.fallback.count = kept.size();
  info.fields = element->infos_.data();
  info.field_count = 1;
}

}  // namespace somas
