// JSON as the run directory holds it, and the host's side of JsonWriter and JsonReader.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "somas/sdk/heritable.hpp"

#include "core/run/errors.hpp"

namespace somas::run {

/// Members keep their order.
using Json = nlohmann::ordered_json;

/// Two spaces a level; lists of plain values are filled up to 100 columns, small objects stay on
/// one line. Doubles are written as the shortest decimals that read back exactly.
[[nodiscard]] std::string to_text(const Json& json);

/// Throws UsageError with `origin`, line and column.
[[nodiscard]] Json parse_json(std::string_view text, const std::string& origin);

/// 16 hexadecimal digits.
[[nodiscard]] std::string hex64(std::uint64_t value);
[[nodiscard]] std::optional<std::uint64_t> parse_hex64(std::string_view text);

/// Two hexadecimal digits a byte.
[[nodiscard]] std::string hex_bytes(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::optional<std::vector<std::uint8_t>> parse_hex_bytes(std::string_view text);

/// Writes members into a JSON object.
class JsonBuilder final : public JsonWriter {
 public:
  /// `object` is made an object and must outlive this.
  explicit JsonBuilder(Json& object);

  void open_object(std::string_view key) override;
  void open_list(std::string_view key) override;
  void close() override;
  void number(std::string_view key, double value) override;
  void integer(std::string_view key, std::int64_t value) override;
  void text(std::string_view key, std::string_view value) override;
  void key64(std::string_view key, std::uint64_t value) override;

 private:
  Json& put(std::string_view key, Json value);
  std::vector<Json*> open_;
};

/// Reads a JSON value; what is missing or of another type is a UsageError that names the place.
class JsonView final : public JsonReader {
 public:
  /// `json` must outlive this. `place` names it in messages ("champion.json: genome").
  JsonView(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  [[nodiscard]] bool has(std::string_view key) const override;
  [[nodiscard]] const JsonView& member(std::string_view key) const override;
  [[nodiscard]] std::size_t size() const override;
  [[nodiscard]] const JsonView& item(std::size_t i) const override;
  [[nodiscard]] double number() const override;
  [[nodiscard]] std::int64_t integer() const override;
  [[nodiscard]] std::string_view text() const override;
  [[nodiscard]] std::uint64_t key64() const override;
  /// Beyond the SDK: a non-negative integer, and a boolean.
  [[nodiscard]] std::uint64_t natural() const;
  [[nodiscard]] bool boolean() const;

  [[nodiscard]] const std::string& place() const { return place_; }
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  const Json& json_;
  std::string place_;
  // Views that were handed out: the interface returns references.
  mutable std::map<std::string, std::unique_ptr<JsonView>, std::less<>> members_;
  mutable std::map<std::size_t, std::unique_ptr<JsonView>> items_;
};

}  // namespace somas::run
