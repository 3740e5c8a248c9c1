#include "core/plugins/example.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace somas::plugins {
namespace {

// A number in range; the least one where there is one.
double number_in_range(const ParameterInfo& info) {
  if (in_range(info, 1)) return 1;
  if (in_range(info, info.minimum)) return info.minimum;
  const double above = std::isfinite(info.maximum) ? info.maximum : info.minimum + 1;
  return in_range(info, above) ? above : 0;
}

}  // namespace

ParameterValue example_of(const ParameterInfo& info) {
  ParameterValue value;
  if (info.kind == ParameterKind::group) value = example_of(fields_of(info));
  value.kind = info.kind;
  value.key = info.name;
  if (info.kind == ParameterKind::number) value.number = number_in_range(info);
  if (info.kind == ParameterKind::integer)
    value.integer = static_cast<std::int64_t>(number_in_range(info));
  if (info.kind == ParameterKind::text) value.text = "example";
  if (info.kind == ParameterKind::choice) value.text = info.choices[0];
  if (info.kind == ParameterKind::list) {
    value.items.assign(std::max<std::uint64_t>(1, info.minimum_count), example_of(info.fields[0]));
    for (ParameterValue& item : value.items) item.key.clear();
  }
  return value;
}

ParameterValue example_of(std::span<const ParameterInfo> fields) {
  ParameterValue group;
  group.kind = ParameterKind::group;
  for (const ParameterInfo& info : fields) {
    ParameterValue example;
    if (info.required != 0 || info.kind == ParameterKind::group) example = example_of(info);
    const bool needed = info.required != 0 || !example.items.empty();
    if (needed) group.items.push_back(std::move(example));
  }
  return group;
}

}  // namespace somas::plugins
