// A text file that an export writes piece by piece.
#pragma once

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace somas::report {

/// The shortest decimal that reads back exactly.
template <class Number>
[[nodiscard]] std::string decimal(Number value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

/// A name as part of a file's: letters, digits, '.', '-' and '_' stay.
[[nodiscard]] std::string file_part(std::string_view name);

class ExportFile {
 public:
  /// Throws run::WriteError, as all calls do.
  explicit ExportFile(std::filesystem::path path);
  void write(std::string_view text);
  void close();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::ofstream out_;
};

}  // namespace somas::report
