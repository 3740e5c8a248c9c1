#include "core/experiment/json_schema.hpp"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/experiment/keys.hpp"
#include "core/plugins/relations.hpp"
#include "core/plugins/suggest.hpp"

namespace somas::experiment {
namespace {

using Json = nlohmann::ordered_json;
using plugins::ParameterValue;

// Whether a mapping is all there is, or only what a file says beyond the one that it extends.
enum class Extent { whole, part };

Json schema_of(const ParameterInfo& info, Extent extent);
Json group_schema(std::span<const ParameterInfo> fields, Extent extent);

Json json_of(const ParameterValue& value) {
  switch (value.kind) {
    case ParameterKind::number:
      return value.number;
    case ParameterKind::integer:
      return value.integer;
    case ParameterKind::boolean:
      return value.integer != 0;
    case ParameterKind::text:
    case ParameterKind::choice:
      return value.text;
    case ParameterKind::list: {
      Json list = Json::array();
      for (const ParameterValue& item : value.items) list.push_back(json_of(item));
      return list;
    }
    case ParameterKind::group:
    case ParameterKind::table: {
      Json mapping = Json::object();
      for (const ParameterValue& item : value.items) mapping[item.key] = json_of(item);
      return mapping;
    }
    case ParameterKind::none:
      break;
  }
  return nullptr;
}

// ---- single parameters -------------------------------------------------------------------------

// What an editor shows: the doc, the unit, what other parameters ask.
std::string description_of(const ParameterInfo& info) {
  std::string text = info.doc;
  const ParameterInfo& plain = info.kind == ParameterKind::list ? info.fields[0] : info;
  if (*plain.unit != '\0') text.append(" [").append(plain.unit).append("]");
  for (const Relation& relation : plugins::relations_of(info))
    text += "; " + plugins::relation_text(relation);
  return text;
}

void add_range(Json& schema, const ParameterInfo& info) {
  if (std::isfinite(info.minimum))
    schema[info.minimum_open != 0 ? "exclusiveMinimum" : "minimum"] = info.minimum;
  if (std::isfinite(info.maximum)) schema["maximum"] = info.maximum;
}

Json integer_schema(const ParameterInfo& info) {
  using Limits64 = std::numeric_limits<std::int64_t>;
  Json schema = {{"type", "integer"}};
  add_range(schema, info);
  // Doubles cannot say these, so they are written as integers.
  if (!std::isfinite(info.minimum)) schema["minimum"] = Limits64::min();
  if (!std::isfinite(info.maximum)) schema["maximum"] = Limits64::max();
  return schema;
}

Json list_schema(const ParameterInfo& info) {
  Json schema = {{"type", "array"}, {"items", schema_of(info.fields[0], Extent::whole)}};
  if (info.minimum_count > 0) schema["minItems"] = info.minimum_count;
  if (info.maximum_count != std::numeric_limits<std::uint64_t>::max())
    schema["maxItems"] = info.maximum_count;
  return schema;
}

Json bare_schema(const ParameterInfo& info, Extent extent) {
  switch (info.kind) {
    case ParameterKind::number: {
      Json schema = {{"type", "number"}};
      add_range(schema, info);
      return schema;
    }
    case ParameterKind::integer:
      return integer_schema(info);
    case ParameterKind::boolean:
      return {{"type", "boolean"}};
    case ParameterKind::text:
      return {{"type", "string"}};
    case ParameterKind::choice:
      return {{"type", "string"}, {"enum", plugins::choices_of(info)}};
    case ParameterKind::list:
      return list_schema(info);
    case ParameterKind::group:
      return group_schema(plugins::fields_of(info), extent);
    case ParameterKind::table: {
      Json entry = {{"type", "number"}};
      add_range(entry, info);
      return {{"type", "object"}, {"additionalProperties", entry}};
    }
    case ParameterKind::none:
      break;
  }
  return Json::object();
}

Json schema_of(const ParameterInfo& info, Extent extent) {
  Json schema = bare_schema(info, extent);
  schema["description"] = description_of(info);
  const ParameterValue fallback = plugins::default_of(info);
  const bool nested = info.kind == ParameterKind::group;
  if (info.required == 0 && !nested && fallback.kind != ParameterKind::none)
    schema["default"] = json_of(fallback);
  return schema;
}

// ---- relations ---------------------------------------------------------------------------------

const ParameterInfo* named(std::span<const ParameterInfo> fields, std::string_view name) {
  for (const ParameterInfo& field : fields)
    if (name == field.name) return &field;
  return nullptr;
}

// "The parameter is so": where it is so by default, it may be left out.
Json property_is(const ParameterInfo& info, Json what, bool by_default) {
  Json schema = {{"properties", {{info.name, std::move(what)}}}};
  if (!by_default) schema["required"] = {info.name};
  return schema;
}

Json is_set(const ParameterInfo& info) {
  const ParameterValue fallback = plugins::default_of(info);
  Json what = Json::object();
  if (info.kind == ParameterKind::boolean) what = {{"const", true}};
  if (info.kind == ParameterKind::text) what = {{"minLength", 1}};
  if (info.kind == ParameterKind::list) what = {{"minItems", 1}};
  if (info.kind == ParameterKind::table) what = {{"minProperties", 1}};
  return property_is(info, what, plugins::is_set(&fallback));
}

Json has_word(const ParameterInfo& info, const Relation& relation) {
  Json words = Json::array();
  bool by_default = false;
  const ParameterValue fallback = plugins::default_of(info);
  for (const std::string& word : plugins::words_of(relation)) {
    const bool is_boolean = info.kind == ParameterKind::boolean;
    words.push_back(is_boolean ? Json(word == "true") : Json(word));
    by_default = by_default ||
                 (is_boolean ? (fallback.integer != 0) == (word == "true") : fallback.text == word);
  }
  return property_is(info, {{"enum", words}}, by_default);
}

// Null for comparisons, which a schema cannot express.
Json relation_schema(const ParameterInfo& first, const ParameterInfo& other,
                     const Relation& relation) {
  switch (relation.kind) {
    case RelationKind::needs:
      return {{"if", is_set(first)}, {"then", is_set(other)}};
    case RelationKind::excludes:
      return {{"not", {{"allOf", {is_set(first), is_set(other)}}}}};
    case RelationKind::only_when:
      return {{"if", is_set(first)}, {"then", has_word(other, relation)}};
    case RelationKind::required_when:
      return {{"if", has_word(other, relation)}, {"then", is_set(first)}};
    default:
      return nullptr;
  }
}

// ---- mappings ----------------------------------------------------------------------------------

Json group_schema(std::span<const ParameterInfo> fields, Extent extent) {
  Json schema = {{"type", "object"}, {"properties", Json::object()}};
  Json required = Json::array(), rules = Json::array();
  for (const ParameterInfo& field : fields) {
    schema["properties"][field.name] = schema_of(field, extent);
    if (field.required != 0) required.push_back(field.name);
    for (const Relation& relation : plugins::relations_of(field))
      if (const ParameterInfo* other = named(fields, relation.other))
        if (Json rule = relation_schema(field, *other, relation); !rule.is_null())
          rules.push_back(std::move(rule));
  }
  schema["additionalProperties"] = false;
  // What a file leaves out may stand in the one that it extends.
  if (extent == Extent::part) return schema;
  if (!required.empty()) schema["required"] = required;
  if (!rules.empty()) schema["allOf"] = rules;
  return schema;
}

// ---- blocks of plugins -------------------------------------------------------------------------

// The blocks of one kind, by the plugin that they name.
class Blocks {
 public:
  Blocks(const plugins::Registry& registry, PluginKind kind, Json& definitions)
      : kind_(plugins::kind_name(kind)) {
    for (const std::string& id : registry.ids(kind)) {
      try {
        const plugins::PluginClass plugin = registry.find(kind, id);
        define(definitions, plugin, Extent::whole);
        define(definitions, plugin, Extent::part);
        ids_.push_back(id);
        docs_.push_back(plugin.info->doc);
      } catch (const plugins::LookupError&) {
        // Defined twice, so nobody can use it.
      }
    }
  }

