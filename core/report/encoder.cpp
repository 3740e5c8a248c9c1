#include "core/report/encoder.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <sys/wait.h>

#include "core/run/errors.hpp"
#include "core/run/files.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;

constexpr int patience = 20;  // milliseconds between looks at what else there is to do

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

std::vector<std::string> codec_of(MovieFormat format) {
  if (format == MovieFormat::webm)
    return {"-c:v", "libvpx-vp9", "-crf", "30",        "-b:v", "0",  "-row-mt",
            "1",    "-deadline",  "good", "-cpu-used", "4",    "-f", "webm"};
  // The index at the front: pages play it while it loads.
  return {"-c:v", "libx264",   "-preset",    "medium", "-crf",
          "20",   "-movflags", "+faststart", "-f",     "mp4"};
}

}  // namespace

MovieFormat movie_format(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension == ".mp4") return MovieFormat::mp4;
  if (extension == ".webm") return MovieFormat::webm;
  throw run::UsageError(file.string() + ": the name of a movie ends in .mp4 or .webm");
}

Encoder::Encoder(Options options)
    : options_(std::move(options)), target_(run::target_of(options_.file)) {
  temporary_ = target_.parent_path() /
               ("." + target_.filename().string() + ".tmp" + std::to_string(::getpid()));
  try {
    start();
  } catch (...) {
    end();
    throw;
  }
}

Encoder::~Encoder() { end(); }

void Encoder::start() {
  errors_ = std::tmpfile();
  if (errors_ == nullptr) throw run::WriteError(fs::temp_directory_path(), errno);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw run::WriteError(target_, errno);
  pipe_ = ends[1];
  // An encoder that hangs must not keep Ctrl-C waiting.
  ::fcntl(pipe_, F_SETFL, O_NONBLOCK);

  const MovieFormat format = movie_format(options_.file);
  std::vector<std::string> words{
      "ffmpeg",
      "-hide_banner",
      "-loglevel",
      "error",
      "-nostdin",
      "-y",
      "-f",
      "rawvideo",
      "-pixel_format",
      "bgr0",
      "-video_size",
      std::to_string(options_.width) + "x" + std::to_string(options_.height),
      "-framerate",
      number_text(options_.fps),
      "-i",
      "pipe:0"};
  for (std::string& word : codec_of(format)) words.push_back(std::move(word));
  words.insert(words.end(), {"-pix_fmt", "yuv420p", temporary_.string()});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, ::fileno(errors_), STDERR_FILENO);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  // A group of its own: Ctrl-C is ours to answer. The signals we set aside are back to normal.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  for (const int number : {SIGPIPE, SIGXFSZ}) sigaddset(&defaults, number);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  const int error =
      ::posix_spawnp(&child_, words[0].c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(ends[0]);
  if (error == 0) return;
  child_ = 0;
  throw run::UsageError(std::string("a movie needs ffmpeg, which cannot be started: ") +
                        std::strerror(error) +
                        "; install it (Debian: apt-get install ffmpeg) or put it on the PATH");
}

void Encoder::add(std::string_view pixels) {
  while (!pixels.empty()) {
    const ssize_t written = ::write(pipe_, pixels.data(), pixels.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EAGAIN) {
      wait_for_room();
      continue;
    }
    // A broken pipe: ffmpeg has ended, and said why.
    if (written < 0) fail(wait());
    pixels.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Encoder::wait_for_room() {
  pollfd room{.fd = pipe_, .events = POLLOUT, .revents = 0};
  while (::poll(&room, 1, patience) <= 0)
    if (options_.stop.stop_requested()) throw Cancelled{};
}

void Encoder::finish() {
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail(status);
  const int file = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
  int error = file < 0 || ::fsync(file) != 0 ? errno : 0;
  if (file >= 0) ::close(file);
  if (error == 0 && ::rename(temporary_.c_str(), target_.c_str()) != 0) error = errno;
  if (error != 0) throw run::WriteError(target_, error);
}

// The end of the pipe is the end of the movie.
int Encoder::wait() {
  if (pipe_ >= 0) ::close(std::exchange(pipe_, -1));
  int status = 0;
  while (child_ > 0) {
    const pid_t ended = ::waitpid(child_, &status, WNOHANG);
    if (ended != 0) break;
    if (options_.stop.stop_requested()) throw Cancelled{};
    ::poll(nullptr, 0, patience);
  }
  child_ = 0;
  return status;
}

void Encoder::end() {
  if (pipe_ >= 0) ::close(std::exchange(pipe_, -1));
  if (child_ > 0) {
    // With whatever it has started itself.
    ::kill(-child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  if (errors_ != nullptr) std::fclose(std::exchange(errors_, nullptr));
  ::unlink(temporary_.c_str());
}

std::string Encoder::complaint() const {
  std::string text;
  std::rewind(errors_);
  char piece[4096];
  // Enough to know; an encoder may repeat itself for ever.
  while (text.size() < 16'384) {
    const std::size_t count = std::fread(piece, 1, sizeof piece, errors_);
    if (count == 0) break;
    text.append(piece, count);
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

void Encoder::fail(int status) {
  std::string how = WIFSIGNALED(status) ? "was ended by signal " + std::to_string(WTERMSIG(status))
                                        : "ended with code " + std::to_string(WEXITSTATUS(status));
  const std::string said = complaint();
  throw run::WriteError("cannot write " + options_.file.string() + ": ffmpeg " + how +
                            (said.empty() ? " and said nothing" : ":\n" + said),
                        target_, EIO);
}

}  // namespace somas::report
