#include "core/plugins/check.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/plugins/elf.hpp"
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
    check_parameter(info.fields[0], where + "[]", depth + 1);
    if (info.fields[0].kind == ParameterKind::group) return;
  }
  if (info.kind == ParameterKind::group)
    check_parameters(info.fields, info.field_count, where, depth + 1);
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
  if (table->size != sizeof(PluginInfo) || table->abi != SOMAS_ABI_REVISION)
    bad("somas_plugin()", "is of interface revision " + std::to_string(table->abi) +
                              ", this host needs " + std::to_string(SOMAS_ABI_REVISION));
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