  [[nodiscard]] const std::vector<std::string>& ids() const { return ids_; }

  [[nodiscard]] Json reference(const std::string& id, Extent extent) const {
    return {{"$ref", "#/definitions/" + name_of(id, extent)}};
  }

  // A block whose plugin, if it names none, is `implied` (none: it has to, or inherits it).
  [[nodiscard]] Json block(Extent extent, const std::string& implied = {}) const {
    Json schema = {{"type", "object"},
                   {"description", "A plugin and its parameters"},
                   {"properties", {{"plugin", plugin_key()}}}};
    Json cases = Json::array();
    for (const std::string& id : ids_)
      cases.push_back(
          {{"if", {{"required", {"plugin"}}, {"properties", {{"plugin", {{"const", id}}}}}}},
           {"then", reference(id, extent)}});
    if (!implied.empty()) {
      cases.push_back(
          {{"if", {{"not", {{"required", {"plugin"}}}}}}, {"then", reference(implied, extent)}});
    } else if (extent == Extent::whole) {
      schema["required"] = {"plugin"};
    } else {
      Json any = Json::array();
      for (const std::string& id : ids_) any.push_back(reference(id, extent));
      if (!any.empty())
        cases.push_back(
            {{"if", {{"not", {{"required", {"plugin"}}}}}}, {"then", {{"anyOf", any}}}});
    }
    if (!cases.empty()) schema["allOf"] = cases;
    return schema;
  }

 private:
  [[nodiscard]] std::string name_of(const std::string& id, Extent extent) const {
    return kind_ + "." + id + (extent == Extent::part ? ".part" : "");
  }

