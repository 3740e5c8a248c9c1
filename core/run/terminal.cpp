#include "core/run/terminal.hpp"

#include <cstdlib>
#include <unistd.h>

#include <sys/ioctl.h>

namespace somas::run {
namespace {

constexpr std::string_view clear_line = "\r\x1b[K";

std::size_t width_of(std::FILE* stream) {
  winsize size{};
  if (::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

bool is_interactive(std::FILE* stream) {
  const char* kind = std::getenv("TERM");
  return ::isatty(::fileno(stream)) == 1 && (kind == nullptr || std::string_view(kind) != "dumb");
}

}  // namespace

Terminal::Terminal(std::FILE* stream) : stream_(stream), interactive_(is_interactive(stream)) {}

// One column stays free, or some terminals wrap.
std::size_t Terminal::columns() const { return width_of(stream_) - 1; }

void Terminal::line(std::string_view text) {
  const std::scoped_lock lock(mutex_);
  std::string out;
  if (!status_.empty()) out += clear_line;
  out += text;
  out += '\n';
  std::fwrite(out.data(), 1, out.size(), stream_);
  if (!status_.empty()) draw();
  std::fflush(stream_);
}

void Terminal::status(std::string_view text) {
  if (!interactive_) return;
  const std::scoped_lock lock(mutex_);
  status_ = text;
  draw();
  std::fflush(stream_);
}

void Terminal::draw() {
  const std::string_view shown = std::string_view(status_).substr(0, columns());
  std::string out(clear_line);
  out += shown;
  std::fwrite(out.data(), 1, out.size(), stream_);
}

}  // namespace somas::run
