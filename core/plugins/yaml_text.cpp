#include "core/plugins/yaml_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace somas::plugins {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

// Words that a YAML reader, ours or another, takes for something else than a text.
bool is_reserved(std::string_view text) {
  constexpr std::array reserved = {"null", "true", "false", "yes", "no", "on",
                                   "off",  "nan",  "inf",   "y",   "n",  "infinity"};
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return std::find(reserved.begin(), reserved.end(), lower) != reserved.end();
}

bool is_plain(std::string_view text) {
  if (text.empty() || !(is_letter(text[0]) || text[0] == '/') || is_reserved(text)) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '/';
  });
}

std::string escaped(char c) {
  switch (c) {
    case '"':
      return "\\\"";
    case '\\':
      return "\\\\";
    case '\n':
      return "\\n";
    case '\t':
      return "\\t";
    case '\r':
      return "\\r";
    default:
      break;
  }
  const auto byte = static_cast<unsigned char>(c);
  if (byte >= 0x20 && byte != 0x7F) return {c};
  char text[8];
  std::snprintf(text, sizeof text, "\\x%02X", byte);
  return text;
}

bool is_mapping(const ParameterValue& value) {
  return value.kind == ParameterKind::group || value.kind == ParameterKind::table;
}

}  // namespace

std::string yaml_text(std::string_view text) {
  if (is_plain(text)) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += escaped(c);
  return quoted + '"';
}

bool is_inline(const ParameterValue& value) {
  if (value.items.empty()) return true;
  if (value.kind != ParameterKind::list) return false;
  return std::all_of(value.items.begin(), value.items.end(), [](const ParameterValue& item) {
    return !is_mapping(item) && item.kind != ParameterKind::list;
  });
}

std::string yaml_inline(const ParameterValue& value) {
  switch (value.kind) {
    case ParameterKind::none:
      return "null";
    case ParameterKind::number:
      return format_number(value.number);
    case ParameterKind::integer:
      return std::to_string(value.integer);
    case ParameterKind::boolean:
      return value.integer != 0 ? "true" : "false";
    case ParameterKind::text:
    case ParameterKind::choice:
      return yaml_text(value.text);
    case ParameterKind::group:
    case ParameterKind::table:
      return "{}";
    case ParameterKind::list:
      break;
  }
  std::string text = "[";
  for (const ParameterValue& item : value.items)
    text.append(text.size() > 1 ? ", " : "").append(yaml_inline(item));
  return text.append("]");
}

void write_fields(std::string& out, const ParameterValue& group, int indent) {
  for (const ParameterValue& field : group.items) write_field(out, field, indent);
}

void write_field(std::string& out, const ParameterValue& field, int indent) {
  if (field.kind == ParameterKind::none) return;
  out.append(static_cast<std::size_t>(indent), ' ').append(yaml_text(field.key)).append(":");
  if (is_inline(field)) {
    out.append(" ").append(yaml_inline(field)).append("\n");
    return;
  }
  out += "\n";
  if (is_mapping(field)) {
    write_fields(out, field, indent + 2);
    return;
  }

  // A list of mappings: the first field of each shares its line with the dash.
  for (const ParameterValue& item : field.items) {
    std::string lines;
    if (is_inline(item)) {
      lines = std::string(static_cast<std::size_t>(indent) + 4, ' ') + yaml_inline(item) + "\n";
    } else {
      write_fields(lines, item, indent + 4);
    }
    lines[static_cast<std::size_t>(indent) + 2] = '-';
    out += lines;
  }
}

}  // namespace somas::plugins
