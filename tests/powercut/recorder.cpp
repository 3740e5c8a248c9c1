// Preloaded into a process (LD_PRELOAD), keeps a log of what it does to the files below the
// directory $SOMAS_RECORD_DIRECTORY, in $SOMAS_RECORD_LOG. Memory maps are not seen; SQLite maps
// nothing but its index of the write-ahead log, which is made anew after a crash.
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <mutex>
#include <string>
#include <unistd.h>

#include <sys/stat.h>
#include <sys/syscall.h>

#include "tests/powercut/log.hpp"

namespace {

using somas::test::LogEntry;
using somas::test::Op;

std::recursive_mutex mutex;

/// The function of this name that would have been called.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int log_file() {
  static const int file = [] {
    const char* name = std::getenv("SOMAS_RECORD_LOG");
    if (name == nullptr) return -1;
    return static_cast<int>(
        ::syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  }();
  return file;
}

const std::string& root() {
  static const std::string directory = [] {
    const char* name = std::getenv("SOMAS_RECORD_DIRECTORY");
    return std::string(name != nullptr ? name : "");
  }();
  return directory;
}

/// The path below the directory; empty: somewhere else. "." is the directory itself.
std::string inside(const char* path) {
  if (root().empty() || path == nullptr) return "";
  std::string full = path;
  if (full[0] != '/') {
    char here[4096];
    if (::getcwd(here, sizeof here) == nullptr) return "";
    full = std::string(here) + "/" + full;
  }
  if (full == root()) return ".";
  if (full.compare(0, root().size() + 1, root() + "/") != 0) return "";
  return full.substr(root().size() + 1);
}

std::string inside(int descriptor) {
  char path[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = ::readlink(link.c_str(), path, sizeof path - 1);
  if (length <= 0) return "";
  path[length] = '\0';
  std::string name = path;
  constexpr const char* gone = " (deleted)";
  if (name.size() > std::strlen(gone) &&
      name.compare(name.size() - std::strlen(gone), std::string::npos, gone) == 0)
    name.resize(name.size() - std::strlen(gone));
  return inside(name.c_str());
}

std::uint64_t inode_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

std::uint64_t inode_of(const char* path) {
  struct stat status {};
  return ::stat(path, &status) == 0 ? status.st_ino : 0;
}

void put(Op op, std::uint64_t inode, std::uint64_t offset, const std::string& path,
         const void* data, std::size_t size) {
  if (log_file() < 0) return;
  LogEntry entry;
  entry.op = op;
  entry.inode = inode;
  entry.offset = offset;
  entry.path = static_cast<std::uint32_t>(path.size());
  entry.data = static_cast<std::uint32_t>(size);
  std::string bytes(reinterpret_cast<const char*>(&entry), sizeof entry);
  bytes += path;
  bytes.append(static_cast<const char*>(data), size);
  if (::syscall(SYS_write, log_file(), bytes.data(), bytes.size()) < 0) std::abort();
}

void put(Op op, const std::string& path, const std::string& other = "", std::uint64_t inode = 0) {
  put(op, inode, 0, path, other.data(), other.size());
}

int record_open(const char* path, int flags, mode_t mode) {
  const std::lock_guard lock(mutex);
  const std::string name = inside(path);
  const bool existed = inode_of(path) != 0;
  const int file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  if (name.empty() || file < 0) return file;
  if (!existed && (flags & O_CREAT) != 0) put(Op::create, name, "", inode_of(file));
  if (existed && (flags & O_TRUNC) != 0) put(Op::truncate, inode_of(file), 0, "", "", 0);
  return file;
}

int record_sync(int file, long call) {
  const std::lock_guard lock(mutex);
  const int result = static_cast<int>(::syscall(call, file));
  const std::string name = inside(file);
  if (result != 0 || name.empty()) return result;
  struct stat status {};
  if (::fstat(file, &status) != 0) return result;
  if (S_ISDIR(status.st_mode))
    put(Op::sync_dir, name);
  else
    put(Op::sync, name, "", status.st_ino);
  return result;
}

template <class Call>
int record_names(Op op, const char* path, const char* other, const Call& call) {
  const std::lock_guard lock(mutex);
  const std::string name = inside(path), new_name = other != nullptr ? inside(other) : "";
  const int result = call();
  if (result == 0 && !name.empty()) put(op, name, new_name);
  return result;
}

}  // namespace

#define SOMAS_EXPORT extern "C" __attribute__((visibility("default")))

SOMAS_EXPORT int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return record_open(path, flags, mode);
}

SOMAS_EXPORT int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return record_open(path, flags, mode);
}

SOMAS_EXPORT ssize_t write(int file, const void* data, size_t size) {
  const std::lock_guard lock(mutex);
  const std::string name = inside(file);
  off_t offset = 0;
  if (!name.empty()) {
    const bool appends = (::fcntl(file, F_GETFL) & O_APPEND) != 0;
    offset = ::lseek(file, 0, appends ? SEEK_END : SEEK_CUR);
  }
  const ssize_t written = ::syscall(SYS_write, file, data, size);
  if (written > 0 && !name.empty())
    put(Op::write, inode_of(file), static_cast<std::uint64_t>(offset), "", data,
        static_cast<std::size_t>(written));
  return written;
}

SOMAS_EXPORT ssize_t pwrite(int file, const void* data, size_t size, off_t offset) {
  const std::lock_guard lock(mutex);
  const ssize_t written = ::syscall(SYS_pwrite64, file, data, size, offset);
  if (written > 0 && !inside(file).empty())
    put(Op::write, inode_of(file), static_cast<std::uint64_t>(offset), "", data,
        static_cast<std::size_t>(written));
  return written;
}

SOMAS_EXPORT ssize_t pwrite64(int file, const void* data, size_t size, off64_t offset) {
  return pwrite(file, data, size, offset);
}

SOMAS_EXPORT int ftruncate(int file, off_t size) {
  const std::lock_guard lock(mutex);
  const int result = static_cast<int>(::syscall(SYS_ftruncate, file, size));
  if (result == 0 && !inside(file).empty())
    put(Op::truncate, inode_of(file), static_cast<std::uint64_t>(size), "", "", 0);
  return result;
}

SOMAS_EXPORT int ftruncate64(int file, off64_t size) { return ftruncate(file, size); }
SOMAS_EXPORT int fsync(int file) { return record_sync(file, SYS_fsync); }
SOMAS_EXPORT int fdatasync(int file) { return record_sync(file, SYS_fdatasync); }

SOMAS_EXPORT int rename(const char* from, const char* to) noexcept {
  return record_names(Op::rename, from, to,
                      [&] { return static_cast<int>(::syscall(SYS_rename, from, to)); });
}
SOMAS_EXPORT int link(const char* from, const char* to) noexcept {
  return record_names(Op::link, from, to,
                      [&] { return static_cast<int>(::syscall(SYS_link, from, to)); });
}
SOMAS_EXPORT int unlink(const char* path) noexcept {
  return record_names(Op::unlink, path, nullptr,
                      [&] { return static_cast<int>(::syscall(SYS_unlink, path)); });
}
SOMAS_EXPORT int remove(const char* path) noexcept {
  const int result = unlink(path);
  return result == 0 ? 0 : next<int(const char*)>("remove")(path);
}
SOMAS_EXPORT int mkdir(const char* path, mode_t mode) noexcept {
  return record_names(Op::make_dir, path, nullptr,
                      [&] { return static_cast<int>(::syscall(SYS_mkdir, path, mode)); });
}
