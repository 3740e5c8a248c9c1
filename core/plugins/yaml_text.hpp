// Parameter values as YAML text that reads back to the same values.
#pragma once

#include <string>
#include <string_view>

#include "core/plugins/values.hpp"

namespace somas::plugins {

/// A text as a YAML scalar: plain where that is safe, else in double quotes.
[[nodiscard]] std::string yaml_text(std::string_view text);

/// A number, integer, boolean or text as a scalar; a list of those, an empty list or an empty
/// mapping in flow style. Precondition: is_inline(value).
[[nodiscard]] std::string yaml_inline(const ParameterValue& value);
[[nodiscard]] bool is_inline(const ParameterValue& value);

/// Appends a line per field (or more, where it is nested), `indent` spaces in.
void write_fields(std::string& out, const ParameterValue& group, int indent);
/// Appends "key: value" and what is nested below it.
void write_field(std::string& out, const ParameterValue& field, int indent);

}  // namespace somas::plugins
