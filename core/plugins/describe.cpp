#include "core/plugins/describe.hpp"

#include "core/plugins/declarations.hpp"
#include "core/plugins/example.hpp"
#include "core/plugins/relations.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/yaml_text.hpp"

namespace somas::plugins {
namespace {

std::string spaces(int count) { return std::string(static_cast<std::size_t>(count), ' '); }

// Short, for columns.
std::string type_name(const ParameterInfo& info) {
  switch (info.kind) {
    case ParameterKind::number:
      return "number";
    case ParameterKind::integer:
      return "integer";
    case ParameterKind::boolean:
      return "boolean";
    case ParameterKind::text:
      return "text";
    case ParameterKind::choice:
      return "choice";
    case ParameterKind::list:
      return "list of " + type_name(info.fields[0]) + "s";
    case ParameterKind::group:
      return "mapping";
    case ParameterKind::table:
      return "names to numbers";
    case ParameterKind::none:
      break;
  }
  return "nothing";
}

std::string allowed_alone(const ParameterInfo& info) {
  if (info.kind == ParameterKind::choice) return join(choices_of(info));
  if (info.kind == ParameterKind::boolean) return "true, false";
  if (info.kind == ParameterKind::list) {
    const std::string count = count_text(info);
    const bool plain = info.fields[0].kind != ParameterKind::group;
    const std::string element = plain ? allowed_alone(info.fields[0]) : "";
    return count.empty() || element.empty() ? count + element : count + ", each " + element;
  }
  std::string range = range_text(info);
  const bool has_unit = info.unit != nullptr && *info.unit != '\0';
  if (range.empty() && has_unit) return std::string("[").append(info.unit).append("]");
  return range;
}

// With what other parameters ask.
std::string allowed(const ParameterInfo& info) {
  std::string text = allowed_alone(info);
  for (const Relation& relation : relations_of(info))
    text.append(text.empty() ? "" : "; ").append(relation_text(relation));
  return text;
}

// Lists of mappings and other long defaults are written out in YAML only.
std::string default_text(const ParameterInfo& info) {
  if (info.required != 0) return "required";
  const ParameterValue value = default_of(info);
  if (value.kind == ParameterKind::none) return "none";
  if (is_inline(value)) return yaml_inline(value);
  if (value.kind == ParameterKind::table) {
    std::string entries;
    for (const ParameterValue& entry : value.items)
      entries.append(entries.empty() ? "{" : ", ")
          .append(yaml_text(entry.key))
          .append(": ")
          .append(yaml_inline(entry));
    return entries.append("}");
  }
  if (value.kind != ParameterKind::list) return "";
  return value.items.size() == 1 ? "1 entry" : std::to_string(value.items.size()) + " entries";
}

// What a parameter is made of, and how that is written in a key path.
struct Nested {
  std::span<const ParameterInfo> fields;
  const char* suffix = "";
};

Nested nested(const ParameterInfo& info) {
  if (info.kind == ParameterKind::group) return {fields_of(info), "."};
  const bool of_groups = info.kind == ParameterKind::list && info.field_count == 1 &&
                         info.fields[0].kind == ParameterKind::group;
  if (of_groups) return {fields_of(info.fields[0]), "[]."};
  return {};
}

void text_lines(std::string& out, std::span<const ParameterInfo> parameters,
                const std::string& prefix) {
  for (const ParameterInfo& info : parameters) {
    const std::string range = allowed(info), fallback = default_text(info);
    out += "  " + prefix + info.name + ": " + type_name(info);
    if (!fallback.empty()) out += fallback == "required" ? ", required" : ", default " + fallback;
    if (!range.empty()) out += ", allowed " + range;
    out += "\n      " + std::string(info.doc) + "\n";
    const Nested below = nested(info);
    text_lines(out, below.fields, prefix + info.name + below.suffix);
  }
}

void yaml_lines(std::string& out, std::span<const ParameterInfo> parameters, int indent);

// A list with one element, in which every field is noted.
void example_element(std::string& out, const ParameterInfo& list, int indent) {
  std::string element;
  yaml_lines(element, fields_of(list.fields[0]), indent + 4);
  element[static_cast<std::size_t>(indent) + 2] = '-';
  out += spaces(indent) + list.name + ":\n" + element;
}

// Puts every line behind a '#'.
std::string commented(const std::string& lines, int indent) {
  const auto margin = static_cast<std::size_t>(indent);
  std::string out;
  for (std::size_t begin = 0, end = 0; begin < lines.size(); begin = end + 1) {
    end = lines.find('\n', begin);
    out += spaces(indent) + "# " + lines.substr(begin + margin, end - begin - margin) + "\n";
  }
  return out;
}

void yaml_line(std::string& out, const ParameterInfo& info, int indent) {
  const std::string range = allowed(info);
  const std::string doc = std::string("# ") + info.doc + (range.empty() ? "" : "; " + range);
  const bool required = info.required != 0;
  const ParameterValue value = required ? example_of(info) : default_of(info);
  if (info.kind == ParameterKind::list && *nested(info).suffix != '\0' &&
      (required || value.items.empty())) {
    // Required, an element stands there; else it is told.
    out += spaces(indent) + doc + (required ? " (required)\n" : "; an element is\n");
    std::string element;
    example_element(element, info, indent);
    out += required ? element : commented(element, indent);
    if (!required) out += spaces(indent) + info.name + ": []\n";
  } else if (value.kind == ParameterKind::none) {
    out += spaces(indent) + "# " + info.name + ":  " + doc + " (optional)\n";
  } else if (is_inline(value)) {
    out += spaces(indent) + info.name + ": " + yaml_inline(value) + "  " + doc +
           (required ? " (required)\n" : "\n");
  } else if (info.kind == ParameterKind::group) {
    out += spaces(indent) + info.name + ":  " + doc + "\n";
    yaml_lines(out, fields_of(info), indent + 2);
  } else {
    out += spaces(indent) + doc + "\n";
    write_field(out, value, indent);
  }
}

void yaml_lines(std::string& out, std::span<const ParameterInfo> parameters, int indent) {
  for (const ParameterInfo& info : parameters) yaml_line(out, info, indent);
}

// A bar would end the cell.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? "\\|" : std::string(1, c);
  return safe;
}

// How an experiment names the class, with examples of what is required.
std::string block_of(const PluginClass& described) {
  const std::string id = described.id();
  const bool is_environment = described.info->kind == PluginKind::environment;
  std::string required;
  for (const ParameterInfo& info : described.parameters())
    if (info.required != 0) write_field(required, example_of(info), is_environment ? 4 : 2);
  if (is_environment)
    return "environments:\n  " + id + (required.empty() ? ": {}\n" : ":\n" + required);
  const std::string kind = kind_name(described.info->kind);
  return required.empty() ? kind + ": {plugin: " + id + "}\n"
                          : kind + ":\n  plugin: " + id + "\n" + required;
}

}  // namespace

