// Plugin classes and their parameters for people: as text, as YAML to paste, as Markdown.
#pragma once

#include <span>
#include <string>

#include "core/plugins/registry.hpp"

namespace somas::plugins {

enum class DescribeFormat { text, yaml, markdown };

/// A class with all its parameters; as Markdown a whole page, the class's reference, with what it
/// declares.
[[nodiscard]] std::string describe(const PluginClass& described, DescribeFormat format);

/// Rows of a Markdown table, a parameter each, nested ones as "group.field" and "list[].field".
[[nodiscard]] std::string markdown_rows(std::span<const ParameterInfo> parameters,
                                        const std::string& prefix = {});
inline constexpr const char* markdown_header =
    "| key | type | default | allowed | meaning |\n|---|---|---|---|---|\n";

/// Every file that was looked at, with its classes or the reason why it was rejected, ids that are
/// defined twice, and the search path.
[[nodiscard]] std::string listing(const Registry& registry);

}  // namespace somas::plugins
