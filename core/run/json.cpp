#include "core/run/json.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace somas::run {
namespace {

constexpr std::size_t line_width = 100;
constexpr std::size_t object_width = 140;

bool is_plain_list(const Json& json) {
  return json.is_array() && std::none_of(json.begin(), json.end(),
                                         [](const Json& item) { return item.is_structured(); });
}

void format(const Json& json, std::size_t depth, std::string& out);

void break_line(std::size_t depth, std::string& out) {
  out += '\n';
  out.append(2 * depth, ' ');
}

// Fills lines with values.
void format_plain_list(const Json& json, std::size_t depth, std::string& out) {
  std::vector<std::string> values;
  std::size_t total = 0;
  for (const Json& item : json) total += values.emplace_back(item.dump()).size() + 2;
  const std::size_t start = out.size() - (out.rfind('\n') + 1);
  const bool one_line = start + total + 2 <= line_width;

  out += '[';
  std::size_t column = line_width;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool last = i + 1 == values.size();
    if (!one_line && column + values[i].size() + 2 > line_width) {
      break_line(depth + 1, out);
      column = 2 * (depth + 1);
    } else if (i > 0) {
      out += ' ';
      ++column;
    }
    out += values[i];
    if (!last) out += ',';
    column += values[i].size() + 1;
  }
  if (!one_line) break_line(depth, out);
  out += ']';
}

void format_list(const Json& json, std::size_t depth, std::string& out) {
  out += '[';
  for (std::size_t i = 0; i < json.size(); ++i) {
    break_line(depth + 1, out);
    format(json[i], depth + 1, out);
    if (i + 1 < json.size()) out += ',';
  }
  break_line(depth, out);
  out += ']';
}

void format_object(const Json& json, std::size_t depth, std::string& out) {
  out += '{';
  std::size_t left = json.size();
  for (const auto& [key, value] : json.items()) {
    break_line(depth + 1, out);
    out += Json(key).dump();
    out += ": ";
    format(value, depth + 1, out);
    if (--left > 0) out += ',';
  }
  if (!json.empty()) break_line(depth, out);
  out += '}';
}

// A small object, such as a protein, reads best on one line.
bool is_small_object(const Json& json) {
  return json.is_object() && !json.empty() && json.size() <= 8 &&
         std::none_of(json.begin(), json.end(),
                      [](const Json& item) { return item.is_structured(); });
}

std::string one_line_object(const Json& json) {
  std::string out = "{";
  for (const auto& [key, value] : json.items()) {
    if (out.size() > 1) out += ", ";
    out += Json(key).dump() + ": " + value.dump();
  }
  return out + "}";
}

void format(const Json& json, std::size_t depth, std::string& out) {
  if (is_small_object(json)) {
    const std::string line = one_line_object(json);
    const std::size_t start = out.size() - (out.rfind('\n') + 1);
    if (start + line.size() + 1 <= object_width) {
      out += line;
      return;
    }
  }
  if (is_plain_list(json))
    format_plain_list(json, depth, out);
  else if (json.is_array())
    format_list(json, depth, out);
  else if (json.is_object())
    format_object(json, depth, out);
  else
    out += json.dump();
}

int digit_value(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  return -1;
}

}  // namespace

std::string to_text(const Json& json) {
  std::string out;
  format(json, 0, out);
  out += '\n';
  return out;
}

Json parse_json(std::string_view text, const std::string& origin) {
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::string_view before = text.substr(0, std::min(error.byte, text.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    throw UsageError(origin + ":" + std::to_string(line) + ": not valid JSON");
  } catch (const nlohmann::json::exception& error) {
    // "[json.exception.out_of_range.406] number overflow ...": the library's own name for it.
    const std::string what = error.what();
    const std::size_t end = what.starts_with('[') ? what.find("] ") : std::string::npos;
    throw UsageError(origin +
                     ": not valid JSON: " + what.substr(end == std::string::npos ? 0 : end + 2));
  }
}

std::string hex64(std::uint64_t value) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; value >>= 4) text[i] = "0123456789abcdef"[value & 15];
  return text;
}

