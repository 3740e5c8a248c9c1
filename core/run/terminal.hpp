// A stream that people watch: lines that stay, and below them one status line that is redrawn.
#pragma once

#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>

namespace somas::run {

/// All calls may come from any thread.
class Terminal {
 public:
  /// `stream` must outlive this.
  explicit Terminal(std::FILE* stream);

  /// A person may be watching: a status line makes sense.
  [[nodiscard]] bool interactive() const { return interactive_; }
  /// Columns that a status line may take; 79 where the stream does not say.
  [[nodiscard]] std::size_t columns() const;
  /// A line that stays; the status line moves below it.
  void line(std::string_view text);
  /// Replaces the status line, cut to the width of the terminal; empty removes it. Does nothing
  /// unless interactive.
  void status(std::string_view text);

 private:
  void draw();

  std::FILE* stream_;
  bool interactive_;
  std::mutex mutex_;
  std::string status_;
};

}  // namespace somas::run
