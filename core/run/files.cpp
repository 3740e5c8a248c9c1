#include "core/run/files.hpp"

#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <memory>
#include <optional>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>
#include <xxhash.h>

#include <sys/stat.h>

namespace somas::run {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  /// 0, or the errno: some file systems report a full disk only here.
  [[nodiscard]] int close() { return ::close(std::exchange(fd_, -1)) == 0 ? 0 : errno; }

 private:
  int fd_;
};

/// 0 or the errno.
int write_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

/// 0 or the errno. Pipes and devices cannot be flushed, and need not be.
int flush_file(int fd) {
  if (::fsync(fd) == 0 || errno == EINVAL || errno == EROFS) return 0;
  return errno;
}

/// 0 or the errno.
int write_new(const std::filesystem::path& path, std::string_view content) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return errno;
  if (const int error = write_all(file.get(), content)) return error;
  if (const int error = flush_file(file.get())) return error;
  return file.close();
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  std::string name(".");
  name.append(path.filename().string()).append(".tmp").append(std::to_string(::getpid()));
  return path.parent_path() / name;
}

/// 0 or the errno. Keeps `from` if `to` exists.
int rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::link(from.c_str(), to.c_str()) != 0) return errno;
  ::unlink(from.c_str());
  return 0;
}

/// 0 or the errno.
int rename_over(const std::filesystem::path& from, const std::filesystem::path& to) {
  return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

/// Nothing there, at the end of all links: absent.
std::optional<struct stat> status_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status;
  if (errno != ENOENT) throw WriteError(path, errno);
  return std::nullopt;
}

/// The standard output or error, where `path` is what they lead to; else -1. A rename would part
/// the two.
int standard_stream(const struct stat& file) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat status {};
    if (::fstat(stream, &status) == 0 && status.st_dev == file.st_dev &&
        status.st_ino == file.st_ino)
      return stream;
  }
  return -1;
}

/// Devices and pipes.
void write_straight(const std::filesystem::path& path, std::string_view content) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
  int error = file.get() < 0 ? errno : write_all(file.get(), content);
  if (error == 0) error = file.close();
  if (error != 0) throw WriteError(path, error);
}

std::string hash_text(const XXH128_hash_t& hash) {
  char text[33];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text;
}

void write_and_rename(const std::filesystem::path& path, std::string_view content,
                      int (*put)(const std::filesystem::path&, const std::filesystem::path&)) {
  const std::filesystem::path temporary = temporary_beside(path);
  int error = write_new(temporary, content);
  if (error == 0) error = put(temporary, path);
  if (error != 0) {
    ::unlink(temporary.c_str());
    throw WriteError(path, error);
  }
  // A rename is durable once its directory is; the file itself is whole either way.
  flush_directory_of(path);
}

}  // namespace

WriteError::WriteError(const std::filesystem::path& path, int error)
    : std::runtime_error("cannot write " + path.string() + ": " + reason(error)),
      path_(path),
      error_(error) {}

void flush_directory_of(const std::filesystem::path& path) {
  const std::filesystem::path parent = path.has_parent_path() ? path.parent_path() : ".";
  const Descriptor directory(::open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() >= 0) ::fsync(directory.get());
}

void write_file(const std::filesystem::path& path, std::string_view content) {
  write_and_rename(path, content, rename_over);
}

std::filesystem::path target_of(const std::filesystem::path& path) {
  // Not weakly_canonical alone: it stops at a link to a file that is absent.
  std::filesystem::path target = std::filesystem::absolute(path);
  std::error_code error;
  for (int links = 0; links < 40 && std::filesystem::is_symlink(target, error); ++links) {
    const std::filesystem::path next = std::filesystem::read_symlink(target, error);
    if (error) break;
    target = target.parent_path() / next;
  }
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(target, error);
  return error ? target : resolved;
}

void write_output(const std::filesystem::path& path, std::string_view content) {
  const std::optional<struct stat> status = status_of(path);
  if (status) {
    if (S_ISDIR(status->st_mode)) throw WriteError(path, EISDIR);
    if (const int stream = standard_stream(*status); stream >= 0) {
      std::fflush(stdout);
      if (const int error = write_all(stream, content)) throw WriteError(path, error);
      return;
    }
    // Never a block device: nobody means to overwrite a disk.
    if (S_ISBLK(status->st_mode)) throw WriteError(path, EINVAL);
    if (!S_ISREG(status->st_mode) || status->st_nlink == 0) return write_straight(path, content);
  }
  write_file(target_of(path), content);
}

void check_output(const std::filesystem::path& path) {
  const std::optional<struct stat> status = status_of(path);
  if (status && S_ISDIR(status->st_mode)) throw WriteError(path, EISDIR);
  if (status && S_ISBLK(status->st_mode)) throw WriteError(path, EINVAL);
  if (status && standard_stream(*status) >= 0) return;
  if (status && ::access(path.c_str(), W_OK) != 0) throw WriteError(path, errno);
  if (status && !S_ISREG(status->st_mode)) return;
  if (!path.has_filename()) throw WriteError(path, EISDIR);
  const std::filesystem::path temporary = temporary_beside(target_of(path));
  const int error = write_new(temporary, "");
  ::unlink(temporary.c_str());
  if (error != 0) throw WriteError(path, error);
}

void create_file(const std::filesystem::path& path, std::string_view content) {
  write_and_rename(path, content, rename_to_new);
}

std::string read_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw UsageError("cannot read " + path.string() + ": is a directory");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw UsageError("cannot read " + path.string() + ": " + reason(errno));
  std::string content{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw UsageError("cannot read " + path.string() + ": " + reason(errno));
  return content;
}

std::string read_regular_file(const std::filesystem::path& path, std::uint64_t limit) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status) || std::filesystem::is_directory(status))
    return read_file(path);  // which says why not
  if (!std::filesystem::is_regular_file(status))
    throw UsageError("cannot read " + path.string() + ": not a regular file");
  if (std::filesystem::file_size(path, error) > limit)
    throw UsageError("cannot read " + path.string() + ": larger than " +
                     std::to_string(limit >> 20) + " MiB");
  return read_file(path);
}

std::string hash_of_file(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw UsageError("cannot read " + path.string() + ": " + reason(errno));

  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  const std::unique_ptr<XXH3_state_t, Free> state(XXH3_createState());
  XXH3_128bits_reset(state.get());
  std::vector<char> buffer(1u << 16);
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    XXH3_128bits_update(state.get(), buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  return hash_text(XXH3_128bits_digest(state.get()));
}

std::string hash_of_text(std::string_view text) {
  return hash_text(XXH3_128bits(text.data(), text.size()));
}

AppendFile::AppendFile(std::filesystem::path path, std::string_view beginning)
    : path_(std::move(path)) {
  write_file(path_, beginning);
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (descriptor_ < 0) throw WriteError(path_, errno);
  size_ = size_before_ = beginning.size();
}

AppendFile::~AppendFile() { ::close(descriptor_); }

void AppendFile::append(std::string_view piece) {
  size_before_ = size_;
  const int error = write_all(descriptor_, piece);
  size_ += piece.size();
  if (error == 0) return;
  undo();
  throw WriteError(path_, error);
}

void AppendFile::flush() {
  if (const int error = flush_file(descriptor_)) throw WriteError(path_, error);
}

void AppendFile::undo() noexcept {
  size_ = size_before_;
  // Cutting a file needs no space; should it fail all the same, there is nothing left to do.
  if (::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) ::fsync(descriptor_);
}

}  // namespace somas::run