std::optional<std::uint64_t> parse_hex64(std::string_view text) {
  if (text.size() != 16) return std::nullopt;
  std::uint64_t value = 0;
  for (const char digit : text) {
    const int nibble = digit_value(digit);
    if (nibble < 0) return std::nullopt;
    value = value << 4 | static_cast<std::uint64_t>(nibble);
  }
  return value;
}

std::string hex_bytes(std::span<const std::uint8_t> bytes) {
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::optional<std::vector<std::uint8_t>> parse_hex_bytes(std::string_view text) {
  if (text.size() % 2 != 0) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const int high = digit_value(text[i]), low = digit_value(text[i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes.push_back(static_cast<std::uint8_t>(high << 4 | low));
  }
  return bytes;
}

JsonBuilder::JsonBuilder(Json& object) : open_{&object} { object = Json::object(); }

Json& JsonBuilder::put(std::string_view key, Json value) {
  if (open_.empty()) throw std::logic_error("JSON writer: one close() too many");
  Json& parent = *open_.back();
  if (parent.is_array()) {
    parent.push_back(std::move(value));
    return parent.back();
  }
  const std::string name(key);
  if (name.empty()) throw std::logic_error("JSON writer: a member needs a key");
  if (parent.contains(name)) throw std::logic_error("JSON writer: key " + name + " twice");
  return parent[name] = std::move(value);
}

void JsonBuilder::open_object(std::string_view key) { open_.push_back(&put(key, Json::object())); }

void JsonBuilder::open_list(std::string_view key) { open_.push_back(&put(key, Json::array())); }

void JsonBuilder::close() {
  if (open_.size() <= 1) throw std::logic_error("JSON writer: one close() too many");
  open_.pop_back();
}

void JsonBuilder::number(std::string_view key, double value) {
  if (!std::isfinite(value))
    throw std::logic_error("JSON writer: " + std::string(key) + " is not finite");
  put(key, value);
}

void JsonBuilder::integer(std::string_view key, std::int64_t value) { put(key, value); }

void JsonBuilder::text(std::string_view key, std::string_view value) {
  put(key, std::string(value));
}

void JsonBuilder::key64(std::string_view key, std::uint64_t value) { put(key, hex64(value)); }

void JsonView::fail(const std::string& expected) const {
  throw UsageError(place_ + ": expected " + expected + ", found " + json_.type_name());
}

bool JsonView::has(std::string_view key) const {
  return json_.is_object() && json_.contains(std::string(key));
}

const JsonView& JsonView::member(std::string_view key) const {
  if (!json_.is_object()) fail("an object");
  const std::string name(key);
  const auto found = json_.find(name);
  if (found == json_.end()) throw UsageError(place_ + ": \"" + name + "\" is missing");
  auto& view = members_[name];
  if (!view) view = std::make_unique<JsonView>(*found, place_ + "." + name);
  return *view;
}

std::size_t JsonView::size() const {
  if (!json_.is_array()) fail("a list");
  return json_.size();
}

const JsonView& JsonView::item(std::size_t i) const {
  if (i >= size())
    throw UsageError(place_ + ": has " + std::to_string(size()) + " items, item " +
                     std::to_string(i) + " is missing");
  auto& view = items_[i];
  if (!view) view = std::make_unique<JsonView>(json_[i], place_ + "[" + std::to_string(i) + "]");
  return *view;
}

double JsonView::number() const {
  if (!json_.is_number()) fail("a number");
  return json_.get<double>();
}

std::int64_t JsonView::integer() const {
  if (!json_.is_number_integer()) fail("an integer");
  if (json_.is_number_unsigned() && json_.get<std::uint64_t>() > INT64_MAX)
    fail("an integer below 2^63");
  return json_.get<std::int64_t>();
}

std::string_view JsonView::text() const {
  if (!json_.is_string()) fail("a text");
  return json_.get_ref<const std::string&>();
}

std::uint64_t JsonView::key64() const {
  const std::optional<std::uint64_t> value = parse_hex64(text());
  if (!value) fail("16 hexadecimal digits");
  return *value;
}

std::uint64_t JsonView::natural() const {
  if (!json_.is_number_unsigned()) fail("an integer, 0 or more");
  return json_.get<std::uint64_t>();
}

bool JsonView::boolean() const {
  if (!json_.is_boolean()) fail("true or false");
  return json_.get<bool>();
}

}  // namespace somas::run
