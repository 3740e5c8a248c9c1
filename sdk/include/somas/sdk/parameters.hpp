/// @file
/// Typed parameters of a plugin class.
///
/// A plugin keeps its parameters in a plain struct whose initialisers are the defaults, with a
/// member `describe` that names each one:
///
/// @code
///   struct Parameters {
///     double rate = 1.0;
///     std::optional<double> limit;
///     std::string mode = "peak";
///     void describe(somas::Describe& d) {
///       d("rate", rate, "Particles a step", {.unit = "1/step", .minimum = 0});
///       d("limit", limit, "Most particles a step", {.unit = "1/step", .minimum = 0});
///       d.choice("mode", mode, {"peak", "share"}, "How to weigh");
///       d.at_most("rate", "limit");
///     }
///   };
/// @endcode
///
/// The same function serves twice: to list the parameters for the host (which validates the YAML
/// against the list, prints and documents it), and to read the host's values back into the struct.
#pragma once

#include <concepts>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
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
  ParameterKind kind = ParameterKind::none;  ///< which of the members holds it
  std::uint32_t reserved = 0;                ///< 0
  double number = 0;                         ///< of a number
  std::int64_t integer = 0;                  ///< of an integer or a boolean
  const char* text = nullptr;                ///< of a text or a choice
  const char* key = nullptr;                 ///< name within the enclosing group or table
  const Value* items = nullptr;              ///< list elements, group fields, table entries
  std::uint64_t count = 0;                   ///< of `items`
};

/// How two parameters of one group bear on each other; the numbers are part of the ABI. A parameter
/// is set when it has a value: an optional one that is given, a boolean that is true, a text, list
/// or table that is not empty.
enum class RelationKind : std::uint32_t {
  at_most = 1,        ///< numbers: this <= other, if both have a value
  less_than = 2,      ///< numbers: this < other, if both have a value
  differs = 3,        ///< numbers, texts, choices: this is not other, if both have a value
  needs = 4,          ///< if this is set, so is the other
  excludes = 5,       ///< this and the other are not both set
  only_when = 6,      ///< if this is set, the other (a choice or boolean) is one of `words`
  required_when = 7,  ///< if the other (a choice or boolean) is one of `words`, this is set
};

/// One relation as it crosses the boundary, kept by the parameter that it begins with.
struct Relation {
  std::uint32_t size = sizeof(Relation);      ///< bytes that the plugin knows of this struct
  RelationKind kind = RelationKind::at_most;  ///< which relation
  const char* other = "";                     ///< a parameter of the same group
  const char* const* words = nullptr;  ///< only_when, required_when: choices, or true or false
  std::uint64_t word_count = 0;        ///< of `words`
};

/// One parameter as it crosses the boundary: plain data, owned by the plugin, valid while loaded.
struct ParameterInfo {
  std::uint32_t size = sizeof(ParameterInfo);  ///< bytes that the plugin knows of this struct
  ParameterKind kind = ParameterKind::none;    ///< what its values are
  const char* name = "";                       ///< its key; empty for a list's element
  const char* unit = "";                       ///< "1/step"; empty: none
  const char* doc = "";                        ///< one sentence, without a full stop
  Value fallback{};                ///< the default; kind none: required, or optional and left out
  std::uint32_t required = 0;      ///< 1: the YAML must give it
  std::uint32_t minimum_open = 0;  ///< 1: the minimum itself is not allowed
  double minimum = -std::numeric_limits<double>::infinity();  ///< least number that is allowed
  double maximum = std::numeric_limits<double>::infinity();   ///< most that is allowed
  const char* const* choices = nullptr;                       ///< choice: its words
  std::uint64_t choice_count = 0;                             ///< of `choices`
  const ParameterInfo* fields = nullptr;  ///< group: its fields; list: one, its element
  std::uint64_t field_count = 0;          ///< of `fields`
  std::uint64_t minimum_count = 0;        ///< list: least elements
  std::uint64_t maximum_count = std::numeric_limits<std::uint64_t>::max();  ///< list: most elements
  const Relation* relations = nullptr;  ///< those that begin with this parameter
  std::uint64_t relation_count = 0;     ///< of `relations`
  std::uint64_t reserved[4] = {};       ///< 0; what a later revision adds
};

