#include "core/plugins/describe.hpp"

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

std::string allowed(const ParameterInfo& info) {
  if (info.kind == ParameterKind::choice) return join(choices_of(info));
  if (info.kind == ParameterKind::boolean) return "true, false";
  if (info.kind == ParameterKind::list && info.field_count == 1) return range_text(info.fields[0]);
  const std::string range = range_text(info);
  const bool has_unit = info.unit != nullptr && *info.unit != '\0';
  if (range.empty() && has_unit) return std::string("[").append(info.unit).append("]");
  return range;
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
  return value.kind == ParameterKind::list ? std::to_string(value.items.size()) + " entries" : "";
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

void yaml_lines(std::string& out, std::span<const ParameterInfo> parameters, int indent) {
  for (const ParameterInfo& info : parameters) {
    const std::string range = allowed(info);
    const std::string note = std::string("  # ") + info.doc + (range.empty() ? "" : "; " + range);
    const ParameterValue value = default_of(info);
    const bool whole = value.kind != ParameterKind::none && info.required == 0;
    if (!whole) {
      out += spaces(indent) + "# " + info.name + ":" + note +
             (info.required != 0 ? " (required)\n" : " (optional)\n");
    } else if (is_inline(value)) {
      out += spaces(indent) + info.name + ": " + yaml_inline(value) + note + "\n";
    } else if (info.kind == ParameterKind::group) {
      out += spaces(indent) + info.name + ":" + note + "\n";
      yaml_lines(out, fields_of(info), indent + 2);
    } else {
      out += spaces(indent) + "#" + note.substr(3) + "\n";
      write_field(out, value, indent);
    }
  }
}

// A bar would end the cell.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? "\\|" : std::string(1, c);
  return safe;
}

}  // namespace

std::string markdown_rows(std::span<const ParameterInfo> parameters, const std::string& prefix) {
  std::string rows;
  for (const ParameterInfo& info : parameters) {
    const std::string fallback = default_text(info);
    const bool is_code = !fallback.empty() && fallback != "required" && fallback != "none" &&
                         !fallback.ends_with(" entries");
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
  out = "### `" + id + "` (" + kind + ")\n\n" + described.info->doc + ".\n\n";
  if (described.parameters().empty()) return out + "No parameters.\n";
  return out + markdown_header + markdown_rows(described.parameters());
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
