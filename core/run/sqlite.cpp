#include "core/run/sqlite.hpp"

#include <cerrno>
#include <sqlite3.h>
#include <stdexcept>
#include <unistd.h>
#include <utility>

namespace somas::run {
namespace {

constexpr int patience = 10'000;  // milliseconds to wait for another program that has it locked

/// The file as a URI, so that options can follow.
std::string uri_of(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    const bool special = c == '%' || c == '?' || c == '#';
    if (special)
      uri += c == '%' ? "%25" : c == '?' ? "%3f" : "%23";
    else
      uri += c;
  }
  return uri;
}

// A database in WAL mode needs files beside it, even to be read. Where none can be made, nobody can
// be writing either.
bool can_have_neighbours(const std::filesystem::path& file) {
  const std::filesystem::path parent = file.has_parent_path() ? file.parent_path() : ".";
  return ::access(parent.c_str(), W_OK) == 0;
}

}  // namespace

Database::Database(std::filesystem::path file, Access access) : file_(std::move(file)) {
  int flags = SQLITE_OPEN_URI | SQLITE_OPEN_EXRESCODE | SQLITE_OPEN_NOMUTEX;
  std::string name = uri_of(file_);
  if (access == Access::create) flags |= SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  if (access == Access::write) flags |= SQLITE_OPEN_READWRITE;
  if (access == Access::read) {
    flags |= SQLITE_OPEN_READONLY;
    if (!can_have_neighbours(file_)) name += "?immutable=1";
  }
  const int code = sqlite3_open_v2(name.c_str(), &handle_, flags, nullptr);
  if (code == SQLITE_OK) {
    sqlite3_busy_timeout(handle_, patience);
    return;
  }
  try {
    fail(code);
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
}

Database::~Database() { sqlite3_close(handle_); }

void Database::execute(const char* sql) const {
  if (const int code = sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr)) fail(code);
}

std::string Database::text_of(const char* sql) const {
  Statement statement(*this, sql);
  return statement.step() ? std::string(statement.text(0)) : "";
}

std::int64_t Database::integer_of(const char* sql) const {
  Statement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

bool Database::in_transaction() const { return sqlite3_get_autocommit(handle_) == 0; }

void Database::fail(int code) const {
  // SQLite does not keep the reason of a failed write; nothing has come in between.
  const int last = errno;
  const std::string what = sqlite3_errmsg(handle_);
  const int known = sqlite3_system_errno(handle_), error = known != 0 ? known : last;
  switch (code & 0xFF) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_FORMAT:
      throw DamagedStore(file_.string() + " is damaged: " + what);
    case SQLITE_FULL:
      throw WriteError(file_, ENOSPC);
    case SQLITE_READONLY:
      throw WriteError(file_, error != 0 ? error : EROFS);
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_IOERR:
      throw WriteError(file_, error != 0 ? error : EIO);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw WriteError("cannot write " + file_.string() + ": another program keeps it locked",
                       file_, EBUSY);
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    default:
      // No such table, no such column: a file that lost some of itself.
      if ((code & 0xFF) == SQLITE_ERROR)
        throw DamagedStore(file_.string() + " is damaged, or from another version: " + what);
      throw std::runtime_error(file_.string() + ": " + what);
  }
}

Statement::Statement(const Database& database, std::string_view sql) : database_(database) {
  check(sqlite3_prepare_v3(database.handle(), sql.data(), static_cast<int>(sql.size()),
                           SQLITE_PREPARE_PERSISTENT, &handle_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(handle_); }

void Statement::check(int code) const {
  if (code != SQLITE_OK && code != SQLITE_ROW && code != SQLITE_DONE) database_.fail(code);
}

// The error of the last step was thrown already.
void Statement::reset() { sqlite3_reset(handle_); }

bool Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) {
    // fail() first: a reset would clear the message.
    try {
      database_.fail(code);
    } catch (...) {
      reset();
      throw;
    }
  }
  reset();
  return false;
}

void Statement::run() {
  while (step()) {
  }
}

int Statement::columns() const { return sqlite3_column_count(handle_); }

std::string_view Statement::column_name(int column) const {
  return sqlite3_column_name(handle_, column);
}

bool Statement::is_null(int column) const { return type(column) == Type::null; }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_, column); }

double Statement::real(int column) const { return sqlite3_column_double(handle_, column); }

std::string_view Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

Bytes Statement::bytes(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(handle_, column));
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

Statement::Type Statement::type(int column) const {
  switch (sqlite3_column_type(handle_, column)) {
    case SQLITE_INTEGER:
      return Type::integer;
    case SQLITE_FLOAT:
      return Type::real;
    case SQLITE_TEXT:
      return Type::text;
    case SQLITE_BLOB:
      return Type::bytes;
    default:
      return Type::null;
  }
}

void Statement::bind(int place, std::nullopt_t) { check(sqlite3_bind_null(handle_, place)); }

void Statement::bind(int place, std::int64_t value) {
  check(sqlite3_bind_int64(handle_, place, value));
}

void Statement::bind(int place, double value) { check(sqlite3_bind_double(handle_, place, value)); }

void Statement::bind(int place, std::string_view value) {
  // A null pointer would bind NULL.
  check(sqlite3_bind_text(handle_, place, value.data() != nullptr ? value.data() : "",
                          static_cast<int>(value.size()), SQLITE_STATIC));
}

void Statement::bind(int place, Bytes value) {
  const void* data = value.empty() ? "" : static_cast<const void*>(value.data());
  check(sqlite3_bind_blob64(handle_, place, data, value.size(), SQLITE_STATIC));
}

}  // namespace somas::run