/// What may be said of a parameter beside its doc. Of a list, range and unit are its elements'.
struct Limits {
  const char* unit = "";                                      ///< "1/step"; a literal
  double minimum = -std::numeric_limits<double>::infinity();  ///< least that is allowed
  double maximum = std::numeric_limits<double>::infinity();   ///< most that is allowed
  /// Excludes the minimum itself: `{.minimum = 0, .minimum_open = true}` is > 0.
  bool minimum_open = false;
  bool required = false;            ///< the experiment must give it; it has no default
  std::uint64_t minimum_count = 0;  ///< least elements of a list
  std::uint64_t maximum_count = std::numeric_limits<std::uint64_t>::max();  ///< most elements
};

/// A word of an enumeration; for Describe::choice.
template <class E>
struct NamedChoice {
  const char* name;  ///< as the experiment says it; a literal
  E value;           ///< as the plugin says it
};

/// What a single parameter may be, alone, optional, or as the element of a list.
template <class T>
concept PlainParameter = std::same_as<T, double> || std::same_as<T, std::int64_t> ||
    std::same_as<T, bool> || std::same_as<T, std::string>;

class Describe;

/// A struct with `void describe(Describe&)`: the shape of Parameters and of groups inside it.
template <class T>
concept Described = requires(T t, Describe& d) {
  t.describe(d);
};

/// The visitor that a `describe` member is called with. In each call `name` is the parameter's key,
/// `member` is where its default stands and its value goes, `doc` says in one sentence what it is,
/// `limits` what may be said besides. Names, docs, units and words must be string literals.
class Describe {
 public:
  /// Collects: afterwards `parameters()` lists what was described, defaults from the struct.
  Describe() = default;
  /// Reads: every described member is set from the group `values`.
  explicit Describe(const Value& values) : values_(&values) {}

  /// A double, std::int64_t, bool or std::string.
  template <PlainParameter T>
  void operator()(const char* name, T& member, const char* doc, const Limits& limits = {});
  /// The same, or nothing: it may be left out.
  template <PlainParameter T>
  void operator()(const char* name, std::optional<T>& member, const char* doc,
                  const Limits& limits = {});
  /// A list of them.
  template <PlainParameter T>
  void operator()(const char* name, std::vector<T>& member, const char* doc,
                  const Limits& limits = {});
  /// A string out of a fixed set.
  void choice(const char* name, std::string& member, std::initializer_list<const char*> allowed,
              const char* doc);
  /// The same, or nothing: it may be left out.
  void choice(const char* name, std::optional<std::string>& member,
              std::initializer_list<const char*> allowed, const char* doc);
  /// A value of an enumeration: `d.choice("shape", shape, {{"disc", Shape::disc}, ...}, "...")`.
  template <class E>
  requires std::is_enum_v<E>
  void choice(const char* name, E& member, std::initializer_list<NamedChoice<E>> allowed,
              const char* doc);
  /// A list of strings out of a fixed set.
  void choices(const char* name, std::vector<std::string>& member,
               std::initializer_list<const char*> allowed, const char* doc,
               const Limits& limits = {});
  /// Free keys with numbers.
  void table(const char* name, std::map<std::string, double>& member, const char* doc,
             const Limits& limits = {});
  /// A nested group.
  template <Described T>
  void group(const char* name, T& member, const char* doc);
  /// A list of groups; the element's own defaults fill what an element leaves out.
  template <Described T>
  void list(const char* name, std::vector<T>& member, const char* doc, bool required = false) {
    list(name, member, doc, Limits{.required = required});
  }
  /// The same with a least and a most number of elements.
  template <Described T>
  void list(const char* name, std::vector<T>& member, const char* doc, const Limits& limits);

  /// @name Relations
  /// Relations between parameters of this group, which the host checks and says in the reference of
  /// the plugin. `name` has been described before, or std::logic_error is thrown; `other` is
  /// another parameter of the group. See RelationKind for what counts as set.
  /// @{

