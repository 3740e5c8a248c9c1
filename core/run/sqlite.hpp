// SQLite with destructors and exceptions: the little of it that a run's store needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/run/errors.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace somas::run {

/// A database that is damaged, or is none of ours (exit code 2).
class DamagedStore : public UsageError {
 public:
  using UsageError::UsageError;
};

/// A connection; used by one thread at a time.
///
/// All calls of both classes throw WriteError (disk full, no permission, an error of the device)
/// and DamagedStore.
class Database {
 public:
  enum class Access { create, write, read };

  /// `create`: the file must not exist. `read`: also works where nothing may be written.
  Database(std::filesystem::path file, Access access);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// One or more statements without results.
  void execute(const char* sql) const;
  /// The first column of the first row, as text; empty without a row.
  [[nodiscard]] std::string text_of(const char* sql) const;
  [[nodiscard]] std::int64_t integer_of(const char* sql) const;
  /// Whether a transaction is open.
  [[nodiscard]] bool in_transaction() const;

  /// Throws what `code`, a result of SQLite's, means.
  [[noreturn]] void fail(int code) const;
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  sqlite3* handle_ = nullptr;
};

using Bytes = std::span<const std::uint8_t>;

/// A prepared statement. Texts and bytes that are bound must live until the next step; those of a
/// column are valid until the next step.
class Statement {
 public:
  /// `database` must outlive this.
  Statement(const Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// Begins anew with these values for its parameters, in order. nullopt is NULL.
  template <class... T>
  Statement& with(const T&... values) {
    reset();
    int place = 0;
    (bind(++place, values), ...);
    return *this;
  }
  /// To the next row; false after the last.
  bool step();
  /// To the end.
  void run();

  [[nodiscard]] int columns() const;
  [[nodiscard]] std::string_view column_name(int column) const;
  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] std::uint64_t natural(int column) const {
    return static_cast<std::uint64_t>(integer(column));
  }
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string_view text(int column) const;
  [[nodiscard]] Bytes bytes(int column) const;

  enum class Type { null, integer, real, text, bytes };
  [[nodiscard]] Type type(int column) const;

 private:
  void reset();
  void bind(int place, std::nullopt_t);
  void bind(int place, std::int64_t value);
  void bind(int place, std::uint64_t value) { bind(place, static_cast<std::int64_t>(value)); }
  void bind(int place, std::uint32_t value) { bind(place, static_cast<std::int64_t>(value)); }
  void bind(int place, bool value) { bind(place, static_cast<std::int64_t>(value)); }
  void bind(int place, double value);
  void bind(int place, std::string_view value);
  void bind(int place, const std::string& value) { bind(place, std::string_view(value)); }
  void bind(int place, const char* value) { bind(place, std::string_view(value)); }
  void bind(int place, Bytes value);
  template <class T>
  void bind(int place, const std::optional<T>& value) {
    if (value)
      bind(place, *value);
    else
      bind(place, std::nullopt);
  }
  void check(int code) const;

  const Database& database_;
  sqlite3_stmt* handle_ = nullptr;
};

}  // namespace somas::run
