#include "core/plugins/check.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/plugins/elf.hpp"
#include "core/plugins/relations.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/values.hpp"

namespace somas::plugins {
namespace {

constexpr std::uint64_t most_entries = 10000;
constexpr int deepest_group = 16;

// Ids and parameters are written in YAML and on command lines.
bool is_word(const char* text) {
  if (text == nullptr || !(*text >= 'a' && *text <= 'z')) return false;
  return std::all_of(text, text + std::char_traits<char>::length(text), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

[[noreturn]] void bad(const std::string& where, const std::string& what) {
  throw BadPlugin("its table is unusable: " + where + ": " + what +
                  "; this is a fault of the plugin");
}

void check_parameters(const ParameterInfo* first, std::uint64_t count, const std::string& where,
                      int depth);

void check_choices(const ParameterInfo& info, const std::string& where) {
  if (info.choice_count == 0 || info.choices == nullptr) bad(where, "has no choices");
  const std::vector<std::string> choices = choices_of(info);
  if (info.fallback.kind != ParameterKind::choice) return;
  if (std::find(choices.begin(), choices.end(), info.fallback.text) == choices.end())
    bad(where, "its default is not among its choices");
}

void check_default(const ParameterInfo& info, const std::string& where) {
  const Value& fallback = info.fallback;
  if (fallback.kind == ParameterKind::none) return;
  if (fallback.kind != info.kind) bad(where, "its default is of another kind");
  const bool needs_text = info.kind == ParameterKind::text || info.kind == ParameterKind::choice;
  if (needs_text && fallback.text == nullptr) bad(where, "its default has no text");
  if (fallback.count > 0 && fallback.items == nullptr) bad(where, "its default has no items");

  if (info.kind == ParameterKind::number && !std::isfinite(fallback.number))
    bad(where, "its default is not a finite number");
  if (info.kind == ParameterKind::number && !in_range(info, fallback.number))
    bad(where, "its default " + format_number(fallback.number) + " is out of its range");
  if (info.kind == ParameterKind::integer && !in_range(info, static_cast<double>(fallback.integer)))
    bad(where, "its default " + std::to_string(fallback.integer) + " is out of its range");
}

// A default that there is; what is required has any number.
std::uint64_t fallback_count(const ParameterInfo& info) {
  return info.fallback.kind == ParameterKind::list ? info.fallback.count : info.minimum_count;
}

void check_parameter(const ParameterInfo& info, const std::string& where, int depth) {
  if (info.size != sizeof(ParameterInfo)) bad(where, "its size is that of another SDK");
  if (info.kind < ParameterKind::number || info.kind > ParameterKind::table)
    bad(where, "is of unknown kind " + std::to_string(static_cast<unsigned>(info.kind)));
  if (info.doc == nullptr || info.unit == nullptr) bad(where, "has no doc or unit");
  if (std::isnan(info.minimum) || std::isnan(info.maximum)) bad(where, "its range is NaN");
  if (info.kind == ParameterKind::choice) check_choices(info, where);
  check_default(info, where);
  if (info.kind == ParameterKind::list) {
    if (info.field_count != 1 || info.fields == nullptr) bad(where, "does not say of what it is");
    if (info.minimum_count > info.maximum_count) bad(where, "no number of elements is allowed");
    if (fallback_count(info) < info.minimum_count || fallback_count(info) > info.maximum_count)
      bad(where, "its default has a wrong number of elements");
    check_parameter(info.fields[0], where + "[]", depth + 1);
    if (info.fields[0].kind == ParameterKind::group) return;
  }
  if (info.kind == ParameterKind::group)
    check_parameters(info.fields, info.field_count, where, depth + 1);
}

bool is_number(const ParameterInfo& info) {
  return info.kind == ParameterKind::number || info.kind == ParameterKind::integer;
}

bool has_word(const ParameterInfo& info, const std::string& word) {
  if (info.kind == ParameterKind::boolean) return word == "true" || word == "false";
  if (info.kind != ParameterKind::choice) return false;
  const std::vector<std::string> words = choices_of(info);
  return std::find(words.begin(), words.end(), word) != words.end();
}

// What is wrong with a relation; empty: nothing.
std::string fault_in(const Relation& relation, const ParameterInfo& first,
                     const ParameterInfo& other) {
  switch (relation.kind) {
    case RelationKind::at_most:
    case RelationKind::less_than:
      return is_number(first) && is_number(other) ? "" : "compares what is no number";
    case RelationKind::differs: {
      const bool plain = first.kind != ParameterKind::list && first.kind != ParameterKind::group &&
                         first.kind != ParameterKind::table;
      const bool alike = first.kind == other.kind || (is_number(first) && is_number(other));
      return plain && alike ? "" : "compares what cannot be compared";
    }
    case RelationKind::needs:
    case RelationKind::excludes:
      return can_be_unset(first) && can_be_unset(other)
                 ? ""
                 : "is about a parameter that always has a value";
    case RelationKind::only_when:
    case RelationKind::required_when:
      if (!can_be_unset(first)) return "is about a parameter that always has a value";
      if (relation.word_count == 0) return "names no word of the other";
      for (const std::string& word : words_of(relation))
        if (!has_word(other, word)) return "names '" + word + "', which is no word of the other";
      return "";
  }
  return "is of unknown kind " + std::to_string(static_cast<unsigned>(relation.kind));
}

void check_relations(std::span<const ParameterInfo> fields, const std::string& where) {
  for (const ParameterInfo& first : fields) {
    const std::string of = where + "." + first.name;
    if (first.relation_count > most_entries || (first.relation_count > 0 && !first.relations))
      bad(of, "has no list of relations");
    for (const Relation& relation : relations_of(first)) {
      if (relation.size != sizeof(Relation)) bad(of, "its relations are those of another SDK");
      if (relation.other == nullptr || relation.word_count > most_entries ||
          (relation.word_count > 0 && relation.words == nullptr))
        bad(of, "a relation does not say to what");
      const auto other = std::find_if(fields.begin(), fields.end(), [&](const ParameterInfo& info) {
        return &info != &first && std::string_view(info.name) == relation.other;
      });
      if (other == fields.end())
        bad(of, "a relation is to '" + std::string(relation.other) +
                    "', which is no other parameter of its group");
      const std::string fault = fault_in(relation, first, *other);
      if (!fault.empty()) bad(of, "the relation to '" + std::string(relation.other) + "' " + fault);
    }
  }
  // What is missing may be given by the file, as what is required must be.
  find_broken(fields, defaults_of(fields), [&](const BrokenRelation& broken) {
    const RelationKind kind = broken.relation->kind;
    const bool asks = kind == RelationKind::needs || kind == RelationKind::required_when;
    if (!asks && broken.first->required == 0 && broken.other->required == 0)
      bad(where + "." + broken.first->name,
          "the defaults break its own rule: " + relation_text(*broken.relation));
  });
}

void check_parameters(const ParameterInfo* first, std::uint64_t count, const std::string& where,
                      int depth) {
  if (depth > deepest_group) bad(where, "is nested too deeply");
  if (count > most_entries || (count > 0 && first == nullptr)) bad(where, "has no parameter list");
  std::set<std::string> names;
  for (std::uint64_t i = 0; i < count; ++i) {
    const char* name = first[i].name;
    if (!is_word(name))
      bad(where, "parameter " + std::to_string(i) + " has no lower_snake_case name");
    if (!names.insert(name).second)
      bad(where, "two parameters are called '" + std::string(name) + "'");
    check_parameter(first[i], where + "." + name, depth);
  }
  check_relations({first, count}, where);
}

void check_class(const ClassInfo& info, std::uint64_t index) {
  std::string where = "class " + std::to_string(index);
  if (info.size != sizeof(ClassInfo)) bad(where, "its size is that of another SDK");
  if (!is_word(info.id)) bad(where, "its id is not in lower_snake_case");
  where = info.id;
  if (info.kind < PluginKind::environment || info.kind > PluginKind::fitness)
    bad(where, "is of unknown kind " + std::to_string(static_cast<unsigned>(info.kind)));
  if (info.doc == nullptr) bad(where, "has no doc");
  if (info.create == nullptr || info.destroy == nullptr) bad(where, "cannot be created");
  check_parameters(info.parameters, info.parameter_count, where, 0);

  // The experiment names a block's class with this key.
  for (std::uint64_t i = 0; i < info.parameter_count; ++i)
    if (std::string(info.parameters[i].name) == "plugin")
      bad(where, "a parameter may not be called 'plugin'");
}

}  // namespace

void check_table(const PluginInfo* table) {
  if (table == nullptr) bad("somas_plugin()", "returned nothing");
  if (table->abi != SOMAS_ABI_REVISION)
    bad("somas_plugin()", "is of interface revision " + std::to_string(table->abi) +
                              ", this host needs " + std::to_string(SOMAS_ABI_REVISION));
  // A later SDK of this revision may have appended; what it appended is not read.
  if (table->size < sizeof(PluginInfo)) bad("somas_plugin()", "is too short a table");
  if (table->fingerprint == nullptr) bad("somas_plugin()", "has no fingerprint");
  check_fingerprint(table->fingerprint);
  if (table->id == nullptr || *table->id == '\0' || table->version == nullptr)
    bad("somas_plugin()", "has no id or version");
  if (table->class_count == 0 || table->class_count > most_entries || table->classes == nullptr)
    bad("somas_plugin()", "has no classes");
  std::set<std::string> ids;
  for (std::uint64_t i = 0; i < table->class_count; ++i) {
    check_class(table->classes[i], i);
    if (!ids.insert(table->classes[i].id).second) bad(table->classes[i].id, "is listed twice");
  }
}

}  // namespace somas::plugins
