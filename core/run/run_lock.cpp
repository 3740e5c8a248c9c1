#include "core/run/run_lock.hpp"

#include <cerrno>
#include <fcntl.h>
#include <string>
#include <unistd.h>
#include <utility>

#include <sys/file.h>
#include <sys/stat.h>

#include "core/run/files.hpp"

namespace somas::run {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& directory, int descriptor) {
  char owner[512] = {};
  const ssize_t length = ::pread(descriptor, owner, sizeof owner - 1, 0);
  std::string by = length > 0 ? std::string(owner, static_cast<std::size_t>(length)) : "";
  while (!by.empty() && by.back() == '\n') by.pop_back();
  throw UsageError(directory.string() + " is in use by " + (by.empty() ? "another process" : by) +
                   ": only one process at a time can work on a run");
}

/// False if the file was removed, or replaced, since it was opened.
bool still_there(const std::filesystem::path& file, int descriptor) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& directory) : file_(directory / file_name) {
  for (;;) {
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw WriteError(file_, errno);
    try {
      if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
        if (errno == EWOULDBLOCK) refuse(directory, descriptor_);
        throw WriteError(file_, errno);
      }
    } catch (...) {
      ::close(descriptor_);
      throw;
    }
    if (still_there(file_, descriptor_)) break;
    ::close(descriptor_);
  }
  // For people; a disk that is full keeps nobody from holding the lock.
  char host[256] = {};
  if (::gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
  const std::string owner =
      "process " + std::to_string(::getpid()) + " on " + (host[0] != '\0' ? host : "?") + "\n";
  if (::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0)
    errno = 0;
}

RunLock::RunLock(RunLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

RunLock::~RunLock() {
  if (descriptor_ < 0) return;
  ::unlink(file_.c_str());
  ::close(descriptor_);
}

}  // namespace somas::run
