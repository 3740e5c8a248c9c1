#include "core/report/export.hpp"

#include <cctype>
#include <cerrno>
#include <system_error>
#include <unistd.h>

#include "core/recording/file.hpp"
#include "core/report/export_file.hpp"
#include "core/run/errors.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;

void check_absent_or_empty(const fs::path& out) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(out, error))) return;
  if (!fs::is_directory(out, error)) throw run::UsageError(out.string() + " is no directory");
  const bool empty = fs::is_empty(out, error);
  if (error) throw run::WriteError(out, error.value());
  if (!empty)
    throw run::UsageError("directory " + out.string() +
                          " is not empty: an export overwrites nothing; name another --out");
}

std::unique_ptr<recording::Sink> sink_of(ExportFormat format, const fs::path& directory) {
  switch (format) {
    case ExportFormat::csv:
      return csv_export(directory);
    case ExportFormat::vtp:
      return vtk_export(directory);
    default:
      return xyz_export(directory);
  }
}

struct Stopped {};

/// Hands on until it is asked to stop.
class Stoppable final : public recording::Sink {
 public:
  Stoppable(recording::Sink& next, evaluation::StopToken stop) : next_(next), stop_(stop) {}
  void begin(const recording::Header& header) override { next_.begin(header); }
  void event(const recording::Event& event) override { next_.event(event); }
  void summary(const recording::Summary& summary) override { next_.summary(summary); }
  void frame(const recording::Frame& frame) override {
    if (stop_.stop_requested()) throw Stopped();
    next_.frame(frame);
    ++frames_;
  }
  void finish(const recording::Ending& ending) override { next_.finish(ending); }
  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  recording::Sink& next_;
  evaluation::StopToken stop_;
  std::uint64_t frames_ = 0;
};

/// A directory that goes away unless it is given its name.
class Workplace {
 public:
  explicit Workplace(const fs::path& out)
      : out_(out),
        path_(out.parent_path() /
              ("." + out.filename().string() + ".tmp" + std::to_string(::getpid()))) {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error) throw run::WriteError(path_, error.value());
  }
  ~Workplace() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  /// Replaces an empty directory, too.
  void keep() const {
    std::error_code error;
    fs::rename(path_, out_, error);
    if (error) throw run::WriteError(out_, error.value());
  }

 private:
  fs::path out_, path_;
};

}  // namespace

std::optional<std::uint64_t> export_recording(const fs::path& file, ExportFormat format,
                                              const fs::path& out, evaluation::StopToken stop) {
  if (out.empty()) throw run::UsageError("--out: the name of the directory is empty");
  // "out/" names the same directory as "out".
  const fs::path target = out.has_filename() ? out : out.parent_path();
  try {
    (void)recording::read_header(file);
    check_absent_or_empty(target);
    const Workplace workplace(target);
    const std::unique_ptr<recording::Sink> sink = sink_of(format, workplace.path());
    Stoppable stoppable(*sink, stop);
    recording::read(file, stoppable);
    workplace.keep();
    return stoppable.frames();
  } catch (const recording::FileError& error) {
    throw run::UsageError(error.what());
  } catch (const Stopped&) {
    return std::nullopt;
  }
}

std::string file_part(std::string_view name) {
  std::string part;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ||
                       (c == '.' && !part.empty());
    part += plain ? c : '_';
  }
  return part;
}

ExportFile::ExportFile(fs::path path) : path_(std::move(path)) {
  errno = 0;
  out_.open(path_, std::ios::binary);
  if (!out_) fail();
}

void ExportFile::write(std::string_view text) {
  out_.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out_) fail();
}

void ExportFile::close() {
  out_.close();
  if (!out_) fail();
}

void ExportFile::fail() const { throw run::WriteError(path_, errno != 0 ? errno : EIO); }

}  // namespace somas::report
