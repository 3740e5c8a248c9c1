// Lines of comma-separated values, with numbers that read back exactly.
#pragma once

#include <charconv>
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

namespace somas::run {

/// Collects the fields of one line.
class CsvLine {
 public:
  CsvLine& add(std::string_view text) {
    separate();
    if (text.find_first_of(",\"\n\r") == std::string_view::npos) {
      line_ += text;
      return *this;
    }
    // RFC 4180: quoted, quotes doubled.
    line_ += '"';
    for (const char c : text) line_.append(c == '"' ? 2 : 1, c);
    line_ += '"';
    return *this;
  }

  /// Integers in decimal; doubles as the shortest decimal that reads back exactly.
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number> CsvLine& add(Number value) {
    separate();
    char digits[32];
    const char* end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    line_ += std::string_view(digits, static_cast<std::size_t>(end - digits));
    return *this;
  }

  /// The line with its newline; this becomes empty.
  [[nodiscard]] std::string take() {
    first_ = true;
    return std::exchange(line_, {}) + '\n';
  }

 private:
  void separate() {
    if (!std::exchange(first_, false)) line_ += ',';
  }

  std::string line_;
  bool first_ = true;
};

}  // namespace somas::run