  /// Numbers: `name` is at most `other`, if both have a value.
  void at_most(const char* name, const char* other) { relate(name, RelationKind::at_most, other); }
  /// Numbers: `name` is less than `other`, if both have a value.
  void less_than(const char* name, const char* other) {
    relate(name, RelationKind::less_than, other);
  }
  /// Numbers, texts, choices: `name` is not `other`, if both have a value.
  void differs(const char* name, const char* other) { relate(name, RelationKind::differs, other); }
  /// If `name` is set, so is `other`.
  void needs(const char* name, const char* other) { relate(name, RelationKind::needs, other); }
  /// `name` and `other` are not both set.
  void excludes(const char* name, const char* other) {
    relate(name, RelationKind::excludes, other);
  }
  /// If `name` is set, `other` (a choice or boolean) is one of `words`.
  void only_when(const char* name, const char* other, std::initializer_list<const char*> words) {
    relate(name, RelationKind::only_when, other, words);
  }
  /// If `other` (a choice or boolean) is one of `words`, `name` is set.
  void required_when(const char* name, const char* other,
                     std::initializer_list<const char*> words) {
    relate(name, RelationKind::required_when, other, words);
  }
  /// @}

  /// The collected list; valid as long as this object lives.
  [[nodiscard]] const std::vector<ParameterInfo>& parameters() const { return infos_; }

 private:
  [[nodiscard]] bool reading() const { return values_ != nullptr; }
  [[nodiscard]] const Value* find(std::string_view name) const {
    for (std::uint64_t i = 0; i < values_->count; ++i)
      if (name == values_->items[i].key) return &values_->items[i];
    return nullptr;
  }
  [[nodiscard]] const Value* find(std::string_view name, ParameterKind kind) const {
    const Value* value = find(name);
    return value != nullptr && value->kind == kind ? value : nullptr;
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
    if (kind == ParameterKind::list) {
      info.minimum_count = limits.minimum_count;
      info.maximum_count = limits.maximum_count;
    }
    if (!limits.required) info.fallback.kind = kind;
    infos_.push_back(info);
    return infos_.back();
  }
  void relate(const char* name, RelationKind kind, const char* other,
              std::initializer_list<const char*> words = {});
  /// A choice, for the default to be filled in by the caller.
  ParameterInfo& add_choice(const char* name, std::vector<const char*> allowed, const char* doc,
                            const Limits& limits = {});
  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }

  template <PlainParameter T>
  static constexpr ParameterKind kind_of = std::same_as<T, double>         ? ParameterKind::number
                                           : std::same_as<T, std::int64_t> ? ParameterKind::integer
                                           : std::same_as<T, bool>         ? ParameterKind::boolean
                                                                           : ParameterKind::text;
  template <PlainParameter T>
  static T read(const Value& value) {
    if constexpr (std::same_as<T, double>)
      return value.number;
    else if constexpr (std::same_as<T, bool>)
      return value.integer != 0;
    else if constexpr (std::same_as<T, std::string>)
      return value.text;
    else
      return value.integer;
  }
  template <PlainParameter T>
  Value written(const T& plain) {
    Value value;
    value.kind = kind_of<T>;
    if constexpr (std::same_as<T, double>)
      value.number = plain;
    else if constexpr (std::same_as<T, std::string>)
      value.text = keep(plain);
    else
      value.integer = plain;
    return value;
  }
  template <class Plain, class Write>
  void add_list(const char* name, const std::vector<Plain>& member, const char* doc,
                const Limits& limits, std::unique_ptr<Describe> element, Write&& write);

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
  std::map<std::size_t, std::vector<Relation>> relations_;  ///< by place in infos_
};

inline void Describe::relate(const char* name, RelationKind kind, const char* other,
                             std::initializer_list<const char*> words) {
  if (reading()) return;
  for (std::size_t i = 0; i < infos_.size(); ++i) {
    if (std::string_view(infos_[i].name) != name) continue;
    std::vector<Relation>& all = relations_[i];
    Relation& relation = all.emplace_back();
    relation.kind = kind;
    relation.other = other;
    if (words.size() > 0) relation.words = choices_.emplace_back(words).data();
    relation.word_count = words.size();
    infos_[i].relations = all.data();
    infos_[i].relation_count = all.size();
    return;
  }
  throw std::logic_error(std::string("a relation begins with '") + name +
                         "', which has not been described before");
}

template <PlainParameter T>
void Describe::operator()(const char* name, T& member, const char* doc, const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name, kind_of<T>)) member = read<T>(*v);
    return;
  }
  // A required one has no default, whatever the struct says.
  ParameterInfo& info = add(kind_of<T>, name, doc, limits);
  const ParameterKind fallback = info.fallback.kind;
  info.fallback = written(member);
  info.fallback.kind = fallback;
}

