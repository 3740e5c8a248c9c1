// Frames into a movie file, by ffmpeg as a child process that reads raw pixels from a pipe.
//
// ffmpeg is looked for when a movie is made, on the PATH; nothing else of SOMAS needs it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include <sys/types.h>

#include "core/evaluation/stop.hpp"

namespace somas::report {

enum class MovieFormat { mp4, webm };

/// By the extension of a file's name. Throws run::UsageError, saying what is allowed.
[[nodiscard]] MovieFormat movie_format(const std::filesystem::path& file);

/// Thrown by whoever makes a movie when a stop was asked for.
struct Cancelled {};

class Encoder {
 public:
  struct Options {
    std::filesystem::path file;  ///< .mp4 (H.264) or .webm (VP9); replaced when it is finished
    std::uint32_t width = 0, height = 0;  ///< even
    double fps = 25;
    evaluation::StopToken stop = {};  ///< ends `add` and `finish` with Cancelled
  };
  /// Starts ffmpeg. Throws run::UsageError where there is none, run::WriteError.
  explicit Encoder(Options options);
  /// Without `finish`, ffmpeg is ended and nothing stays of the movie; what was there before does.
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  /// width x height pixels of 4 bytes: blue, green, red, nothing. Throws Cancelled, and
  /// run::WriteError with what ffmpeg said.
  void add(std::string_view pixels);
  /// Waits for ffmpeg and moves the movie into place. Throws as `add` does.
  void finish();

 private:
  void start();
  void wait_for_room();
  int wait();
  void end();
  [[noreturn]] void fail(int status);
  [[nodiscard]] std::string complaint() const;

  Options options_;
  std::filesystem::path target_, temporary_;
  std::FILE* errors_ = nullptr;  ///< what ffmpeg says; a file without a name
  pid_t child_ = 0;
  int pipe_ = -1;
};

}  // namespace somas::report
