// Files that are whole or absent: whatever happens half-way, what was there before stays readable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/run/errors.hpp"

namespace somas::run {

/// Writes a temporary file beside `path`, flushes it to the disk and renames it into place. Throws
/// WriteError; then `path` is as it was and no temporary file is left.
void write_file(const std::filesystem::path& path, std::string_view content);

/// Writes where the user says: a regular or absent file as write_file does, at the end of symbolic
/// links; a device, a pipe or what the standard output already is, straight. Throws WriteError.
void write_output(const std::filesystem::path& path, std::string_view content);

/// Whether write_output could write there, as far as that can be told; touches nothing that is
/// there. Throws WriteError.
void check_output(const std::filesystem::path& path);

/// The file at the end of the symbolic links of `path`, absolute; it may be absent.
[[nodiscard]] std::filesystem::path target_of(const std::filesystem::path& path);

/// As write_file, but refuses (WriteError, EEXIST) to replace a file.
void create_file(const std::filesystem::path& path, std::string_view content);

/// Flushes the directory that `path` stands in, so that its name is durable; best effort.
void flush_directory_of(const std::filesystem::path& path);

/// The whole file. Throws UsageError, saying why, if it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// The same of a regular file of at most `limit` bytes; others are refused unopened.
[[nodiscard]] std::string read_regular_file(const std::filesystem::path& path, std::uint64_t limit);

/// XXH3-128 of a file's bytes, as 32 hexadecimal digits. Throws UsageError.
[[nodiscard]] std::string hash_of_file(const std::filesystem::path& path);

/// The same of a text.
[[nodiscard]] std::string hash_of_text(std::string_view text);

/// A file that only grows, by whole pieces.
class AppendFile {
 public:
  /// Makes the file, or replaces it, with this beginning. Throws WriteError.
  AppendFile(std::filesystem::path path, std::string_view beginning);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Adds a piece. Throws WriteError; then the file has been cut back to what it was.
  void append(std::string_view piece);
  /// Flushes what was added to the disk. Throws WriteError.
  void flush();
  /// Takes the last piece back, for when something that belongs to it failed.
  void undo() noexcept;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t size_before_ = 0;
};

}  // namespace somas::run
