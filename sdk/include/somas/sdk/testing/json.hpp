/// @file
/// One JSON value in memory, behind the SDK's JsonWriter and JsonReader. Numbers are kept exactly,
/// as the host's text keeps them.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "somas/sdk/heritable.hpp"

namespace somas::testing {

/// A value with its members or items. Reading what is missing or of another type throws
/// std::runtime_error that names the place, as in the host.
class JsonValue final : public JsonReader {
 public:
  /// What a value is.
  enum class Kind {
    object,   ///< members by key
    list,     ///< items in order
    number,   ///< a double
    integer,  ///< a 64-bit integer
    text      ///< a string, or a key64
  };

  /// An empty one; errors name its `place`.
  explicit JsonValue(Kind kind = Kind::object, std::string place = "genes")
      : kind_(kind), place_(std::move(place)) {}

  [[nodiscard]] bool has(std::string_view key) const override { return find(key) != nullptr; }
  [[nodiscard]] const JsonReader& member(std::string_view key) const override {
    require(Kind::object, "an object");
    if (const JsonValue* found = find(key)) return *found;
    throw std::runtime_error(place_ + ": \"" + std::string(key) + "\" is missing");
  }
  [[nodiscard]] std::size_t size() const override {
    require(Kind::list, "a list");
    return children_.size();
  }
  [[nodiscard]] const JsonReader& item(std::size_t i) const override {
    if (i >= size())
      throw std::runtime_error(place_ + ": item " + std::to_string(i) + " is missing");
    return *children_[i];
  }
  [[nodiscard]] double number() const override {
    if (kind_ == Kind::integer) return static_cast<double>(integer_);
    require(Kind::number, "a number");
    return number_;
  }
  [[nodiscard]] std::int64_t integer() const override {
    require(Kind::integer, "an integer");
    return integer_;
  }
  [[nodiscard]] std::string_view text() const override {
    require(Kind::text, "a text");
    return text_;
  }
  [[nodiscard]] std::uint64_t key64() const override {
    constexpr std::string_view digits = "0123456789abcdef";
    std::uint64_t value = 0;
    for (const char c : text()) {
      const std::size_t digit = digits.find(c);
      if (digit == std::string_view::npos || text_.size() != 16)
        throw std::runtime_error(place_ + ": expected 16 hexadecimal digits");
      value = value << 4 | digit;
    }
    return value;
  }

 private:
  friend class JsonTree;

  [[nodiscard]] const JsonValue* find(std::string_view key) const {
    if (kind_ != Kind::object) return nullptr;
    for (std::size_t i = 0; i < keys_.size(); ++i)
      if (keys_[i] == key) return children_[i].get();
    return nullptr;
  }
  void require(Kind kind, const char* what) const {
    if (kind_ != kind) throw std::runtime_error(place_ + ": expected " + what);
  }

  Kind kind_;
  std::string place_;
  double number_ = 0;
  std::int64_t integer_ = 0;
  std::string text_;
  std::vector<std::string> keys_;  ///< of an object, beside the children
  std::vector<std::unique_ptr<JsonValue>> children_;
};

/// Writes the members of one object. Throws std::logic_error on what is no JSON: a number that is
/// not finite, a key twice, a member without a key, a list's item with one, a close too many.
class JsonTree final : public JsonWriter {
 public:
  /// An empty object.
  JsonTree() : open_{&root_} {}
  JsonTree(const JsonTree&) = delete;
  JsonTree& operator=(const JsonTree&) = delete;

  void open_object(std::string_view key) override {
    open_.push_back(&add(key, JsonValue::Kind::object));
  }
  void open_list(std::string_view key) override {
    open_.push_back(&add(key, JsonValue::Kind::list));
  }
  void close() override {
    if (open_.size() <= 1) throw std::logic_error("JSON: one close() too many");
    open_.pop_back();
  }
  void number(std::string_view key, double value) override {
    if (!std::isfinite(value))
      throw std::logic_error("JSON: the number '" + std::string(key) + "' is not finite");
    add(key, JsonValue::Kind::number).number_ = value;
  }
  void integer(std::string_view key, std::int64_t value) override {
    add(key, JsonValue::Kind::integer).integer_ = value;
  }
  void text(std::string_view key, std::string_view value) override {
    add(key, JsonValue::Kind::text).text_ = value;
  }
  void key64(std::string_view key, std::uint64_t value) override {
    std::string digits(16, '0');
    for (std::size_t i = 16; i-- > 0; value >>= 4) digits[i] = "0123456789abcdef"[value & 15];
    add(key, JsonValue::Kind::text).text_ = digits;
  }

  /// What was written. Throws std::logic_error while an object or list is still open.
  [[nodiscard]] const JsonValue& root() const {
    if (open_.size() != 1) throw std::logic_error("JSON: a close() is missing");
    return root_;
  }

 private:
  JsonValue& add(std::string_view key, JsonValue::Kind kind) {
    JsonValue& parent = *open_.back();
    const bool in_list = parent.kind_ == JsonValue::Kind::list;
    const std::string name(key);
    if (in_list && !name.empty()) throw std::logic_error("JSON: a key in a list: '" + name + "'");
    if (!in_list && name.empty()) throw std::logic_error("JSON: a member needs a key");
    if (!in_list && parent.has(key)) throw std::logic_error("JSON: the key '" + name + "' twice");
    if (!in_list) parent.keys_.push_back(name);
    const std::string place =
        parent.place_ +
        (in_list ? "[" + std::to_string(parent.children_.size()) + "]" : "." + name);
    return *parent.children_.emplace_back(std::make_unique<JsonValue>(kind, place));
  }

  JsonValue root_;
  std::vector<JsonValue*> open_;
};

}  // namespace somas::testing
