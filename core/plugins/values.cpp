#include "core/plugins/values.hpp"

#include <charconv>
#include <cmath>
#include <limits>

#include "core/plugins/suggest.hpp"

namespace somas::plugins {

const ParameterValue* ParameterValue::find(std::string_view name) const {
  for (const ParameterValue& item : items)
    if (item.key == name) return &item;
  return nullptr;
}

Value PackedValue::pack(const ParameterValue& from) {
  Value to;
  to.kind = from.kind;
  to.number = from.number;
  to.integer = from.integer;
  to.text = from.text.c_str();
  to.key = from.key.c_str();

  // The array is complete before its address is taken.
  std::vector<Value> items;
  for (const ParameterValue& item : from.items)
    if (item.kind != ParameterKind::none) items.push_back(pack(item));
  if (items.empty()) return to;
  const std::vector<Value>& kept = arrays_.emplace_back(std::move(items));
  to.items = kept.data();
  to.count = kept.size();
  return to;
}

ParameterValue copy_of(const Value& value) {
  ParameterValue copy;
  copy.kind = value.kind;
  copy.number = value.number;
  copy.integer = value.integer;
  if (value.text != nullptr) copy.text = value.text;
  if (value.key != nullptr) copy.key = value.key;
  for (std::uint64_t i = 0; i < value.count; ++i) copy.items.push_back(copy_of(value.items[i]));
  return copy;
}

ParameterValue default_of(const ParameterInfo& info) {
  ParameterValue value;
  if (info.kind == ParameterKind::group) {
    value = defaults_of(fields_of(info));
  } else {
    value = copy_of(info.fallback);
  }
  value.key = info.name;

  // An element of a list may leave out fields of its group.
  const bool list_of_groups = info.kind == ParameterKind::list && info.field_count == 1 &&
                              info.fields[0].kind == ParameterKind::group;
  if (!list_of_groups) return value;
  for (ParameterValue& element : value.items) {
    ParameterValue whole = default_of(info.fields[0]);
    for (ParameterValue& field : whole.items)
      if (const ParameterValue* given = element.find(field.key)) field = *given;
    for (ParameterValue& field : element.items)
      if (whole.find(field.key) == nullptr) whole.items.push_back(field);
    element = std::move(whole);
  }
  return value;
}

ParameterValue defaults_of(std::span<const ParameterInfo> fields) {
  ParameterValue group;
  group.kind = ParameterKind::group;
  for (const ParameterInfo& field : fields)
    if (ParameterValue value = default_of(field); value.kind != ParameterKind::none)
      group.items.push_back(std::move(value));
  return group;
}

std::string format_number(double number) {
  // Whole numbers read better without an exponent.
  constexpr double exact = 1e15;
  const bool whole = std::trunc(number) == number && std::abs(number) < exact;
  char text[32];
  const auto end = whole ? std::to_chars(text, text + sizeof text, number, std::chars_format::fixed)
                         : std::to_chars(text, text + sizeof text, number);
  return {text, end.ptr};
}

std::string range_text(const ParameterInfo& info) {
  const bool below = std::isfinite(info.minimum), above = std::isfinite(info.maximum);
  const std::string open = info.minimum_open != 0 ? "greater than " : "";
  std::string text;
  if (below && info.minimum == info.maximum)
    text = format_number(info.minimum);
  else if (below && above && open.empty())
    text = format_number(info.minimum) + " to " + format_number(info.maximum);
  else if (below && above)
    text = open + format_number(info.minimum) + ", at most " + format_number(info.maximum);
  else if (below)
    text = (open.empty() ? "at least " : open) + format_number(info.minimum);
  else if (above)
    text = "at most " + format_number(info.maximum);
  const bool has_unit = info.unit != nullptr && *info.unit != '\0';
  return text.empty() || !has_unit ? text : text + " [" + info.unit + "]";
}

std::string count_text(const ParameterInfo& list) {
  const bool above = list.maximum_count != std::numeric_limits<std::uint64_t>::max();
  const std::string least = std::to_string(list.minimum_count);
  if (above && list.minimum_count == list.maximum_count)
    return plural(list.minimum_count, "element");
  if (above && list.minimum_count > 0)
    return least + " to " + plural(list.maximum_count, "element");
  if (above) return "at most " + plural(list.maximum_count, "element");
  return list.minimum_count > 0 ? "at least " + plural(list.minimum_count, "element") : "";
}

std::string kind_text(const ParameterInfo& info) {
  switch (info.kind) {
    case ParameterKind::none:
      return "nothing";
    case ParameterKind::number:
      return "a number";
    case ParameterKind::integer:
      return "an integer";
    case ParameterKind::boolean:
      return "true or false";
    case ParameterKind::text:
      return "a text";
    case ParameterKind::choice:
      return "one of a set of words";
    case ParameterKind::list:
      return "a list";
    case ParameterKind::group:
      return "a mapping";
    case ParameterKind::table:
      return "a mapping of names to numbers";
  }
  return "a value";
}

bool in_range(const ParameterInfo& info, double number) {
  if (number < info.minimum || number > info.maximum) return false;
  return info.minimum_open == 0 || number > info.minimum;
}

std::vector<std::string> choices_of(const ParameterInfo& info) {
  return {info.choices, info.choices + info.choice_count};
}

}  // namespace somas::plugins