  [[nodiscard]] Json plugin_key() const {
    std::string text = "The plugin:";
    for (std::size_t i = 0; i < ids_.size(); ++i)
      text.append(i == 0 ? " " : "; ").append(ids_[i]).append(" - ").append(docs_[i]);
    return {{"type", "string"}, {"enum", ids_}, {"description", text}};
  }

  void define(Json& definitions, const plugins::PluginClass& plugin, Extent extent) const {
    Json schema = group_schema(plugin.parameters(), extent);
    schema["properties"]["plugin"] = {{"const", plugin.id()}};
    schema["description"] = plugin.info->doc;
    definitions[name_of(plugin.id(), extent)] = std::move(schema);
  }

  std::string kind_;
  std::vector<std::string> ids_, docs_;
};

Json environments_schema(const Blocks& blocks, Extent extent) {
  Json names = {{"pattern", "^[A-Za-z0-9_][A-Za-z0-9_-]*$"},
                {"not", {{"enum", {"specialization", "controller", "fitness"}}}}};
  Json schema = {{"type", "object"}, {"propertyNames", names}, {"properties", Json::object()}};
  // null removes an inherited one.
  const auto entry = [&](Json block) {
    if (extent == Extent::whole) return block;
    return Json{{"if", {{"type", "null"}}}, {"then", Json::object()}, {"else", std::move(block)}};
  };
  for (const std::string& id : blocks.ids())
    schema["properties"][id] = entry(blocks.block(extent, id));
  schema["additionalProperties"] = entry(blocks.block(extent));
  return schema;
}

// ---- the whole file ----------------------------------------------------------------------------

constexpr PluginKind single_kinds[] = {PluginKind::specialization, PluginKind::controller,
                                       PluginKind::fitness};

// Which keys there are shows when the conditions are loaded.
Json sweep_schema(Extent extent) {
  Json named = {
      {"type", "object"}, {"minProperties", 1}, {"additionalProperties", {{"type", "object"}}}};
  Json factor = {{"anyOf", {{{"type", "array"}, {"minItems", 1}}, named}}};
  // null removes an inherited one.
  if (extent == Extent::part) factor["anyOf"].push_back({{"type", "null"}});
  Json names = {{"not", {{"pattern", "^(somas|name|seed|extends|plugins|sweep|replicates)$"}}}};
  return {{"type", "object"}, {"propertyNames", names}, {"additionalProperties", factor}};
}

// The mappings of a file that extends another, or of one that does not.
Json file_schema(const plugins::Registry& registry, Json& definitions, Extent extent) {
  Json properties = Json::object();
  const Blocks environments(registry, PluginKind::environment, definitions);
  properties["environments"] = environments_schema(environments, extent);
  properties["sweep"] = sweep_schema(extent);
  Json required = Json::array();
  for (const PluginKind kind : single_kinds) {
    const std::string name = plugins::kind_name(kind);
    properties[name] = Blocks(registry, kind, definitions).block(extent);
    required.push_back(name);
  }
  for (const ParameterInfo& key : core_keys()) properties[key.name] = schema_of(key, extent);
  Json schema = {{"properties", properties}};
  if (extent == Extent::whole) schema["required"] = required;
  return schema;
}

// What core_keys() cannot say of a few keys.
void refine(Json& properties) {
  properties["name"]["minLength"] = 1;
  properties["name"]["maxLength"] = 100;
  properties["name"]["pattern"] = "^[^/\\u0000-\\u001f\\u007f]*$";
  properties["name"].erase("default");  // the file's
  properties["world"]["properties"]["morphogens"]["properties"]["size"]["not"] = {
      {"multipleOf", 2}};
}

}  // namespace

std::string json_schema(const plugins::Registry& registry) {
  Json definitions = Json::object();
  Json whole = file_schema(registry, definitions, Extent::whole);
  Json part = file_schema(registry, definitions, Extent::part);
  refine(whole["properties"]);
  refine(part["properties"]);

  // Every key once more with its doc alone: editors offer these before they look further.
  Json properties = Json::object();
  for (const ParameterInfo& key : core_keys()) properties[key.name] = {{"description", key.doc}};
  for (const OtherKey& key : other_keys_described())
    properties[key.name] = {{"description", key.doc}};
  properties["extends"].update({{"type", "string"}, {"minLength", 1}});
  properties["plugins"].update({{"type", "array"}, {"items", {{"type", "string"}}}});

  const Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                       {"title", "SOMAS experiment"},
                       {"description", "Printed by `somas-host schema`; see docs/editors.md"},
                       {"type", "object"},
                       {"properties", properties},
                       {"additionalProperties", false},
                       {"if", {{"required", {"extends"}}}},
                       {"then", part},
                       {"else", whole},
                       {"definitions", definitions}};
  return schema.dump(2) + "\n";
}

}  // namespace somas::experiment