std::string markdown_rows(std::span<const ParameterInfo> parameters, const std::string& prefix) {
  std::string rows;
  for (const ParameterInfo& info : parameters) {
    const std::string fallback = default_text(info);
    const bool is_code = !fallback.empty() && fallback != "required" && fallback != "none" &&
                         !fallback.ends_with(" entries") && fallback != "1 entry";
    const std::string shown = is_code ? std::string("`").append(cell(fallback)) + "`" : fallback;
    rows.append("| `").append(prefix).append(info.name).append("` | ").append(type_name(info));
    rows.append(" | ").append(shown).append(" | ").append(cell(allowed(info)));
    rows.append(" | ").append(cell(info.doc)).append(" |\n");
    const Nested below = nested(info);
    rows += markdown_rows(below.fields, prefix + info.name + below.suffix);
  }
  return rows;
}

std::string describe(const PluginClass& described, DescribeFormat format) {
  const std::string id = described.id(), kind = kind_name(described.info->kind);
  std::string out;
  switch (format) {
    case DescribeFormat::text:
      out = id + " (" + kind + "): " + described.info->doc + "\n" + described.library->id() + " " +
            described.library->version() + ", " + described.library->file().string() + "\n";
      if (described.parameters().empty()) return out + "no parameters\n";
      out += "parameters:\n";
      text_lines(out, described.parameters(), "");
      return out;
    case DescribeFormat::yaml:
      out.append("# ").append(described.info->doc).append("\n");
      // Environments stand below a name of their own.
      if (described.info->kind == PluginKind::environment) {
        out += "environments:\n  " + id + ":\n    plugin: " + id + "\n";
        yaml_lines(out, described.parameters(), 4);
        return out;
      }
      out += kind + ":\n  plugin: " + id + "\n";
      yaml_lines(out, described.parameters(), 2);
      return out;
    case DescribeFormat::markdown:
      break;
  }
  out = "# `" + id + "` (" + kind + ")\n\n" + described.info->doc + ".\n\nIn the library `" +
        described.library->id() + "`; in an experiment:\n\n```yaml\n" + block_of(described) +
        "```\n\n## Parameters\n\n";
  if (described.parameters().empty())
    out += "No parameters.\n";
  else
    out += markdown_header + markdown_rows(described.parameters());
  const std::string declared = declarations(described);
  return declared.empty() ? out : out + "\n## What it declares\n\n" + declared;
}

std::string listing(const Registry& registry) {
  std::string out;
  for (const Candidate& candidate : registry.candidates()) {
    if (candidate.library == nullptr) continue;
    const Library& library = *candidate.library;
    out += library.id() + " " + library.version() + "  " + candidate.file.string() + "\n";
    for (const ClassInfo& info : library.classes())
      out += "  " + std::string(info.id) + " (" + kind_name(info.kind) + "): " + info.doc + "\n";
  }
  if (out.empty()) out = "no plugins\n";

  for (const Candidate& candidate : registry.candidates())
    if (candidate.library == nullptr)
      out += "rejected: " + candidate.file.string() + ": " + candidate.reason + "\n";
  for (const auto& [id, files] : registry.duplicates()) {
    out += "defined more than once, so not usable: " + id + "\n";
    for (const std::filesystem::path& file : files) out += "  " + file.string() + "\n";
  }

  out += "search path:\n";
  for (const SearchDirectory& place : registry.search_path()) {
    std::error_code error;
    const bool exists = std::filesystem::is_directory(place.directory, error);
    out += "  " + place.directory.string() + " (" + place.source +
           (exists ? ")\n" : ", does not exist)\n");
  }
  return out;
}

}  // namespace somas::plugins
