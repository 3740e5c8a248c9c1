// Parameter values that the host owns, and their way across the plugin boundary.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "somas/sdk/parameters.hpp"

namespace somas::plugins {

/// A parameter's value with everything below it. kind none: no value (an optional one left out).
struct ParameterValue {
  ParameterKind kind = ParameterKind::none;
  double number = 0;
  std::int64_t integer = 0;           ///< integers, and booleans as 0 or 1
  std::string text;                   ///< texts and choices
  std::string key;                    ///< name within the enclosing group or table
  std::vector<ParameterValue> items;  ///< list elements, group fields, table entries

  [[nodiscard]] const ParameterValue* find(std::string_view name) const;
  friend bool operator==(const ParameterValue&, const ParameterValue&) = default;
};

/// A ParameterValue in the SDK's plain form. The value must outlive it and stay unchanged.
class PackedValue {
 public:
  explicit PackedValue(const ParameterValue& root) : root_(pack(root)) {}
  PackedValue(const PackedValue&) = delete;
  PackedValue& operator=(const PackedValue&) = delete;

  [[nodiscard]] const Value& value() const { return root_; }

 private:
  Value pack(const ParameterValue& from);

  std::deque<std::vector<Value>> arrays_;
  Value root_;
};

/// The fields of a group or, for a list, its single element description.
[[nodiscard]] inline std::span<const ParameterInfo> fields_of(const ParameterInfo& info) {
  return {info.fields, info.field_count};
}

/// An owning copy.
[[nodiscard]] ParameterValue copy_of(const Value& value);
/// The default; kind none where there is none.
[[nodiscard]] ParameterValue default_of(const ParameterInfo& info);
/// A group of the defaults of `fields`; those without one are left out.
[[nodiscard]] ParameterValue defaults_of(std::span<const ParameterInfo> fields);

/// A decimal that reads back as the same double: digits for whole numbers, else the shortest.
[[nodiscard]] std::string format_number(double number);
/// "0 to 1", "at least 1", "greater than 0", with the unit; empty when everything is allowed.
[[nodiscard]] std::string range_text(const ParameterInfo& info);
/// "2 to 8 elements", "at least 1 element"; empty when any number is allowed.
[[nodiscard]] std::string count_text(const ParameterInfo& list);
/// "a number", "an integer", "a list of ...".
[[nodiscard]] std::string kind_text(const ParameterInfo& info);
/// Whether a number or integer lies in the parameter's range.
[[nodiscard]] bool in_range(const ParameterInfo& info, double number);
/// A parameter's choices.
[[nodiscard]] std::vector<std::string> choices_of(const ParameterInfo& info);

}  // namespace somas::plugins