template <PlainParameter T>
void Describe::operator()(const char* name, std::optional<T>& member, const char* doc,
                          const Limits& limits) {
  if (reading()) {
    if (const Value* v = find(name, kind_of<T>)) member = read<T>(*v);
    return;
  }
  ParameterInfo& info = add(kind_of<T>, name, doc, limits);
  info.fallback = member ? written(*member) : Value{};
}

template <class Plain, class Write>
void Describe::add_list(const char* name, const std::vector<Plain>& member, const char* doc,
                        const Limits& limits, std::unique_ptr<Describe> element, Write&& write) {
  auto& kept = values_of_lists_.emplace_back();
  for (const Plain& item : member) kept.push_back(write(item));
  auto& described = nested_.emplace_back(std::move(element));
  ParameterInfo& info = add(ParameterKind::list, name, doc, limits);
  info.fallback.items = kept.data();
  info.fallback.count = kept.size();
  info.fields = described->infos_.data();
  info.field_count = 1;
}

template <PlainParameter T>
void Describe::operator()(const char* name, std::vector<T>& member, const char* doc,
                          const Limits& limits) {
  if (reading()) {
    const Value* v = find(name, ParameterKind::list);
    if (v == nullptr) return;
    member.clear();
    for (std::uint64_t i = 0; i < v->count; ++i) member.push_back(read<T>(v->items[i]));
    return;
  }
  auto element = std::make_unique<Describe>();
  Limits element_limits = limits;
  element_limits.required = true;
  element->add(kind_of<T>, "", doc, element_limits);
  add_list(name, member, doc, limits, std::move(element),
           [this](const T& item) { return written<T>(item); });
}

inline ParameterInfo& Describe::add_choice(const char* name, std::vector<const char*> allowed,
                                           const char* doc, const Limits& limits) {
  auto& kept = choices_.emplace_back(std::move(allowed));
  ParameterInfo& info = add(ParameterKind::choice, name, doc, limits);
  info.choices = kept.data();
  info.choice_count = kept.size();
  return info;
}

inline void Describe::choice(const char* name, std::string& member,
                             std::initializer_list<const char*> allowed, const char* doc) {
  if (reading()) {
    if (const Value* v = find(name, ParameterKind::choice)) member = v->text;
    return;
  }
  add_choice(name, allowed, doc).fallback.text = keep(member);
}

inline void Describe::choice(const char* name, std::optional<std::string>& member,
                             std::initializer_list<const char*> allowed, const char* doc) {
  if (reading()) {
    if (const Value* v = find(name, ParameterKind::choice)) member = v->text;
    return;
  }
  ParameterInfo& info = add_choice(name, allowed, doc);
  if (member)
    info.fallback.text = keep(*member);
  else
    info.fallback = {};
}

template <class E>
requires std::is_enum_v<E>
void Describe::choice(const char* name, E& member, std::initializer_list<NamedChoice<E>> allowed,
                      const char* doc) {
  if (reading()) {
    const Value* v = find(name, ParameterKind::choice);
    if (v == nullptr) return;
    for (const NamedChoice<E>& one : allowed)
      if (std::string_view(one.name) == v->text) member = one.value;
    return;
  }
  std::vector<const char*> names;
  const char* text = "";
  for (const NamedChoice<E>& one : allowed) {
    names.push_back(one.name);
    if (one.value == member) text = one.name;
  }
  add_choice(name, std::move(names), doc).fallback.text = text;
}

inline void Describe::choices(const char* name, std::vector<std::string>& member,
                              std::initializer_list<const char*> allowed, const char* doc,
                              const Limits& limits) {
  if (reading()) {
    const Value* v = find(name, ParameterKind::list);
    if (v == nullptr) return;
    member.clear();
    for (std::uint64_t i = 0; i < v->count; ++i) member.emplace_back(v->items[i].text);
    return;
  }
  auto element = std::make_unique<Describe>();
  element->add_choice("", allowed, doc, {.required = true});
  add_list(name, member, doc, limits, std::move(element), [this](const std::string& item) {
    Value value = written(item);
    value.kind = ParameterKind::choice;
    return value;
  });
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
void Describe::list(const char* name, std::vector<T>& member, const char* doc,
                    const Limits& limits) {
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
  ParameterInfo& info = add(ParameterKind::list, name, doc, limits);
  info.fallback.items = kept.data();
  info.fallback.count = kept.size();
  info.fields = element->infos_.data();
  info.field_count = 1;
}

}  // namespace somas
